// Where the LEP's laser turns, seen from the axis of its head: the sensor's x calibration.
#pragma once

#include <Eigen/Core>
#include <span>

#include "framework/module/outcome.h"

namespace ilss {

/// The projection frame in the sensor frame (origin on the axis of head rotation, x to the right,
/// z forward at head angle 0): its axes are parallel, and the laser at scan angle a runs at theta =
/// a + projected vergence, so that
///   x = origin_x + (z - origin_z) tan(a + projected_vergence)
/// along it (Pears 1997, sections 3.1 and 3.2).
struct LepScanOrigin {
  double x = 0;                   ///< m
  double z = 0;                   ///< m
  double projected_vergence = 0;  ///< rad
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// An edge of a stripe on a target, at a known place in the sensor frame (m), and the scan angle
/// (rad) at which the laser crosses it.
struct StripeEdge {
  double scan_angle = 0;
  double x = 0;
  double z = 0;
};

struct LepScanOriginFit {
  LepScanOrigin origin;
  double residual = 0;  ///< sd of a scan angle, from the residuals (rad)
  std::size_t edges = 0;
};

/// Least squares on the scan angles, atan((x - x0) / (z - z0)) - projected vergence, all of one sd
/// that the residuals tell. Faults: bad_data for a number that is not finite; degenerate for fewer
/// than 5 edges, where the fit does not converge, or for edges that do not determine the three
/// parameters.
Outcome<LepScanOriginFit> fit_scan_origin(std::span<const StripeEdge> edges);

}  // namespace ilss
