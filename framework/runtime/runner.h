// A plan at work with its instruments: how long each module takes, and how often it gives what.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "framework/graph/profile.h"
#include "framework/graph/system.h"
#include "framework/runtime/commander.h"
#include "framework/runtime/cycle_clock.h"
#include "framework/runtime/latency_histogram.h"
#include "framework/runtime/parallel_evaluation.h"

namespace ilss {

/// How often a module had which outcome; faults that came from above are counted, too.
struct OutcomeCounts {
  static constexpr std::size_t fault_kinds = static_cast<std::size_t>(FaultKind::internal) + 1;

  std::uint64_t outputs = 0;
  std::uint64_t pending = 0;
  std::array<std::uint64_t, fault_kinds> faults_by_kind = {};

  std::uint64_t faults(FaultKind kind) const {
    return faults_by_kind[static_cast<std::size_t>(kind)];
  }
  std::uint64_t faults() const {
    std::uint64_t sum = 0;
    for (const std::uint64_t count : faults_by_kind) sum += count;
    return sum;
  }
};

/// Runs a plan tick by tick in the caller's thread, or in several, and measures it. In one thread
/// the clock is read once at a tick's start and once after each module, so a module's time holds
/// what it takes to get at its inputs, and all modules' times add up to the tick's. Commands are
/// given before the tick starts and are not in its time. No memory is allocated from tick to tick.
class Runner {
 public:
  /// The plan must outlive the runner. Random numbers follow from `seed`, as System says.
  /// @pre threads > 0
  explicit Runner(const Plan& plan, std::uint64_t seed = 0, SystemOptions options = {},
                  unsigned threads = 1);

  /// Gives the modules the commands that are due, as Commander says, then evaluates the next tick
  /// at `time` (must not run backwards).
  void step(Time time);

  /// Takes a command from outside, to be given when its time has come.
  void schedule(ScheduledCommand command) { commander_.schedule(std::move(command)); }
  /// What commands came to, `given()` before the last tick.
  const Commander& commander() const { return commander_; }

  System& system() { return system_; }
  const System& system() const { return system_; }

  /// What the clock counted for each module in the last tick, also where it had nothing to do.
  std::span<const std::uint64_t> counts() const { return counts_; }
  /// The same (ns).
  std::uint64_t compute_ns(std::size_t node) const { return clock_.nanoseconds(0, counts_[node]); }
  /// What the whole last tick took (ns).
  std::uint64_t compute_ns() const { return tick_ns_; }
  /// Whether any module of the last tick has a fault.
  bool has_fault() const { return has_fault_; }

  /// A module's times over the ticks in which it gave an output or a fault of its own; those in
  /// which it was pending, or its inputs were at fault, say nothing of it.
  const LatencyHistogram& latency(std::size_t node) const { return latencies_[node]; }
  /// The times of whole ticks.
  const LatencyHistogram& end_to_end() const { return end_to_end_; }
  OutcomeCounts outcomes(std::size_t node) const;

  /// The modules' measured times: typical is the median, worst what one tick in 1,000 exceeds (the
  /// maximum of fewer ticks), so that in a long run a single interruption by the operating system
  /// does not decide. Modules that never worked are left out.
  Profile profile() const;

 private:
  void evaluate(Time time);
  void record(std::size_t node);

  System system_;
  Commander commander_;
  std::unique_ptr<ParallelEvaluation> parallel_;  ///< null in one thread
  const CycleClock& clock_;
  std::vector<std::uint64_t> counts_;  ///< of the clock, a node
  std::vector<LatencyHistogram> latencies_;
  std::vector<OutcomeCounts> rare_outcomes_;  ///< all but outputs, which are what is left
  LatencyHistogram end_to_end_;
  std::uint64_t tick_ns_ = 0;
  bool has_fault_ = false;
};

}  // namespace ilss
