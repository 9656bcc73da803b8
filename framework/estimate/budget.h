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

/// The effective degrees of freedom of a component's standard deviation, infinite where every
/// owner's is known: u^4 / sum of u_k^4 / v_k over owners (Welch-Satterthwaite; JCGM 100:2008,
/// G.2b).
double effective_degrees_of_freedom(const std::vector<BudgetEntry>& entries,
                                    const SourceOwners& owners, std::size_t component);

/// The standard deviation of a component if one owner's errors were half as large.
double deviation_if_halved(const std::vector<BudgetEntry>& entries, std::size_t entry,
                           std::size_t component);

}  // namespace ilss
