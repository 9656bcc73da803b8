// The circle of maximum likelihood through a run of a laser's readings.
#pragma once

#include <Eigen/Core>
#include <cmath>
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

  /// What the readings tell nearly linearly is the curvature, so that the radius, and the centre
  /// with it, also change by its error squared: (x, y, radius) by the root of that one's mean
  /// square (m). Independent of the covariance.
  Eigen::Vector3d second_order() const {
    return std::sqrt(3.0) / std::abs(radius) * covariance.col(2);
  }
};

/// What a caller asks of an arc.
struct ArcLimits {
  double least_radius = 0;          ///< m
  double largest_radius = INFINITY;  ///< m
  double most_chi_squared = INFINITY;
};

/// Whether it is certain, without a fit, that no circle within these limits goes through the
/// readings. With e the distance of a point p from a circle about c, |p - c|² - R² = e (2 R + e);
/// the sum of the left side's squares is at least K, that of the algebraic circle (Kåsa), and so
///   sum e² >= K / (2 R + max |e|)².
/// Nothing is certain where bearings are noisy: a beam's part in chi² then has no such bound.
bool exceeds_limits(std::span<const ScanPoint> points, const LaserNoise& noise,
                    const ArcLimits& limits);

/// The circle that makes the readings most likely (Núñez et al. 2009, sec. 3.2: the distances from
/// the circle, each weighted by its reading's uncertainty ellipse there). With n the circle's
/// normal where beam d meets it at range R_i,
///   e_i = (r_i - R_i) (n·d),  s_i² = sigma_r² (n·d)² + R_i² sigma_phi² (n×d)²,
/// so that normal and weight have no part in the reading's noise. Beams that graze or pass the
/// circle (the last 2.5 % of its radius) are taken by their points p_i, |p_i - c| - |radius|, less
/// t_i² / (2 |radius|), by which the variance t_i² across the normal lengthens the distance. By
/// Levenberg-Marquardt from the algebraic circle of the points; full 3x3 covariance. `biases` as
/// for a line. Nothing where fewer than four readings are given, they lie on a line, the iteration
/// does not settle, or it is certain beforehand that the circle is not within the limits.
std::optional<LaserArcFit> fit_laser_arc(std::span<const ScanPoint> points, const LaserNoise& noise,
                                         const UncertainBiases& biases = {},
                                         const ArcLimits& limits = {});

/// How far a reading is off the circle, in squared standard deviations.
double squared_residual(const LaserArcFit& arc, const ScanPoint& p, const LaserNoise& noise);

/// The distance along a beam at which it meets the circle (m): the near side of one that bulges,
/// the far side of a hollow one; beams that pass it: where they are nearest to its centre.
double range_of(const LaserArcFit& arc, const ScanPoint& beam);

}  // namespace ilss
