// The budget: which owner is to blame for how much of an estimate's variance.
#pragma once

#include <string>
#include <vector>

#include "framework/estimate/estimate.h"

namespace ilss {

/// One owner's part of the variance, per component (units squared).
struct BudgetEntry {
  std::uint32_t owner;
  bool persistent;
  std::vector<double> variance;
};

/// The variance of each component by owner, in order of owner: sums of G(i,k)², so the parts add up
/// to the variance.
std::vector<BudgetEntry> budget(const Lineage& lineage);

}  // namespace ilss
