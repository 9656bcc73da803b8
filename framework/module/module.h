// The logical sensor: what every module, physical or computed, built in or plugged in, must do.
#pragma once

#include <cstdint>
#include <optional>
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
  Time time = {};
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

/// An instruction from the top: a declared name, its value, and when it is given: from the last
/// tick's time to the next one's, so that what moves can start in between.
struct Command {
  std::string name;
  CommandValue value;
  Time time = {};
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

  /// Opens what the module reads (files, devices), before the first tick; what is open already
  /// stays so. A fault is an error of the run's start. Nothing is evaluated unless this gave none.
  virtual Outcome<> open() { return {}; }

  /// Closes what it has opened, after the last tick.
  virtual void close() {}

  /// When the data that the next evaluation gives were acquired, by the clock of what they come
  /// from (a log's stamps). Nothing where there is no such clock, or no more data. Asked for only
  /// while the module is open.
  virtual std::optional<Time> next_time() { return std::nullopt; }

  /// Evaluates one tick into `output`, whose type and frame are set, whose `acquired` is the range
  /// of its inputs' (or the tick's time) and whose buffers hold an earlier tick. The estimate's
  /// lineage must be complete: the inputs' sources mapped through, the module's own noise as
  /// `fresh` columns. Must leave `output` alone when pending; on a fault `output` is not used.
  virtual Outcome<> evaluate(const Evaluation& evaluation, Output& output) = 0;

  /// As `evaluate`, but for prediction: the output with its *expected* error, without acquiring.
  /// `operating_point` is the value at which to say it, with no error of its own and NaN for
  /// components that the module knows itself (a sonar's mount), or null where it must know all.
  /// By default a module without an operating point evaluates, and one with an operating point
  /// knows no error for it. Nobody opens a module for this: one that cannot do without its data
  /// opens them itself.
  virtual Outcome<> expect(const Evaluation& evaluation, const Output* operating_point,
                           Output& output) {
    if (operating_point != nullptr)
      return Fault{FaultKind::no_error_known, "the module declares no expected error"};
    if (Outcome<> outcome = open(); outcome.is_fault()) return outcome;
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

  /// Back to the state after construction; what is open stays open.
  virtual void reset() {}
};

/// What a selector may ask of its branches in a tick.
class Branches {
 public:
  virtual ~Branches() = default;
  virtual std::size_t size() const = 0;
  /// Evaluates the modules that only this branch needs, once a tick, and tells what it came to.
  virtual const Outcome<>& evaluate(std::size_t branch) = 0;
  /// What the branch gave last, also in an earlier tick; null where there is nothing.
  virtual const Output* output(std::size_t branch) const = 0;
};

/// A module that selects one of its inputs. The modules that only its branches need are evaluated
/// when it asks for them, and what it selects is passed on as it is: nothing is copied.
class Selector : public Module {
 public:
  /// The branch whose output is this module's in this tick; it must have been evaluated.
  virtual Outcome<std::size_t> select(const Evaluation& evaluation, Branches& branches) = 0;

  Outcome<> evaluate(const Evaluation&, Output&) final {
    return Fault{FaultKind::internal, "a selector has no output of its own"};
  }
};

}  // namespace ilss
