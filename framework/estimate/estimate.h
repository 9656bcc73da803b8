// An estimate: a numeric payload together with its error.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "framework/estimate/angle.h"
#include "framework/estimate/lineage.h"
#include "framework/estimate/manifold.h"
#include "framework/estimate/payload.h"

namespace ilss {

/// Values in SI units in the order of `type->components`, their lineage and labels.
struct Estimate {
  const PayloadDescriptor* type = nullptr;
  std::string frame = {};
  std::vector<double> value = {};
  std::vector<int> labels = {};  ///< indices into `type->labels[i].values`
  Lineage lineage = Lineage{};
  bool correlation_unknown = false;  ///< the lineage is not the whole story: see fusion

  Estimate() = default;
  /// An exact estimate of zeros (or of the components' defaults).
  explicit Estimate(const PayloadDescriptor& payload, std::string in_frame = {});

  std::size_t dimension() const { return value.size(); }
  Eigen::Map<const Eigen::VectorXd> vector() const {
    return {value.data(), static_cast<Eigen::Index>(value.size())};
  }
};

/// estimate ⊖ truth (manifold.h).
Eigen::VectorXd difference(const Estimate& estimate, std::span<const double> truth);

/// The weighted sum of estimates of one payload; errors that they share add up, others average out.
/// Circular components are combined near the first estimate's; rotations have a mean only, of
/// weights that add up to 1 (weighted_mean).
/// @throws std::invalid_argument on no estimates, unequal types or frames, counts that differ, or
/// other weights of rotations.
Estimate linear_combination(std::span<const Estimate> estimates, std::span<const double> weights);

/// Reads an estimate's values into its payload struct.
template <template <typename> class Payload>
Payload<double> payload_of(const Estimate& estimate) {
  Payload<double> payload{};
  const auto out = components(payload);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = estimate.value[i];
  if constexpr (requires { payload.label; })
    for (std::size_t i = 0; i < payload.label.size(); ++i)
      payload.label[i] = i < estimate.labels.size() ? estimate.labels[i] : 0;
  return payload;
}

/// Writes a payload struct's values and labels, and forgets the old lineage.
template <template <typename> class Payload>
void assign(Estimate& estimate, const Payload<double>& payload) {
  const auto in = components(payload);
  estimate.value.assign(in.begin(), in.end());
  estimate.lineage.reset(in.size());
  estimate.correlation_unknown = false;
  if constexpr (requires { payload.label; })
    estimate.labels.assign(payload.label.begin(), payload.label.end());
}

}  // namespace ilss
