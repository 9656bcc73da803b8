// Payloads with a rotation in space, for tests: no module that ships has one.
#pragma once

#include "framework/estimate/payload.h"

namespace ilss::test {

/// A rotation alone.
template <typename T>
struct Orientation {
  T rx, ry, rz;
  static constexpr std::string_view name = "test_orientation";
  static constexpr auto fields = Fields{{"rx", "rad", "", required, Geometry::rotation},
                                        {"ry", "rad", "", required, Geometry::rotation},
                                        {"rz", "rad", "", required, Geometry::rotation}};
};

/// A pose in space, and a joint's angle.
template <typename T>
struct SpatialPose {
  T x, rx, ry, rz, y, joint;
  static constexpr std::string_view name = "test_spatial_pose";
  static constexpr auto fields = Fields{{"x", "m"},
                                        {"rx", "rad", "", required, Geometry::rotation},
                                        {"ry", "rad", "", required, Geometry::rotation},
                                        {"rz", "rad", "", required, Geometry::rotation},
                                        {"y", "m"},
                                        {"joint", "rad", "", required, Geometry::circular}};
};

}  // namespace ilss::test
