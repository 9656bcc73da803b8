// The best line through runs of readings, with its error by the readings' noise and by what they
// share.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "sensors/range/line_information.h"
#include "sensors/range/line_segmentation.h"
#include "sensors/range/range_scan.h"

namespace ilss {

/// How many components of a range_scan a fit depends on: its mount and its shared errors.
inline constexpr int scan_dependences = 8;

/// A fitted line.
struct LineFit {
  InverseLine line;
  Eigen::Matrix2d covariance;  ///< of the line's x and z, by the readings' own noise (1/m²)
  /// Of the line's x and z by the scan's mount_x, mount_z, mount_heading and error_1 to error_5.
  Eigen::Matrix<double, 2, scan_dependences> by_scan;
  double chi_squared = 0;
  std::size_t readings = 0;
};

/// The line of maximum likelihood for independent, normal errors of the inverse ranges or, where
/// the noise is so, of the ranges. By a step of Gauss-Newton from `start`, which must be the least
/// squares of LineInformation or as near, and by several for noise in range. Neighbouring readings'
/// errors of correlation r say together of so smooth a thing as a line less by (1 + r) / (1 - r).
/// Nothing where fewer than two readings are given, or they do not determine a line.
std::optional<LineFit> fit_line(std::span<const RangeReading> readings,
                                std::span<const ReadingRun> runs, const InverseLine& start,
                                const RangeNoise& noise);

}  // namespace ilss
