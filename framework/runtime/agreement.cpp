#include "framework/runtime/agreement.h"

#include "framework/estimate/consistency.h"

namespace ilss {

Agreement::Agreement(const Plan& plan) {
  const std::size_t count = plan.outputs.size();
  for (std::size_t i = 0; i + 1 < count + (count > 2 ? 1 : 0); ++i) {
    const std::size_t next = (i + 1) % count;
    const PlanNode& a = plan.nodes[plan.outputs[i]];
    const PlanNode& b = plan.nodes[plan.outputs[next]];
    if (a.interface.output->name == b.interface.output->name && a.frame == b.frame &&
        a.interface.output->dimension() > 0) {
      pairs_.push_back({i, next});
      while (bounds_.size() <= a.interface.output->dimension())
        bounds_.push_back(bounds_.empty() ? 0
                                          : chi_square_quantile(static_cast<double>(bounds_.size()),
                                                                probability));
    }
  }
}

void Agreement::observe(const TickView& tick) {
  for (AgreementCount& pair : pairs_) {
    const Output* a = tick.output(pair.first).output;
    const Output* b = tick.output(pair.second).output;
    if (a == nullptr || b == nullptr) continue;
    const NormalizedError innovation = nis(a->estimate, b->estimate);
    if (innovation.rank == 0) continue;
    ++pair.compared;
    if (innovation.value <= bounds_[static_cast<std::size_t>(innovation.rank)]) ++pair.agreed;
  }
}

AgreementCount Agreement::total() const {
  AgreementCount sum{0, 0};
  for (const AgreementCount& pair : pairs_) {
    sum.compared += pair.compared;
    sum.agreed += pair.agreed;
  }
  return sum;
}

}  // namespace ilss
