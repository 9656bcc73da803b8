// A sonar's reading together with what later modules need of the sonar itself.
#pragma once

#include <numbers>

#include "framework/estimate/payload.h"

namespace ilss {

/// Half the opening angle of the Polaroid sonar's beam (Henderson & Dekhil 1997, sec. 2.3).
inline constexpr double polaroid_half_angle = 11 * std::numbers::pi / 180;

/// The range to the nearest point of the wall inside the beam, and where the sonar sits: x forward
/// and z to the right of the frame's origin, heading from x towards z.
template <typename T>
struct SonarReading {
  T range, beam_half_angle, mount_x, mount_z, mount_heading;

  static constexpr std::string_view name = "sonar_reading";
  static constexpr std::string_view documentation = "a sonar's range, beam and mount";
  static constexpr auto fields = Fields{
      {"range", "m", "to the nearest point of the wall inside the beam"},
      {"beam_half_angle", "rad", "half the beam's opening angle", polaroid_half_angle},
      {"mount_x", "m", "the sonar's place, forward", 0},
      {"mount_z", "m", "the sonar's place, to the right", 0},
      {"mount_heading", "rad", "the beam's axis, positive to the right", 0, Geometry::circular}};
};

}  // namespace ilss
