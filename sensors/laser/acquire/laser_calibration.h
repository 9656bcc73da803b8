// The systematic error of a laser's ranges, from ranges measured to known distances.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string_view>

#include "framework/module/outcome.h"
#include "sensors/laser/laser_scan.h"

namespace ilss {

/// A range as measured and as it truly is (m).
struct CalibrationRange {
  double measured = 0;
  double truth = 0;
  double deviation = 0;  ///< of the measured range's noise; 0: not known
};

inline constexpr std::array<std::string_view, range_biases> range_bias_names = {
    "bias_0", "bias_1", "bias_2", "bias_3", "bias_4", "bias_5", "bias_6"};

/// A polynomial in (range / reference): what a measured range is too long (m).
struct LaserCalibration {
  std::array<double, range_biases> bias = {};  ///< m; 0 beyond the order
  Eigen::Matrix<double, range_biases, range_biases> covariance =
      Eigen::Matrix<double, range_biases, range_biases>::Zero();  ///< m²
  double reference = 1;    ///< m: the largest range that was measured
  double least_range = 0;  ///< m: the smallest
  int order = 0;
  std::size_t points = 0;
  double range_std = 0;    ///< of the ranges about the polynomial (m)
  double chi_squared = 0;  ///< by the stated noise; 0 where none is stated
  double largest = 0;      ///< residual, with its sign (m)
  std::size_t largest_at = 0;
  double uncorrected = 0;  ///< root mean square of measured - true (m)
  bool noise_is_stated = false;

  double degrees_of_freedom() const { return static_cast<double>(points) - order - 1; }
};

/// Least squares of measured - true by a polynomial of an order up to six (Núñez et al. 2009, sec.
/// 4.4), each range weighted by its noise. Where no noise is stated, it is that of the
/// residuals, of which ten more are wanted than coefficients.
/// Faults: bad_data where a number is not finite, a range not above 0 or half as wrong as it is
/// long, or only some have an sd;
/// degenerate where there are too few ranges or they do not determine the polynomial.
Outcome<LaserCalibration> calibrate_laser(std::span<const CalibrationRange> ranges, int order);

}  // namespace ilss
