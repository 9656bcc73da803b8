// The logical sensor: what every module, physical or computed, built in or plugged in, must do.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "framework/estimate/random.h"
#include "framework/module/outcome.h"
#include "framework/module/output.h"

namespace ilss {

/// All that a module may know when it evaluates a tick. Time and randomness come from here alone,
/// so that the same input and seed give the same output.
struct Evaluation {
  std::int64_t tick = 0;
  double time = 0;                        ///< s since the start of the run
  std::uint64_t seed = 0;                 ///< of this module at this tick
  std::uint32_t owner = 0;                ///< owner of the sources this module makes
  const Estimate& parameters;             ///< the module's quantities, in declared order
  std::span<const Output* const> inputs;  ///< in declared order; never null
  bool correlation_unknown = false;       ///< of some two inputs, whatever their lineages say
  std::uint64_t run_seed = 0;             ///< of this module in this run, the same at every tick

  /// A source of this module at this tick.
  Source fresh(std::uint32_t column) const { return {owner, column, tick}; }
  const Estimate& input(std::size_t i) const { return inputs[i]->estimate; }
  RandomBits random() const { return RandomBits(seed); }
  /// The module's seed at any tick: what lasts longer than one follows from its first, so that it
  /// does not depend on which tick was asked first.
  std::uint64_t seed_at(std::int64_t other) const {
    return derive_seed(run_seed, static_cast<std::uint64_t>(other));
  }
};

/// A command's value as declared: a quantity (in the SI unit) or number is a double, a text or
/// choice a string.
using CommandValue = std::variant<std::monostate, double, std::int64_t, bool, std::string>;

/// An instruction from the top: a declared name, its value, and when it is given (s since the
/// start): from the last tick's time to the next one's, so that what moves can start in between.
struct Command {
  std::string name;
  CommandValue value;
  double time = 0;
};

/// What an embedded test found.
struct TestReport {
  std::string name;
  bool passed;
  std::string detail;
};

/// One logical sensor. Instances belong to one running system and are called by one thread at a
/// time. An exception that leaves a call becomes a fault `internal`.
class Module {
 public:
  virtual ~Module() = default;
  Module() = default;
  Module(const Module&) = delete;
  Module& operator=(const Module&) = delete;

  /// Evaluates one tick into `output`, whose type and frame are set, whose `acquired` is the oldest
  /// input's (or the tick's time) and whose buffers hold an earlier tick. The estimate's lineage
  /// must be complete: the inputs' sources mapped through, the module's own noise as `fresh`
  /// columns. Must leave `output` alone when pending; on a fault `output` is not used.
  virtual Outcome<> evaluate(const Evaluation& evaluation, Output& output) = 0;

  /// As `evaluate`, but for prediction: the output with its *expected* error, without acquiring.
  /// `operating_point` is the value at which to say it, with no error of its own and NaN for
  /// components that the module knows itself (a sonar's mount), or null where it must know all.
  /// By default a module without an operating point evaluates, and one with an operating point
  /// knows no error for it.
  virtual Outcome<> expect(const Evaluation& evaluation, const Output* operating_point,
                           Output& output) {
    if (operating_point != nullptr)
      return Fault{FaultKind::no_error_known, "the module declares no expected error"};
    return evaluate(evaluation, output);
  }

  /// Follows a declared command between ticks, or refuses it: with the fault `refused` and a
  /// reason, and then nothing has changed. The framework checks the value's kind and unit, not its
  /// range.
  virtual Outcome<> command(const Command& command) {
    return Fault{FaultKind::refused, "the module knows no command '" + command.name + "'"};
  }

  /// Runs the module's embedded tests.
  virtual std::vector<TestReport> run_tests(const Evaluation&) { return {}; }

  /// What the user of a run should be told beyond its ticks' outcomes, such as how many lines of a
  /// recording were left out; one line, empty where there is nothing to tell.
  virtual std::string note() const { return {}; }

  /// Back to the state after construction.
  virtual void reset() {}
};

}  // namespace ilss
