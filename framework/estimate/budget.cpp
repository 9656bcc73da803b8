#include "framework/estimate/budget.h"

#include <cmath>
#include <limits>

namespace ilss {

std::vector<BudgetEntry> budget(const Lineage& lineage) {
  std::vector<BudgetEntry> entries;
  for (std::size_t k = 0; k < lineage.size(); ++k) {
    const Source& source = lineage.sources()[k];
    if (entries.empty() || entries.back().owner != source.owner)
      entries.push_back(
          {source.owner, source.persistent(), std::vector<double>(lineage.dimension(), 0.0)});
    for (std::size_t i = 0; i < lineage.dimension(); ++i)
      entries.back().variance[i] += lineage.column(k)[i] * lineage.column(k)[i];
  }
  return entries;
}

double effective_degrees_of_freedom(const std::vector<BudgetEntry>& entries,
                                    const SourceOwners& owners, std::size_t component) {
  double variance = 0;
  double sum = 0;
  for (const BudgetEntry& entry : entries) {
    const double part = entry.variance[component];
    variance += part;
    sum += part * part / owners[entry.owner].degrees_of_freedom;
  }
  return sum > 0 ? variance * variance / sum : std::numeric_limits<double>::infinity();
}

double deviation_if_halved(const std::vector<BudgetEntry>& entries, std::size_t entry,
                           std::size_t component) {
  double variance = 0;
  for (std::size_t k = 0; k < entries.size(); ++k)
    variance += (k == entry ? 0.25 : 1.0) * entries[k].variance[component];
  return std::sqrt(variance);
}

}  // namespace ilss
