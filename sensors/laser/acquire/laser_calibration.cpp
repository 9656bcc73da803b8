#include "sensors/laser/acquire/laser_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "framework/estimate/decompositions.h"
#include "sensors/laser/acquire/laser_correction.h"

namespace ilss {
namespace {

Outcome<> check(std::span<const CalibrationRange> ranges, int order) {
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const CalibrationRange& r = ranges[i];
    if (!(std::isfinite(r.measured) && std::isfinite(r.truth) && std::isfinite(r.deviation)) ||
        !(r.measured > 0) || !(r.truth > 0) || r.deviation < 0)
      return Fault{FaultKind::bad_data,
                   fmt::format("range {}: measured {:g} m, true {:g} m, sd {:g} m", i + 1,
                               r.measured, r.truth, r.deviation)};
    constexpr double largest_error = 0.5;  // of the range
    if (std::abs(r.measured - r.truth) > largest_error * r.truth)
      return Fault{FaultKind::bad_data,
                   fmt::format("range {}: {:g} m were measured of {:g} m; are the units right?",
                               i + 1, r.measured, r.truth)};
    if ((r.deviation > 0) != (ranges[0].deviation > 0))
      return Fault{FaultKind::bad_data, "give every range an sd, or none"};
  }
  // Degrees of freedom: the noise, where it is to be estimated, needs some.
  const int least = order + 1 + (!ranges.empty() && ranges[0].deviation > 0 ? 1 : 10);
  if (static_cast<int>(ranges.size()) < least)
    return Fault{FaultKind::degenerate,
                 fmt::format("a polynomial of order {} needs {} ranges at least, {} are given",
                             order, least, ranges.size())};
  return {};
}

/// How much of a measured range's noise is left when it is corrected by its polynomial.
double corrected_noise_factor(const LaserCalibration& calibration, double measured) {
  const double share = measured / calibration.reference;
  double slope = 0;
  for (std::size_t k = calibration.bias.size() - 1; k > 0; --k)
    slope = slope * share + static_cast<double>(k) * calibration.bias[k];
  return 1 - slope / calibration.reference;
}

/// What the polynomial leaves of each range.
void judge(std::span<const CalibrationRange> ranges, LaserCalibration& calibration) {
  double squares = 0;
  double before = 0;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const CalibrationRange& r = ranges[i];
    const double error = r.measured - r.truth;
    const double residual =
        error - range_bias(calibration.bias, r.measured / calibration.reference);
    squares += residual * residual;
    before += error * error;
    const double deviation = r.deviation * corrected_noise_factor(calibration, r.measured);
    if (deviation > 0) calibration.chi_squared += residual * residual / (deviation * deviation);
    if (std::abs(residual) <= std::abs(calibration.largest)) continue;
    calibration.largest = residual;
    calibration.largest_at = i;
  }
  calibration.range_std = std::sqrt(squares / calibration.degrees_of_freedom());
  calibration.uncorrected = std::sqrt(before / static_cast<double>(ranges.size()));
}

/// Weighted least squares of the coefficients, with the weights that the coefficients so far leave;
/// false where the ranges do not determine them. Leaves the covariance for noise of 1 m where none
/// is stated.
bool fit(std::span<const CalibrationRange> ranges, LaserCalibration& calibration) {
  const auto rows = static_cast<Eigen::Index>(ranges.size());
  const Eigen::Index columns = calibration.order + 1;
  Eigen::MatrixXd powers(rows, columns);
  Eigen::VectorXd errors(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const CalibrationRange& r = ranges[static_cast<std::size_t>(i)];
    const double deviation =
        (r.deviation > 0 ? r.deviation : 1) * corrected_noise_factor(calibration, r.measured);
    double weighted = 1 / deviation;
    errors[i] = weighted * (r.measured - r.truth);
    for (Eigen::Index k = 0; k < columns; ++k, weighted *= r.measured / calibration.reference)
      powers(i, k) = weighted;
  }
  const PivotedQr qr = pivoted_qr(powers);
  if (!powers.allFinite() || qr.rank() < columns) return false;
  const Eigen::VectorXd bias = solve(qr, errors);
  std::copy(bias.begin(), bias.end(), calibration.bias.begin());
  // (AᵀA)⁻¹ by the factors of A = Q R Pᵀ.
  const Eigen::MatrixXd triangle =
      qr.matrixR().topRows(columns).triangularView<Eigen::Upper>().toDenseMatrix();
  const Eigen::MatrixXd inverse =
      triangle.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(columns, columns));
  const Eigen::MatrixXd factor = qr.colsPermutation() * inverse;
  calibration.covariance.topLeftCorner(columns, columns) = factor * factor.transpose();
  return true;
}

}  // namespace

Outcome<LaserCalibration> calibrate_laser(std::span<const CalibrationRange> ranges, int order) {
  if (auto good = check(ranges, order); !good) return good.fault();
  LaserCalibration calibration;
  calibration.order = order;
  calibration.points = ranges.size();
  calibration.noise_is_stated = ranges[0].deviation > 0;
  const auto [least, most] =
      std::minmax_element(ranges.begin(), ranges.end(),
                          [](const auto& a, const auto& b) { return a.measured < b.measured; });
  calibration.reference = most->measured;
  calibration.least_range = least->measured;
  // The second time with what the correction leaves of the noise.
  for (int pass = 0; pass < 2; ++pass)
    if (!fit(ranges, calibration))
      return Fault{FaultKind::degenerate,
                   fmt::format("the ranges do not determine a polynomial of order {}: they need to "
                               "differ more",
                               order)};
  judge(ranges, calibration);
  if (!calibration.noise_is_stated) {
    // An sd that is itself estimated makes the coefficients follow Student's law.
    const double degrees = calibration.degrees_of_freedom();
    calibration.covariance *=
        calibration.range_std * calibration.range_std * degrees / (degrees - 2);
  }
  return calibration;
}

}  // namespace ilss
