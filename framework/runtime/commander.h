// Commands on their way to the modules of a running system, between its ticks.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "framework/graph/scheduled_command.h"
#include "framework/graph/system.h"

namespace ilss {

/// A command as given to its module, and what came of it: anything but a fault is done, a fault
/// says why it is not.
struct GivenCommand {
  std::size_t command = 0;  ///< which of the plan's
  CommandValue value;
  Outcome<> outcome;
};

/// Gives a plan's modules their commands between ticks. First those that outputs of the tick before
/// drive, in the plan's order and with that tick's time; then those from outside that are due, by
/// time and then in the order they were scheduled. So whoever commands from outside has the last
/// word until the next driven value, and the same schedule gives the same run. Memory is allocated
/// by `schedule`, and by commands of text and refusals; driven ones need none.
class Commander {
 public:
  /// The plan must outlive it.
  explicit Commander(const Plan& plan);

  /// @pre The command is one of the plan's, its value of the declared kind, its time a number.
  void schedule(ScheduledCommand command);

  /// Gives what is due before the next tick, at `time`.
  void give(System& system, Time time) {
    if (!idle()) [[unlikely]]
      give_due(system, time);
    last_tick_ = time;
  }

  /// What the last call of `give` gave, in order.
  std::span<const GivenCommand> given() const { return given_; }
  /// How many commands were refused or failed so far.
  std::uint64_t refused() const { return refused_; }
  /// How many commands from outside wait for their time.
  std::size_t waiting() const { return scheduled_.size() - next_; }

 private:
  /// A command that outputs drive, with its name set beforehand.
  struct Drive {
    std::size_t command;
    CommandDriver from;
    Command instruction;
  };

  /// Whether no command is driven, waits, or was given last time.
  bool idle() const { return drives_.empty() && waiting() == 0 && given_.empty(); }
  void give_due(System& system, Time time);
  void give_driven(System& system);
  void give_instruction(System& system, std::size_t command, const Command& instruction);

  const Plan* plan_;
  std::vector<Drive> drives_;
  std::vector<ScheduledCommand> scheduled_;  ///< by time; those before `next_` were given
  std::size_t next_ = 0;
  std::vector<GivenCommand> given_;
  std::uint64_t refused_ = 0;
  Time last_tick_ = {};  ///< its time
};

}  // namespace ilss
