#include "framework/graph/folding.h"

namespace ilss {

PostDominators::PostDominators(const Plan& plan) {
  // A virtual sink behind the outputs is node n. A node that feeds nothing leads to it, too.
  const std::size_t n = plan.nodes.size();
  std::vector<std::vector<std::size_t>> followers(n);
  for (std::size_t i = 0; i < n; ++i)
    for (const PlanInput& input : plan.nodes[i].inputs) followers[input.node].push_back(i);
  for (const std::size_t output : plan.outputs) followers[output].push_back(n);
  std::vector<std::size_t> parent(n + 1, n);
  // Consumers come later in evaluation order, so going backwards each parent is known already, and
  // the closest common post-dominator is found by walking the one with the smaller index upwards.
  for (std::size_t i = n; i-- > 0;) {
    std::size_t common = followers[i].empty() ? n : followers[i].front();
    for (std::size_t other : followers[i]) {
      while (common != other) {
        if (common < other)
          common = parent[common];
        else
          other = parent[other];
      }
    }
    parent[i] = common;
  }
  // Subtree intervals: parents have larger indices, so sizes add up in index order and places are
  // handed out backwards.
  std::vector<std::uint32_t> size(n + 1, 1);
  for (std::size_t i = 0; i < n; ++i) size[parent[i]] += size[i];
  first_.assign(n + 1, 0);
  last_.assign(n + 1, 0);
  std::vector<std::uint32_t> next(n + 1, 0);
  next[n] = 1;
  for (std::size_t i = n; i-- > 0;) {
    first_[i] = next[parent[i]];
    next[parent[i]] += size[i];
    next[i] = first_[i] + 1;
  }
  for (std::size_t i = 0; i <= n; ++i) last_[i] = first_[i] + size[i] - 1;
}

}  // namespace ilss
