// The z calibration of the LEP sensor: its four intrinsic parameters from image positions of a
// target at known depths.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "framework/module/outcome.h"
#include "sensors/lep/lep_geometry.h"
#include "sensors/lep/lep_scan_origin.h"

namespace ilss {

/// One reading of the calibration target.
struct LepCalibrationPoint {
  double scan_angle = 0;      ///< rad, before the projected vergence is added
  double depth = 0;           ///< z of what the laser lights, in the sensor frame (m)
  double image_position = 0;  ///< m
  double deviation = 0;       ///< sd of the image position (m)
};

/// What calibration tells of a sensor, in the order of the covariance.
inline constexpr std::array<std::string_view, 7> lep_calibration_names = {
    "focal_length", "baseline", "vergence",          "lens_distance",
    "origin_x",     "origin_z", "projected_vergence"};
inline constexpr std::array<std::string_view, 7> lep_calibration_units = {"m", "m", "rad", "m",
                                                                          "m", "m", "rad"};

/// The difference of the image positions from the fitted model's (m).
struct LepResiduals {
  double mean = 0;
  double rms = 0;
  double largest = 0;          ///< with its sign
  std::size_t largest_at = 0;  ///< the point, from 0
  double largest_in_sd = 0;    ///< the residual that is largest in units of its sd
  std::size_t largest_in_sd_at = 0;
};

/// What the paper's method finds.
struct LepLinearFit {
  Eigen::Matrix<double, 6, 1> unknowns;  ///< x of equation 13 (SI)
  LepGeometry<double> geometry;
};

struct LepCalibration {
  std::optional<LepLinearFit> linear;  ///< of the paper's method, where it gave an answer
  LepGeometry<double> geometry;        ///< of the nonlinear fit
  LepScanOrigin origin;                ///< as given
  /// Of all seven, as `lep_calibration_names` has them (SI): what the noise of the image positions
  /// and the uncertainty of the scan origin leave.
  Eigen::Matrix<double, 7, 7> covariance = Eigen::Matrix<double, 7, 7>::Zero();
  double chi_squared = 0;
  std::size_t points = 0;
  LepResiduals residuals;

  double degrees_of_freedom() const { return static_cast<double>(points) - 4; }
  std::array<double, 7> values() const;
};

/// Where the target at a reading's scan angle and depth shows (m); equation 10.
double model_image_position(const LepGeometry<double>& geometry, const LepScanOrigin& origin,
                            double scan_angle, double depth);

/// The paper's method: linear least squares in six unknowns (Pears 1997, equations 11 to 13), of
/// which the four parameters are d = x1, f = x4 / x1, tan gamma = x5 / x4 and s = x3 cos gamma. The
/// image position stands on both sides, so its noise biases the result, whatever its variance.
/// Nothing where the six are not determined or give no sensor.
std::optional<LepLinearFit> fit_lep_linear(std::span<const LepCalibrationPoint> points,
                                           const LepScanOrigin& origin);

/// The maximum-likelihood fit: least squares on image position, weighted by its variance, by
/// Levenberg-Marquardt from the paper's solution, or the shipped sensor's parameters where that one
/// is not good enough. For 10,000 points it takes some 10 ms. Faults: bad_data for a point that is
/// not finite, has no positive sd or no positive depth from the scan origin; degenerate for fewer
/// than 6 points, or data that do not determine the parameters, naming the combination that stays
/// open.
Outcome<LepCalibration> calibrate_lep(std::span<const LepCalibrationPoint> points,
                                      const LepScanOrigin& origin);

}  // namespace ilss
