// What a module came to in a tick, as one object: data, times, outcome, compute time and verdict.
// Monitors, taps, recorders, reports and live views look at this and at nothing else.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "framework/graph/system.h"
#include "framework/runtime/commander.h"
#include "framework/runtime/cycle_clock.h"
#include "framework/semantics/verdict.h"

namespace ilss {

/// "output", "pending" or "fault".
std::string_view outcome_name(const Outcome<>& outcome);

/// A module's characteristic output vector at a tick. A view: what it points to lives until the
/// next tick.
struct CharacteristicOutput {
  std::int64_t tick;  ///< from 0
  Time time;          ///< of the evaluation
  std::size_t node;   ///< in the plan
  const PlanNode& module;
  const Outcome<>& outcome;
  const PlanNode* origin;  ///< whose fault it is; null where the outcome is none
  const Output* output;    ///< what the module gave in this tick; null where it gave nothing
  const Output* latest;    ///< the same, or held while the module is pending; null after a fault
  Duration compute_time;   ///< also of a module that had nothing to do; 0 where not measured
  const VerdictReport* verdict;  ///< on this output; null where nobody asked for one

  /// When the latest data were acquired, from the oldest to the newest.
  std::optional<Acquisition> acquired() const {
    return latest == nullptr ? std::nullopt : std::optional(latest->acquired);
  }
  /// The time since the oldest of these data were acquired.
  std::optional<Duration> age() const {
    return latest == nullptr ? std::nullopt : std::optional(age_of(latest->acquired.oldest, time));
  }
};

/// Some of a system's outputs, one after another.
struct OutputRange {
  std::size_t first = 0;
  std::size_t count = 0;

  bool operator==(const OutputRange&) const = default;
};

/// One tick of a system as observers see it; valid until the next one. Makes its views on the fly:
/// nothing is copied or allocated.
class TickView {
 public:
  /// What a system does not know of its tick: what the clock counted for each node and for the
  /// whole tick, the verdicts on its outputs, the commands given before it. Each may be left out.
  struct Beside {
    std::span<const std::uint64_t> counts = {};
    Duration compute_time = {};
    std::span<const VerdictReport> verdicts = {};
    std::size_t first_judged = 0;  ///< the output that the first verdict is on
    std::span<const GivenCommand> commands = {};
  };

  explicit TickView(const System& system) : system_(&system) {}
  TickView(const System& system, Beside beside) : system_(&system), beside_(beside) {}

  std::int64_t tick() const { return system_->ticks() - 1; }
  Time time() const { return system_->time(); }
  const Plan& plan() const { return system_->plan(); }

  /// How many nodes there are, and what each of them came to.
  std::size_t size() const { return system_->size(); }
  CharacteristicOutput operator[](std::size_t node) const { return view(node, verdict_on(node)); }

  /// The same of the system's outputs, in the plan's order.
  std::size_t outputs() const { return plan().outputs.size(); }
  CharacteristicOutput output(std::size_t o) const {
    return view(plan().outputs[o], verdict_on_output(o));
  }
  /// The output that says what the whole system came to: the first with a fault, or else the last
  /// that is pending, or else the first.
  CharacteristicOutput deciding_output() const;

  /// The outputs that there are verdicts on.
  OutputRange judged() const { return {beside_.first_judged, beside_.verdicts.size()}; }
  /// The time of the whole tick, commands and verdicts apart.
  Duration compute_time() const { return beside_.compute_time; }
  /// The commands given before this tick, in order.
  std::span<const GivenCommand> commands() const { return beside_.commands; }

 private:
  CharacteristicOutput view(std::size_t node, const VerdictReport* verdict) const;
  const VerdictReport* verdict_on(std::size_t node) const;
  const VerdictReport* verdict_on_output(std::size_t o) const {
    const std::size_t i = o - beside_.first_judged;  // of an earlier one it wraps to a large one
    return i < beside_.verdicts.size() ? &beside_.verdicts[i] : nullptr;
  }

  const System* system_;
  Beside beside_ = {};
};

/// Looks at the ticks of a run, in its thread; what takes long must be handed on.
class Observer {
 public:
  virtual ~Observer() = default;

  /// The outputs of this tick that are to be judged; none of them is yet.
  virtual OutputRange wants_verdicts(const TickView&) { return {}; }

  virtual void observe(const TickView& tick) = 0;
};

}  // namespace ilss
