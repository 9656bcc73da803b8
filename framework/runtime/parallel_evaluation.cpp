#include "framework/runtime/parallel_evaluation.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <vector>

#include "framework/runtime/cycle_clock.h"

namespace ilss {
namespace {

/// Notes what the clock counts for the nodes that one thread evaluates, one after another.
class NodeTimer final : public NodeObserver {
 public:
  explicit NodeTimer(std::span<std::uint64_t> counts) : counts_(counts) {}
  void end_node(std::size_t node) override {
    const std::uint64_t now = clock_.now();
    counts_[node] = now - last_;
    last_ = now;
  }

 private:
  const CycleClock& clock_ = CycleClock::instance();
  std::span<std::uint64_t> counts_;
  std::uint64_t last_ = clock_.now();
};

}  // namespace

class ParallelEvaluation::Tasks {
 public:
  Tasks(System& system, unsigned threads)
      : system_(system),
        workers_(tbb::global_control::max_allowed_parallelism,
                 std::max<std::size_t>(threads,
                                       static_cast<std::size_t>(tbb::info::default_concurrency()))),
        arena_(static_cast<int>(
            std::min(threads, static_cast<unsigned>(std::numeric_limits<int>::max())))),
        followers_(system.size()),
        feeders_(system.size(), 0),
        waiting_(system.size()) {
    for (const std::size_t node : system.regions().always()) connect(node);
  }

  void evaluate(Time time, std::span<std::uint64_t> counts) {
    system_.begin_tick(time);
    std::fill(counts.begin(), counts.end(), 0);
    counts_ = counts;
    for (std::size_t i = 0; i < waiting_.size(); ++i)
      waiting_[i].store(feeders_[i], std::memory_order_relaxed);
    arena_.execute([this] {
      for (const std::size_t node : first_) start(node);
      tasks_.wait();
    });
    (void)ended_.load(std::memory_order_acquire);
  }

 private:
  /// What a node waits for: the always evaluated nodes that feed it or, of a selector, anything in
  /// its branches.
  void connect(std::size_t node) {
    std::vector<char> seen(node, 0);
    std::vector<std::size_t> to_ask = {node};
    while (!to_ask.empty()) {
      const std::size_t asked = to_ask.back();
      to_ask.pop_back();
      if (system_.is_given(asked)) continue;
      for (const PlanInput& input : system_.plan().nodes[asked].inputs) {
        if (seen[input.node] != 0) continue;
        seen[input.node] = 1;
        if (!system_.regions().is_always(input.node)) {
          to_ask.push_back(input.node);
        } else {
          followers_[input.node].push_back(node);
          ++feeders_[node];
        }
      }
    }
    if (feeders_[node] == 0) first_.push_back(node);
  }

  /// oneTBB orders what was done before a task is run, what it does, and what comes after the wait;
  /// `started_` and `ended_` say the same once more, since the thread sanitizer does not see into
  /// that library.
  void start(std::size_t node) {
    started_.fetch_add(1, std::memory_order_release);
    tasks_.run([ this, node ]() __attribute__((no_sanitize("thread"))) { work_from(node); });
  }

  /// Evaluates a node, then one of those that only waited for it, and so on; others are started.
  void work_from(std::size_t node) {
    (void)started_.load(std::memory_order_acquire);
    NodeTimer timer(counts_);
    for (;;) {
      system_.evaluate_node(node, &timer);
      timer.end_node(node);
      std::size_t next = node;
      for (const std::size_t follower : followers_[node]) {
        if (waiting_[follower].fetch_sub(1, std::memory_order_acq_rel) != 1) continue;
        if (next == node)
          next = follower;
        else
          start(follower);
      }
      if (next == node) break;
      node = next;
    }
    ended_.fetch_add(1, std::memory_order_release);
  }

  System& system_;
  tbb::global_control workers_;  ///< more than the machine has, where more are asked for
  tbb::task_arena arena_;
  tbb::task_group tasks_;
  std::vector<std::size_t> first_;                   ///< nodes that wait for nothing
  std::vector<std::vector<std::size_t>> followers_;  ///< of each node
  std::vector<std::uint32_t> feeders_;               ///< of each node, how many
  std::vector<std::atomic<std::uint32_t>> waiting_;  ///< of these, how many are not done
  std::atomic<std::uint64_t> started_ = 0;
  std::atomic<std::uint64_t> ended_ = 0;
  std::span<std::uint64_t> counts_;
};

ParallelEvaluation::ParallelEvaluation(System& system, unsigned threads)
    : tasks_(std::make_unique<Tasks>(system, threads)) {}
ParallelEvaluation::~ParallelEvaluation() = default;

void ParallelEvaluation::evaluate(Time time, std::span<std::uint64_t> counts) {
  tasks_->evaluate(time, counts);
}

}  // namespace ilss
