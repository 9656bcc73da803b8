#include "framework/semantics/time_prediction.h"

#include <algorithm>
#include <optional>

namespace ilss {
namespace {

/// Longest path to each node's end by one kind of time, and the node it comes from.
struct LongestPaths {
  std::vector<double> end;
  std::vector<std::optional<std::size_t>> before;
};

LongestPaths longest_paths(const Plan& plan, double ModuleTime::*kind) {
  LongestPaths paths{std::vector<double>(plan.nodes.size(), 0.0),
                     std::vector<std::optional<std::size_t>>(plan.nodes.size())};
  for (std::size_t i = 0; i < plan.nodes.size(); ++i) {
    const PlanNode& node = plan.nodes[i];
    double start = 0;
    for (const PlanInput& input : node.inputs)
      if (!paths.before[i] || paths.end[input.node] > start) {
        start = paths.end[input.node];
        paths.before[i] = input.node;
      }
    paths.end[i] = start + (node.time ? (*node.time).*kind : 0.0);
  }
  return paths;
}

}  // namespace

TimePrediction predict_time(const Plan& plan, Execution execution) {
  TimePrediction prediction;
  for (std::size_t i = 0; i < plan.nodes.size(); ++i)
    if (!plan.nodes[i].time) prediction.unknown.push_back(i);
  if (execution == Execution::one_thread) {
    for (std::size_t i = 0; i < plan.nodes.size(); ++i) {
      prediction.critical_path.push_back(i);
      if (!plan.nodes[i].time) continue;
      prediction.typical += plan.nodes[i].time->typical;
      prediction.worst += plan.nodes[i].time->worst;
    }
    return prediction;
  }
  const LongestPaths typical = longest_paths(plan, &ModuleTime::typical);
  const LongestPaths worst = longest_paths(plan, &ModuleTime::worst);
  std::optional<std::size_t> last;
  for (const std::size_t output : plan.outputs) {
    prediction.typical = std::max(prediction.typical, typical.end[output]);
    if (!last || worst.end[output] > worst.end[*last]) last = output;
  }
  if (!last) return prediction;
  prediction.worst = worst.end[*last];
  for (std::optional<std::size_t> at = last; at; at = worst.before[*at])
    prediction.critical_path.push_back(*at);
  std::reverse(prediction.critical_path.begin(), prediction.critical_path.end());
  return prediction;
}

}  // namespace ilss
