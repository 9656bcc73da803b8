// The best circle through a run of readings, with its error.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "sensors/range/line_fit.h"
#include "sensors/range/range_scan.h"

namespace ilss {

/// A fitted arc: centre_x, centre_z and radius (m), the latter positive where the surface bulges
/// towards the sensor and negative where it is hollow.
struct ArcFit {
  Eigen::Vector3d circle;
  Eigen::Matrix3d covariance;  ///< by the readings' own noise (m²)
  /// Of the circle by the scan's mount and shared errors, as in LineFit.
  Eigen::Matrix<double, 3, scan_dependences> by_scan;
  double chi_squared = 0;
  std::size_t readings = 0;
};

/// How an arc may look.
struct ArcRule {
  double least_radius = 0.02;  ///< m
  double largest_radius = 3;   ///< m
};

/// The circle of maximum likelihood for independent, normal errors of the inverse ranges, by
/// Levenberg-Marquardt from an algebraic start. Nothing where the radius is out of bounds or as
/// uncertain as it is large. Rays may pass the circle: `arc_residual` tells.
std::optional<ArcFit> fit_arc(std::span<const RangeReading> readings, const ArcRule& rule,
                              const RangeNoise& noise);

/// A ray that passes a circle's centre by more than this share of its radius only grazes it: across
/// a beam of some width the range there changes too much for one number.
inline constexpr double grazing = 0.95;

/// A reading's inverse range less the circle's along its ray, in standard deviations; infinite
/// where the ray grazes or passes the circle.
double arc_residual(const RangeReading& reading, const Eigen::Vector3d& circle);

/// The distance from a ray's origin at which it meets the circle: the near side of one that bulges,
/// the far side of a hollow one. Past the circle: the point of the ray nearest to its centre.
template <typename T>
T range_to_circle(const T& origin_x, const T& origin_z, const T& direction_x, const T& direction_z,
                  const T& centre_x, const T& centre_z, const T& radius) {
  using std::sqrt;
  const T dx = centre_x - origin_x;
  const T dz = centre_z - origin_z;
  T along = dx * direction_x + dz * direction_z;
  const T across = dx * direction_z - dz * direction_x;
  const T square = radius * radius - across * across;
  if (!(square > T(0))) return along;
  return radius > T(0) ? along - sqrt(square) : along + sqrt(square);
}

}  // namespace ilss
