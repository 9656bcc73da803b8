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
  double least_radius = 0;           ///< m
  double largest_radius = INFINITY;  ///< m
  double most_chi_squared = INFINITY;
};

/// Whether it is certain, without a fit, that no circle within these limits goes through the
/// readings. With e the distance of a point p from a circle about c, e (2 R + e) = |p - c|² - R²,
/// whose squares' sum is at least that of the algebraic circle, K (Kåsa), and over 4 R² and the
/// mean of (1 + e / R)² at least Taubin's, T. With every |e| up to d (from the chi² itself)
///   sqrt(sum e²) >= sqrt(K) / (2 R + d)
/// leaves only curvatures 1 / R up to some k, and for these
///   sqrt(sum e²) >= sqrt(T) (1 - k d) / (1 + k d / 2).
/// Nothing is certain where bearings are noisy: a beam's part in chi² then has no such bound.
bool exceeds_limits(std::span<const ScanPoint> points, const LaserNoise& noise,
                    const ArcLimits& limits);

/// As `exceeds_limits`, and that no line has a chi² up to `most_of_line`: it is at least that of
/// the distances from the line of total least squares.
bool exceeds_as_line_and_arc(std::span<const ScanPoint> points, const LaserNoise& noise,
                             double most_of_line, const ArcLimits& limits);

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
