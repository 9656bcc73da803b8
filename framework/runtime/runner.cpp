#include "framework/runtime/runner.h"

namespace ilss {
namespace {

/// Notes the clock's readings; what follows from them waits for the tick's end, since conversions
/// between the readings would count as the modules' time.
struct ClockReader {
  const CycleClock& clock;
  std::uint64_t* next;

  void begin_tick() { *next++ = clock.now(); }
  void end_node(std::size_t /*node*/) { *next++ = clock.now(); }
  void end_tick() {}
};

}  // namespace

Runner::Runner(const Plan& plan, std::uint64_t seed, Folding folding)
    : system_(plan, seed, folding),
      commander_(plan),
      clock_(CycleClock::instance()),
      readings_(plan.nodes.size() + 1),
      compute_ns_(plan.nodes.size()),
      latencies_(plan.nodes.size()),
      outcomes_(plan.nodes.size()) {}

void Runner::step(Time time) {
  commander_.give(system_, time);
  ClockReader reader{clock_, readings_.data()};
  system_.evaluate(time, reader);
  for (std::size_t i = 0; i < system_.size(); ++i) record(i);
  tick_ns_ = clock_.nanoseconds(readings_.front(), readings_.back());
  end_to_end_.record(tick_ns_);
}

void Runner::record(std::size_t node) {
  const NodeState& state = system_.node(node);
  OutcomeCounts& counts = outcomes_[node];
  compute_ns_[node] = clock_.nanoseconds(readings_[node], readings_[node + 1]);
  if (state.outcome.is_pending()) {
    ++counts.pending;
    return;
  }
  if (state.outcome.has_output()) {
    ++counts.outputs;
  } else {
    ++counts.faults_by_kind[static_cast<std::size_t>(state.outcome.fault().kind)];
    if (state.origin != node) return;
  }
  latencies_[node].record(compute_ns_[node]);
}

Profile Runner::profile() const {
  constexpr double nanoseconds_per_second = 1e9;
  Profile profile{.plan = system_.plan().name};
  for (std::size_t i = 0; i < latencies_.size(); ++i) {
    if (latencies_[i].count() == 0) continue;
    const LatencySummary summary = latencies_[i].summary();
    profile.modules.push_back({system_.plan().nodes[i].name,
                               {static_cast<double>(summary.p50) / nanoseconds_per_second,
                                static_cast<double>(summary.p999) / nanoseconds_per_second}});
  }
  return profile;
}

}  // namespace ilss
