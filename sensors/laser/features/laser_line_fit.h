// The line of maximum likelihood through a run of a laser's readings.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "sensors/laser/scan_points.h"

namespace ilss {

/// The line x cos(alpha) + y sin(alpha) = rho in the laser's frame.
struct LaserLineFit {
  double rho = 0;                                        ///< m, not negative
  double alpha = 0;                                      ///< rad, in [-pi, pi)
  double cosine = 1;                                     ///< of alpha
  double sine = 0;                                       ///< of alpha
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of (rho, alpha) by the noise
  Eigen::Matrix<double, 2, range_biases> by_bias =
      Eigen::Matrix<double, 2, range_biases>::Zero();  ///< of (rho, alpha)
  double chi_squared = 0;                              ///< of the readings about it
  double bend = 0;                ///< chi² that a parabola in place of the line would save
  double bend_radius = INFINITY;  ///< of that parabola's curvature (m)
  /// Of (rho, alpha): what the line would differ by if another half of the bent surface were seen.
  Eigen::Matrix2d bend_covariance = Eigen::Matrix2d::Zero();
  std::size_t readings = 0;  ///< two of them are its degrees of freedom

  /// A short line turns about its middle, and rho then changes by -rho (change of alpha)² / 2,
  /// which first order does not see: its mean square (m²). Independent of the covariance.
  double second_order_variance() const {
    const double change = rho * covariance(1, 1);
    return 0.75 * change * change;
  }
};

/// The line that makes the readings most likely. A reading's range differs from the line's,
/// rho / cos(alpha - bearing), by the noise of the range and by what the noise of its bearing makes
/// of it where the beam meets the line obliquely. Across the line that is, for reading i,
///   e_i = r_i cos(alpha - phi_i) - rho,  s_i² = sigma_r² cos² + (rho tan(alpha - phi_i))²
///   sigma_phi²,
/// and the covariance is (sum J_iᵀ J_i / s_i²)^-1 with J_i = (-1, -rho tan(alpha - phi_i)), the
/// full information (Pfister et al. 2003, with what that leaves out). The weights come from the
/// line and not from the noisy ranges, so that long readings are not preferred. By Gauss-Newton
/// with renewed weights from the total least squares. `biases`: the systematic coefficients
/// to give sensitivities for. Nothing where fewer than two readings are given or they
/// determine no line that all beams meet.
std::optional<LaserLineFit> fit_laser_line(std::span<const ScanPoint> points,
                                           const LaserNoise& noise,
                                           const UncertainBiases& biases = {});

/// How far a reading is off the line, in squared standard deviations; infinite where its beam does
/// not meet the line.
double squared_residual(const LaserLineFit& line, const ScanPoint& p, const LaserNoise& noise);

}  // namespace ilss
