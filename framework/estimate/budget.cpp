#include "framework/estimate/budget.h"

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

}  // namespace ilss
