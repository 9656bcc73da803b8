#include "framework/runtime/runner.h"

#include <algorithm>

namespace ilss {
namespace {

/// Notes what the clock counts for each node; what follows from it waits for the tick's end, since
/// conversions between the readings would count as the modules' time.
class ClockReader final : public NodeObserver {
 public:
  ClockReader(const CycleClock& clock, std::uint64_t* counts) : clock_(clock), counts_(counts) {}

  void begin_tick() { first_ = last_ = clock_.now(); }
  void end_node(std::size_t node) override {
    const std::uint64_t now = clock_.now();
    counts_[node] = now - last_;
    last_ = now;
  }
  void end_tick() {}
  std::uint64_t nanoseconds() const { return clock_.nanoseconds(first_, last_); }

 private:
  const CycleClock& clock_;
  std::uint64_t* counts_;
  std::uint64_t first_ = 0;
  std::uint64_t last_ = 0;
};

}  // namespace

Runner::Runner(const Plan& plan, std::uint64_t seed, SystemOptions options, unsigned threads)
    : system_(plan, seed, std::move(options)),
      commander_(plan),
      parallel_(threads > 1 ? std::make_unique<ParallelEvaluation>(system_, threads) : nullptr),
      clock_(CycleClock::instance()),
      counts_(plan.nodes.size()),
      latencies_(plan.nodes.size()),
      rare_outcomes_(plan.nodes.size()) {}

void Runner::step(Time time) {
  commander_.give(system_, time);
  has_fault_ = false;
  evaluate(time);
  for (std::size_t i = 0; i < system_.size(); ++i) record(i);
  end_to_end_.record(tick_ns_);
}

void Runner::evaluate(Time time) {
  if (parallel_ != nullptr) {
    const std::uint64_t begin = clock_.now();
    parallel_->evaluate(time, counts_);
    tick_ns_ = clock_.nanoseconds(begin, clock_.now());
    return;
  }
  if (system_.regions().always().size() != counts_.size())
    std::fill(counts_.begin(), counts_.end(), 0);  // not all nodes have their turn
  ClockReader reader(clock_, counts_.data());
  system_.evaluate(time, reader);
  tick_ns_ = reader.nanoseconds();
}

/// Mostly there is an output, whose time is all there is to keep.
void Runner::record(std::size_t node) {
  const NodeState& state = system_.node(node);
  if (!state.outcome.has_output()) [[unlikely]] {
    OutcomeCounts& counts = rare_outcomes_[node];
    if (state.outcome.is_pending()) {
      ++counts.pending;
      return;
    }
    has_fault_ = true;
    ++counts.faults_by_kind[static_cast<std::size_t>(state.outcome.fault().kind)];
    if (state.origin != node) return;
  }
  latencies_[node].record(compute_ns(node));
}

OutcomeCounts Runner::outcomes(std::size_t node) const {
  OutcomeCounts counts = rare_outcomes_[node];
  counts.outputs = static_cast<std::uint64_t>(system_.ticks()) - counts.pending - counts.faults();
  return counts;
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
