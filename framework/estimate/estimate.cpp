#include "framework/estimate/estimate.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <stdexcept>

namespace ilss {
namespace {

void check_combination(std::span<const Estimate> estimates, std::span<const double> weights) {
  if (estimates.empty() || estimates.size() != weights.size())
    throw std::invalid_argument(
        fmt::format("a linear combination needs a weight for each of at "
                    "least one estimate; got {} estimates, {} weights",
                    estimates.size(), weights.size()));
  for (const Estimate& estimate : estimates)
    if (estimate.type == nullptr)
      throw std::invalid_argument("a linear combination needs estimates that have a payload type");
  const Estimate& first = estimates.front();
  for (const Estimate& estimate : estimates)
    if (estimate.type->name != first.type->name || estimate.frame != first.frame)
      throw std::invalid_argument(
          fmt::format("a linear combination needs estimates of one payload in one frame; got {} in "
                      "'{}' and {} in '{}'",
                      first.type->name, first.frame, estimate.type->name, estimate.frame));
  constexpr double rounding = 1e-9;
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (!is_flat(*first.type) && std::abs(total - 1) > rounding)
    throw std::invalid_argument(fmt::format(
        "{} has rotations, which have a mean only: weights must add up to 1, not {:.6g}",
        first.type->name, total));
}

/// The values' sum, circular components relative to the first estimate's, so that angles on either
/// side of pi meet.
std::vector<double> combined_value(std::span<const Estimate> estimates,
                                   std::span<const double> weights) {
  const Estimate& first = estimates.front();
  if (!is_flat(*first.type)) {
    std::vector<std::span<const double>> values;
    for (const Estimate& estimate : estimates) values.emplace_back(estimate.value);
    return weighted_mean(*first.type, values, weights);
  }
  std::vector<double> sum(first.dimension(), 0.0);
  std::vector<double> offset(first.dimension());
  double total = 0;
  for (std::size_t n = 0; n < estimates.size(); ++n) {
    difference(*first.type, estimates[n].value, first.value, offset);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weights[n] * offset[i];
    total += weights[n];
  }
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = total * first.value[i] + sum[i];
  normalize(*first.type, sum);
  return sum;
}

}  // namespace

Estimate::Estimate(const PayloadDescriptor& payload, std::string in_frame)
    : type(&payload), frame(std::move(in_frame)), lineage(payload.dimension()) {
  for (const Component& component : payload.components)
    value.push_back(component.default_value.value_or(0.0));
  labels.assign(payload.labels.size(), 0);
}

Eigen::VectorXd difference(const Estimate& estimate, std::span<const double> truth) {
  if (estimate.type != nullptr) return difference(*estimate.type, estimate.value, truth);
  return estimate.vector() -
         Eigen::Map<const Eigen::VectorXd>(truth.data(), static_cast<Eigen::Index>(truth.size()));
}

Estimate linear_combination(std::span<const Estimate> estimates, std::span<const double> weights) {
  check_combination(estimates, weights);
  Estimate result = estimates.front();
  result.value = combined_value(estimates, weights);
  const auto m = static_cast<Eigen::Index>(result.dimension());
  const auto count = static_cast<Eigen::Index>(estimates.size());
  Eigen::MatrixXd jacobians = Eigen::MatrixXd::Zero(m, m * count);
  Eigen::MatrixXd differences(m, count);
  std::vector<LineageTerm> terms;
  for (Eigen::Index n = 0; n < count; ++n) {
    const Estimate& estimate = estimates[static_cast<std::size_t>(n)];
    jacobians.middleCols(n * m, m).diagonal().setConstant(weights[static_cast<std::size_t>(n)]);
    differences.col(n) = difference(estimate, result.value);
    terms.push_back({jacobians.data() + n * m * m, &estimate.lineage});
    result.correlation_unknown |= estimate.correlation_unknown;
  }
  transport_gains(*result.type, differences, jacobians);
  compose(terms, result.dimension(), result.lineage);
  return result;
}

}  // namespace ilss
