// The verdict: can the first-order error of an output be believed?
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "framework/graph/system.h"

namespace ilss {

/// What may be believed of a first-order error.
enum class Verdict {
  linear_ok,             ///< bias and higher-order variance are small against it
  second_order,          ///< they are not: the first-order error is not the whole truth
  monte_carlo_required,  ///< nor is the second order
  invalid,               ///< some errors lead out of the formula's domain
};
std::string_view verdict_name(Verdict verdict);

/// The verdict on one output and what it rests on, per component (SI units).
struct VerdictReport {
  Verdict verdict = Verdict::linear_ok;  ///< at least as bad as the components'
  std::string reason = {};               ///< of a verdict that no component alone explains
  std::vector<Verdict> components;
  std::vector<double> bias;            ///< second-order shift of the mean
  std::vector<double> extra_variance;  ///< second-order variance, beyond the first-order one
};

/// First order is believed while the second-order bias stays below this part of the standard
/// deviation, ...
inline constexpr double largest_relative_bias = 0.1;
/// ... and second-order variance, and what errors of sqrt(3) standard deviations really do to the
/// variance, below this part of it.
inline constexpr double largest_relative_variance_change = 0.05;

/// Judges the system's outputs as they stand after a tick or an expectation. Each source of the
/// outputs' sensors, estimators and parameters is moved by ±sqrt(3) standard deviations (the points
/// of third-order Gauss-Hermite quadrature) and the functions behind it are evaluated again, so
/// that curvature and kinks of the whole chain count, not those of single modules; then all are
/// moved together with random signs, for what sources only do in company (x y at 0, 0). The limits
/// hold for every component and along every principal axis of the covariance. A label that changes
/// within 2.5 standard deviations (the wedge's case) makes `second_order`, a fault within the moves
/// `invalid`. `cut` names function nodes whose outputs were given and are to be moved themselves.
/// One report an output; an output that is not there is `invalid`.
std::vector<VerdictReport> judge(const System& system, const std::vector<std::size_t>& cut = {});

}  // namespace ilss
