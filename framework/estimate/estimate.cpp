#include "framework/estimate/estimate.h"

#include <fmt/format.h>

#include <stdexcept>

namespace ilss {

Estimate::Estimate(const PayloadDescriptor& payload, std::string in_frame)
    : type(&payload), frame(std::move(in_frame)), lineage(payload.dimension()) {
  for (const Component& component : payload.components)
    value.push_back(component.default_value.value_or(0.0));
  labels.assign(payload.labels.size(), 0);
}

Eigen::VectorXd difference(const Estimate& estimate, std::span<const double> truth) {
  Eigen::VectorXd error = estimate.vector();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    double& e = error[static_cast<Eigen::Index>(i)];
    e -= truth[i];
    if (estimate.type != nullptr && estimate.type->components[i].circular) e = wrap_angle(e);
  }
  return error;
}

Estimate linear_combination(std::span<const Estimate> estimates, std::span<const double> weights) {
  if (estimates.empty() || estimates.size() != weights.size())
    throw std::invalid_argument(
        fmt::format("a linear combination needs a weight for each of at "
                    "least one estimate; got {} estimates, {} weights",
                    estimates.size(), weights.size()));
  for (const Estimate& estimate : estimates)
    if (estimate.type == nullptr)
      throw std::invalid_argument("a linear combination needs estimates that have a payload type");
  Estimate result = estimates.front();
  const std::size_t m = result.dimension();
  std::vector<double> jacobians(estimates.size() * m * m, 0.0);
  std::vector<LineageTerm> terms;
  std::vector<double> sum(m, 0.0);
  double total_weight = 0;
  for (std::size_t n = 0; n < estimates.size(); ++n) {
    const Estimate& estimate = estimates[n];
    if (estimate.type->name != result.type->name || estimate.frame != result.frame)
      throw std::invalid_argument(
          fmt::format("a linear combination needs estimates of one payload in one frame; got {} in "
                      "'{}' and {} in '{}'",
                      result.type->name, result.frame, estimate.type->name, estimate.frame));
    double* jacobian = jacobians.data() + n * m * m;
    // Relative to the first estimate, so that angles on either side of pi meet.
    const Eigen::VectorXd offset = difference(estimate, estimates.front().value);
    for (std::size_t i = 0; i < m; ++i) {
      jacobian[i * m + i] = weights[n];
      sum[i] += weights[n] * offset[static_cast<Eigen::Index>(i)];
    }
    total_weight += weights[n];
    terms.push_back({jacobian, &estimate.lineage});
    result.correlation_unknown |= estimate.correlation_unknown;
  }
  for (std::size_t i = 0; i < m; ++i) {
    result.value[i] = total_weight * estimates.front().value[i] + sum[i];
    if (result.type->components[i].circular) result.value[i] = wrap_angle(result.value[i]);
  }
  compose(terms, m, result.lineage);
  return result;
}

}  // namespace ilss
