// What a beam finds in the scene: the nearest point of any wall or pillar inside a wedge of the
// plane.
#pragma once

#include <cstddef>
#include <optional>

#include "sensors/scene/scene.h"

namespace ilss {

/// A point of a wall or pillar (world axes, m) and how far it is from the beam's apex.
struct SceneHit {
  double range;
  ScenePoint point;
  std::size_t wall;  ///< index into the scene's walls and, after these, its pillars
};

/// The nearest point of any wall or pillar within `half_angle` (rad, below pi/2) of the heading of
/// `beam`: the foot of the perpendicular where it lies in the beam, otherwise a point on one of the
/// beam's edges or a wall's end. Nothing where no wall comes within `max_range` (m) inside the
/// beam.
std::optional<SceneHit> nearest_in_beam(const Scene& scene, const ScenePose& beam,
                                        double half_angle, double max_range);

/// Where a ray first meets a wall: a beam of no width.
std::optional<SceneHit> cast_ray(const Scene& scene, const ScenePose& ray, double max_range);

}  // namespace ilss
