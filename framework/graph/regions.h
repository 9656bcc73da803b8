// Which modules of a plan are evaluated at every tick, and which only when a selector asks for
// them.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "framework/graph/plan.h"

namespace ilss {

/// The regions of a plan. A node is left out where all that it feeds is given from outside; it
/// belongs to a selector where all ways from it to an output, or to a command that it drives, go
/// through that selector (the innermost one, where selectors stand in branches of others). All
/// other nodes are evaluated at every tick. O(nodes + connections), and O(nodes) more a branch.
class Regions {
 public:
  /// `given` says of each node whether its output comes from outside, so that nothing feeds it.
  Regions(const Plan& plan, const std::vector<bool>& given);

  /// What is evaluated at every tick, in order.
  std::span<const std::size_t> always() const { return always_; }
  /// What only some branches of a selector need, in order, branches of selectors in these included;
  /// empty for other nodes.
  std::span<const std::size_t> on_demand(std::size_t selector) const;
  /// Of these, what one branch needs, in order.
  std::span<const std::size_t> branch(std::size_t selector, std::size_t input) const;
  bool is_always(std::size_t node) const { return place_[node] == every_tick; }
  /// Whether the node is evaluated at all.
  bool is_needed(std::size_t node) const { return place_[node] != left_out; }

 private:
  struct SelectorRegion {
    std::vector<std::size_t> all;
    std::vector<std::vector<std::size_t>> branches;
  };

  void find_places(const Plan& plan, const std::vector<bool>& given);
  std::size_t common_place(std::size_t a, std::size_t b) const;
  bool is_within(std::size_t node, std::size_t selector) const;
  std::vector<std::size_t> find_branch(const Plan& plan, const std::vector<bool>& given,
                                       std::size_t selector, std::size_t input) const;

  static constexpr std::size_t every_tick = std::numeric_limits<std::size_t>::max();
  static constexpr std::size_t left_out = every_tick - 1;

  std::vector<std::size_t> place_;  ///< of each node: `every_tick`, `left_out` or its selector
  std::vector<std::size_t> always_;
  std::vector<SelectorRegion> selectors_;
  std::vector<std::size_t> selector_of_node_;  ///< where in `selectors_`; `left_out` where in none
};

}  // namespace ilss
