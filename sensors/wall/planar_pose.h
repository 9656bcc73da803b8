// Where something stands in the plane, and where it looks.
#pragma once

#include "framework/estimate/payload.h"

namespace ilss {

/// A pose in the plane: of a robot in the world, of a sensor on the robot.
template <typename T>
struct PlanarPose {
  T x, z, heading;

  static constexpr std::string_view name = "planar_pose";
  static constexpr std::string_view documentation = "a place in the plane and a direction";
  static constexpr auto fields = Fields{
      {"x", "m", "its place, forward in its frame"},
      {"z", "m", "its place, to the right"},
      {"heading", "rad", "where it looks, positive to the right", required, Geometry::circular}};
};

}  // namespace ilss
