#include "framework/graph/correlation.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>

namespace ilss {
namespace {

using Nodes = std::vector<std::size_t>;  // sorted

Nodes united(const Nodes& a, const Nodes& b) {
  Nodes result;
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(result));
  return result;
}

std::optional<std::size_t> first_common(const Nodes& a, const Nodes& b) {
  Nodes common;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
  return common.empty() ? std::nullopt : std::optional(common.front());
}

/// Whether random errors of earlier ticks live on in a node's output.
bool remembers(const PlanNode& node) { return node.type->remembers && !node.interface.forgets; }

/// Walks the plan, keeping for each node which blocks of joined errors its output may hold, and
/// which origins' errors of this tick it holds as they are.
class CorrelationSearch {
 public:
  explicit CorrelationSearch(const Plan& plan)
      : plan_(plan),
        blocks_(plan.nodes.size()),
        direct_(plan.nodes.size()),
        origins_(plan.nodes.size()) {}

  std::vector<UnknownCorrelation> run() {
    for (std::size_t i = 0; i < plan_.nodes.size(); ++i) visit(i);
    return std::move(found_);
  }

 private:
  void visit(std::size_t i) {
    const PlanNode& node = plan_.nodes[i];
    if (node.inputs.empty()) direct_[i] = {i};
    bool meets = false;
    for (std::size_t a = 0; a < node.inputs.size(); ++a) {
      const std::size_t input = node.inputs[a].node;
      for (std::size_t b = 0; b < a && !meets; ++b) meets = report(i, node.inputs[b].node, input);
      blocks_[i] = united(blocks_[i], blocks_[input]);
      direct_[i] = united(direct_[i], direct_[input]);
    }
    if (remembers(node) && !meets && !blocks_[i].empty()) {
      const std::size_t earlier = blocks_[i].front();
      found_.push_back({i, earlier, earlier, origins_[earlier].front()});
      meets = true;
    }
    // Where unknown correlation meets, the output's error is a bound, and a block like the others.
    const bool severs = node.type->severs || meets;
    if (!remembers(node) && !severs) return;
    origins_[i] = origins_of(i);
    blocks_[i] = {i};
    if (severs) direct_[i].clear();
  }

  /// Whether a node's block takes up its inputs' errors of this tick, too.
  bool severs(std::size_t block) const { return direct_[block].empty(); }

  /// Whether two inputs hold different blocks of a common origin, or one a block and the other the
  /// errors that went into it; reports the first such pair.
  bool report(std::size_t at, std::size_t a, std::size_t b) {
    return report_blocks(at, a, b) || report_direct(at, a, b) || report_direct(at, b, a);
  }

  bool report_direct(std::size_t at, std::size_t with_blocks, std::size_t direct) {
    const auto meets = [&](std::size_t block) {
      const auto origin =
          severs(block) ? first_common(origins_[block], direct_[direct]) : std::nullopt;
      if (origin) found_.push_back({at, block, direct, *origin});
      return origin.has_value();
    };
    return std::any_of(blocks_[with_blocks].begin(), blocks_[with_blocks].end(), meets);
  }

  bool report_blocks(std::size_t at, std::size_t a, std::size_t b) {
    for (const std::size_t first : blocks_[a])
      for (const std::size_t second : blocks_[b]) {
        if (first == second) continue;  // the same sources: their lineages tell
        const auto origin = first_common(origins_[first], origins_[second]);
        if (!origin) continue;
        found_.push_back({at, first, second, *origin});
        return true;
      }
    return false;
  }

  /// The sensors and estimators whose random errors reach a node.
  Nodes origins_of(std::size_t i) const {
    std::vector<char> reached(i + 1, 0);
    reached[i] = 1;
    Nodes result;
    for (std::size_t n = i + 1; n-- > 0;) {
      if (!reached[n]) continue;
      for (const PlanInput& input : plan_.nodes[n].inputs) reached[input.node] = 1;
      if (plan_.nodes[n].inputs.empty()) result.push_back(n);
    }
    std::reverse(result.begin(), result.end());
    return result;
  }

  const Plan& plan_;
  std::vector<Nodes> blocks_;   ///< of each node: nodes that join errors
  std::vector<Nodes> direct_;   ///< of each node: origins of errors of this tick
  std::vector<Nodes> origins_;  ///< of each such node: where these errors come from
  std::vector<UnknownCorrelation> found_;
};

}  // namespace

std::vector<UnknownCorrelation> find_unknown_correlations(const Plan& plan) {
  const bool any = std::any_of(plan.nodes.begin(), plan.nodes.end(), [](const PlanNode& node) {
    return remembers(node) || node.type->severs;
  });
  if (!any) return {};
  return CorrelationSearch(plan).run();
}

std::string describe(const UnknownCorrelation& unknown, const Plan& plan) {
  const std::string& at = plan.nodes[unknown.at].name;
  const std::string& first = plan.nodes[unknown.first].name;
  const std::string& origin = plan.nodes[unknown.origin].name;
  if (unknown.first == unknown.second)
    return fmt::format(
        "'{}' takes its ticks for independent, but '{}' holds earlier errors of '{}' in each", at,
        first, origin);
  return fmt::format(
      "inputs of '{}' are of unknown correlation: '{}' and '{}' both hold errors of '{}'", at,
      first, plan.nodes[unknown.second].name, origin);
}

}  // namespace ilss
