// The pose of a wall relative to the robot: its distance and the bearing at which it is nearest.
#pragma once

#include <array>
#include <cmath>

#include "framework/module/function_module.h"
#include "sensors/wall/wall_points.h"

namespace ilss {

/// A wall as the robot sees it (Henderson & Dekhil 1997, table 1).
template <typename T>
struct WallPose {
  T range, angle;

  static constexpr std::string_view name = "wall_pose";
  static constexpr std::string_view documentation = "distance and bearing of a wall";
  static constexpr auto fields =
      Fields{{"range", "m", "perpendicular distance of the wall from the frame's origin"},
             {"angle", "rad",
              "bearing of the foot of that perpendicular from the forward axis, positive "
              "to the right",
              required, Geometry::circular}};
};

/// The pose of the wall through two points, x forward and z to the right (m): with the line's
/// normal n towards the wall, range = n · p and angle = atan2(n_z, n_x). Faults: degenerate where
/// the points coincide or the wall passes through the origin, within rounding.
template <typename T>
Outcome<WallPose<T>> wall_pose_through(const T& x1, const T& z1, const T& x2, const T& z2) {
  using std::atan2;
  using std::sqrt;
  const T dx = x2 - x1;
  const T dz = z2 - z1;
  const T length = sqrt(dx * dx + dz * dz);
  const T offset = (x1 * dz - z1 * dx) / length;  // signed: of the normal (dz, -dx)
  constexpr double rounding = 1e-12;
  const double scale = std::abs(scalar_value(x1)) + std::abs(scalar_value(z1)) +
                       std::abs(scalar_value(x2)) + std::abs(scalar_value(z2));
  if (!(scalar_value(length) > rounding * scale))
    return Fault{FaultKind::degenerate, "the two points on the wall coincide"};
  if (!(std::abs(scalar_value(offset)) > rounding * scale))
    return Fault{FaultKind::degenerate,
                 "the wall passes through the frame's origin, so its side is unknown"};
  const double side = scalar_value(offset) < 0 ? -1 : 1;
  return WallPose<T>{side * offset, wrap_angle(T(atan2(-side * dx, side * dz)))};
}

/// Function module: the pose of the wall through a wall line's two points.
class WallPoseModule {
 public:
  static constexpr std::string_view name = "wall_pose";
  static constexpr std::string_view description = "range and angle of the wall from any wall line";
  static constexpr std::string_view reference = "Henderson & Dekhil 1997, table 1";
  static constexpr std::array<std::string_view, 1> inputs = {"points"};
  static constexpr std::array faults = {FaultKind::degenerate};

  /// Points in the camera's axes would give a wrong angle silently, so only the robot's are let in.
  static void set_frames(Interface& interface);

  template <typename T>
  Outcome<WallPose<T>> operator()(const WallPoints<T>& points) const {
    return wall_pose_through(points.x1, points.z1, points.x2, points.z2);
  }
};

}  // namespace ilss
