// A run of a system: when it ends, who commands it and who looks on. The
// command, programs and other hosts drive this one object; it prints nothing.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "framework/runtime/characteristic_output.h"
#include "framework/runtime/pacing.h"
#include "framework/runtime/runner.h"

namespace ilss {

/// How a run is set up.
struct RunOptions {
  Pacing pacing = Pacing::simulated;
  Duration period = std::chrono::milliseconds(100);  ///< above 0
  std::int64_t most_ticks = 0;                       ///< 0: no limit
  std::uint64_t seed = 1;                            ///< of all random numbers
  Folding folding = Folding::per_owner;
  unsigned threads = 1;
  /// Judges the outputs of one tick in so many, from the first on; 0: of none. Without a number,
  /// those of the ticks for which an observer asks.
  std::optional<std::int64_t> judge_every = {};
  StandIns stand_ins = {};                      ///< who takes which module's place; may be empty
  std::vector<ScheduledCommand> commands = {};  ///< times count from the first tick
  /// Ends the run before the next tick once it is set, by a signal's handler or another thread.
  const std::atomic<bool>* interrupted = nullptr;
};

/// Why a run is over.
enum class RunEnd {
  end_of_data,  ///< a module's source has no more
  device_lost,  ///< a module's source cannot be read any more
  most_ticks,
  interrupted,
};
std::string_view run_end_name(RunEnd end);

/// The end of a run, and the module and fault that ended it where one did.
struct Ending {
  RunEnd reason;
  const PlanNode* module = nullptr;
  Fault fault = {};
};

/// Runs a plan to its end, tick by tick in the caller's thread. No memory is allocated from tick to
/// tick, but by modules at fault, by commands and by observers.
class Run {
 public:
  /// The plan must outlive the run.
  Run(const Plan& plan, RunOptions options);

  /// Adds one who looks on, asked and told in the order added; must outlive the run.
  void add(Observer& observer) { observers_.push_back(&observer); }

  /// Opens what the modules read, and says what cannot be opened, at the module's place in the
  /// graph, or that no module's data have times of their own where those are to give the ticks.
  /// Whether the run can start.
  [[nodiscard]] bool open(Diagnostics& diagnostics);

  /// The next tick: waits for its time, gives the commands that are due, evaluates, judges where
  /// that is asked for, and lets the observers look. False where the run is over instead. The tick
  /// in which a source turns out to be at its end is none; one in which a device is lost is the
  /// last. @pre It is open.
  bool step();

  /// Steps to the end.
  const Ending& finish();

  /// Set once the run is over.
  const std::optional<Ending>& ending() const { return ending_; }

  /// Takes a command from outside; its time counts from the first tick.
  void schedule(ScheduledCommand command);

  std::int64_t ticks() const { return ticks_; }
  /// How many commands from outside wait for their time.
  std::size_t waiting_commands() const {
    return options_.commands.size() + runner_.commander().waiting();
  }
  /// How many of them were judged.
  std::int64_t judged_ticks() const { return judged_ticks_; }
  /// How many verdicts there were on these, one an output.
  std::int64_t verdicts() const { return verdicts_; }
  /// Periods of the real clock that went by while a tick took longer.
  std::int64_t missed_periods() const { return pacer_.missed_periods(); }
  /// The last tick. @pre There was one.
  const TickView& last() const { return *view_; }

  const Plan& plan() const { return plan_; }
  const Runner& runner() const { return runner_; }
  System& system() { return runner_.system(); }

 private:
  void start_at(Time time);
  OutputRange wanted_verdicts() const;
  std::span<const VerdictReport> judge(OutputRange outputs);
  bool ends_with(FaultKind kind, RunEnd reason);
  bool end(RunEnd reason) { return ending_ = Ending{reason}, false; }

  const Plan& plan_;
  RunOptions options_;
  Runner runner_;
  Pacer pacer_;
  std::vector<Observer*> observers_;
  std::optional<Ending> ending_;
  std::optional<TickView> view_;
  std::optional<Judge> judge_;  ///< of `judged_`, made when it is needed
  OutputRange judged_;
  std::int64_t ticks_ = 0;
  std::int64_t judged_ticks_ = 0;
  std::int64_t verdicts_ = 0;
  std::optional<Time> first_;  ///< the first tick's time
};

}  // namespace ilss
