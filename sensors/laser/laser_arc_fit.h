// The circle of maximum likelihood through a run of a laser's readings.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "sensors/laser/scan_points.h"

namespace ilss {

/// The circle about (x, y) in the laser's frame.
struct LaserArcFit {
  double x = 0;       ///< m
  double y = 0;       ///< m
  double radius = 0;  ///< m, positive where it bulges towards the laser, negative where hollow
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, radius) by the noise (m²)
  Eigen::Matrix<double, 3, range_biases> by_bias =
      Eigen::Matrix<double, 3, range_biases>::Zero();  ///< of (x, y, radius)
  double chi_squared = 0;
  std::size_t readings = 0;  ///< three of them are its degrees of freedom
};

/// The circle that makes the readings most likely (Núñez et al. 2009, sec. 3.2: the distances from
/// the circle, each weighted by its reading's uncertainty ellipse there):
///   e_i = |p_i - c| - |radius| - t_i² / (2 |radius|),
/// where n is the circle's normal at the point, s_i² = sigma_r² (n·d)² + r_i² sigma_phi² (n×d)² the
/// variance along it and t_i² the variance across it, which on a curve lengthens the distance (and
/// adds t_i⁴ / (2 radius²) to s_i², all there is where a beam without bearing noise grazes). By
/// Levenberg-Marquardt from the algebraic circle of the points; full 3x3 covariance. `with_biases`
/// as for a line. Nothing where fewer than four readings are given, they lie on a line or the
/// iteration does not settle.
std::optional<LaserArcFit> fit_laser_arc(std::span<const ScanPoint> points, const LaserNoise& noise,
                                         std::size_t with_biases = 0);

/// How far a reading is off the circle, in squared standard deviations.
double squared_residual(const LaserArcFit& arc, const ScanPoint& p, const LaserNoise& noise);

/// The distance along a beam at which it meets the circle (m): the near side of one that bulges,
/// the far side of a hollow one; beams that pass it: where they are nearest to its centre.
double range_of(const LaserArcFit& arc, const ScanPoint& beam);

}  // namespace ilss
