// Folding: where in a plan a source's columns can be joined because nothing else refers to them.
#pragma once

#include <cstdint>
#include <vector>

#include "framework/graph/plan.h"

namespace ilss {

/// Post-dominance over a plan: node `n` post-dominates node `m` if every way from m to an output
/// goes through n. Random sources of m can then be folded at n, since no other output of this tick
/// refers to them. Built once in O(nodes + connections) for chains and trees (Cooper, Harvey and
/// Kennedy 2001), asked in O(1).
class PostDominators {
 public:
  explicit PostDominators(const Plan& plan);

  bool post_dominates(std::size_t n, std::size_t m) const {
    return first_[n] <= first_[m] && last_[m] <= last_[n];
  }

 private:
  std::vector<std::uint32_t> first_;  ///< order of entering a node's subtree
  std::vector<std::uint32_t> last_;   ///< largest `first_` in the subtree
};

}  // namespace ilss
