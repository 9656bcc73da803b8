// What a sonar makes of a wall: the model that tests hold the wedge's inverse against.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>

#include "framework/estimate/angle.h"
#include "sensors/wall/wedge.h"

namespace ilss {

/// What one sonar makes of an infinite wall.
struct SonarContact {
  double range;
  Contact contact;
};

/// The forward model (Henderson & Dekhil 1997, sec. 2.3, with the true geometry): for a wall at
/// distance d > 0 from the sonar, its normal at delta from the beam's axis,
/// range = d where |delta| <= half angle, else d / cos(delta - edge) with the edge nearer to the
/// normal. Nothing where the wall lies behind the sonar or never comes into the beam.
/// `sonar.range` is not used.
inline std::optional<SonarContact> sonar_contact(const SonarReading<double>& sonar,
                                                 const WallLine& wall) {
  const double distance =
      wall.range - std::cos(wall.bearing) * sonar.mount_x - std::sin(wall.bearing) * sonar.mount_z;
  if (!(distance > 0)) return std::nullopt;
  const double delta = wrap_angle(wall.bearing - sonar.mount_heading);
  if (std::abs(delta) <= sonar.beam_half_angle) return SonarContact{distance, Contact::tangent};
  const double beyond_edge = std::abs(delta) - sonar.beam_half_angle;
  if (beyond_edge >= std::numbers::pi / 2) return std::nullopt;
  return SonarContact{distance / std::cos(beyond_edge),
                      delta < 0 ? Contact::left_edge : Contact::right_edge};
}

}  // namespace ilss
