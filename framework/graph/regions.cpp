#include "framework/graph/regions.h"

#include <algorithm>

namespace ilss {

Regions::Regions(const Plan& plan, const std::vector<bool>& given)
    : place_(plan.nodes.size(), left_out), selector_of_node_(plan.nodes.size(), left_out) {
  find_places(plan, given);
  for (std::size_t i = 0; i < plan.nodes.size(); ++i) {
    if (place_[i] == every_tick) always_.push_back(i);
    if (!plan.nodes[i].type->selects || given[i]) continue;
    selector_of_node_[i] = selectors_.size();
    SelectorRegion& region = selectors_.emplace_back();
    for (std::size_t j = 0; j < i; ++j)
      if (is_within(j, i)) region.all.push_back(j);
    for (std::size_t k = 0; k < plan.nodes[i].inputs.size(); ++k)
      region.branches.push_back(find_branch(plan, given, i, k));
  }
}

/// Backwards through the plan, so that a node's place is known once all that it feeds has said
/// where it needs it.
void Regions::find_places(const Plan& plan, const std::vector<bool>& given) {
  for (const std::size_t output : plan.outputs) place_[output] = every_tick;
  for (const PlanCommand& command : plan.commands)
    if (command.driver) place_[command.driver->node] = every_tick;
  std::vector<char> feeds(plan.nodes.size(), 0);
  for (const PlanNode& node : plan.nodes)
    for (const PlanInput& input : node.inputs) feeds[input.node] = 1;
  for (std::size_t i = plan.nodes.size(); i-- > 0;) {
    if (feeds[i] == 0) place_[i] = every_tick;  // somebody may want to look at it
    if (given[i] || place_[i] == left_out) continue;
    const std::size_t needed_in = plan.nodes[i].type->selects ? i : place_[i];
    for (const PlanInput& input : plan.nodes[i].inputs)
      place_[input.node] = common_place(place_[input.node], needed_in);
  }
}

/// The innermost selector that two places are both in, or `every_tick`. Choices that stand in
/// others have smaller indices than these.
std::size_t Regions::common_place(std::size_t a, std::size_t b) const {
  if (a == left_out) return b;
  while (a != b) {
    if (a == every_tick || b == every_tick) return every_tick;
    if (a < b)
      a = place_[a];
    else
      b = place_[b];
  }
  return a;
}

/// Whether a node is in a selector's region, or in one of a selector there.
bool Regions::is_within(std::size_t node, std::size_t selector) const {
  std::size_t place = place_[node];
  while (place < selector) place = place_[place];
  return place == selector;
}

std::vector<std::size_t> Regions::find_branch(const Plan& plan, const std::vector<bool>& given,
                                              std::size_t selector, std::size_t input) const {
  const std::size_t root = plan.nodes[selector].inputs[input].node;
  std::vector<char> needed(root + 1, 0);
  needed[root] = 1;
  std::vector<std::size_t> branch;
  for (std::size_t i = root + 1; i-- > 0;) {
    if (needed[i] == 0) continue;
    if (place_[i] == selector) branch.push_back(i);
    if (given[i]) continue;
    for (const PlanInput& from : plan.nodes[i].inputs) needed[from.node] = 1;
  }
  std::reverse(branch.begin(), branch.end());
  return branch;
}

std::span<const std::size_t> Regions::on_demand(std::size_t selector) const {
  if (selector_of_node_[selector] == left_out) return {};
  return selectors_[selector_of_node_[selector]].all;
}

std::span<const std::size_t> Regions::branch(std::size_t selector, std::size_t input) const {
  return selectors_[selector_of_node_[selector]].branches[input];
}

}  // namespace ilss
