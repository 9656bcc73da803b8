#include "sensors/scene/beam.h"

#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

/// A wall as the beam sees it: x along the beam's axis, z to its right; `along` runs from 0 to 1.
struct SeenWall {
  ScenePoint from;
  ScenePoint to;

  ScenePoint at(double along) const {
    return {from.x + along * (to.x - from.x), from.z + along * (to.z - from.z)};
  }
};

bool in_beam(const ScenePoint& point, double half_angle) {
  return std::abs(std::atan2(point.z, point.x)) <= half_angle;
}

/// Where the wall's line is nearest to the apex.
double foot_of_perpendicular(const SeenWall& wall) {
  const double dx = wall.to.x - wall.from.x;
  const double dz = wall.to.z - wall.from.z;
  return -(wall.from.x * dx + wall.from.z * dz) / (dx * dx + dz * dz);
}

/// Where the wall's line crosses the ray from the apex at `angle`; nothing behind the apex.
std::optional<double> crossing(const SeenWall& wall, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const double from = c * wall.from.z - s * wall.from.x;  // signed distances from the ray
  const double to = c * wall.to.z - s * wall.to.x;
  if (from == to) return std::nullopt;
  const double along = from / (from - to);
  const ScenePoint point = wall.at(along);
  if (c * point.x + s * point.z < 0) return std::nullopt;
  return along;
}

/// How far along the ray at `angle` from the apex it first meets the circle around `centre`;
/// nothing where it passes by, and from inside.
std::optional<double> circle_crossing(const ScenePoint& centre, double radius, double angle) {
  const double along = std::cos(angle) * centre.x + std::sin(angle) * centre.z;
  const double across = std::cos(angle) * centre.z - std::sin(angle) * centre.x;
  if (along <= 0 || std::abs(across) > radius) return std::nullopt;
  const double range = along - std::sqrt(radius * radius - across * across);
  if (range <= 0) return std::nullopt;
  return range;
}

}  // namespace

std::optional<SceneHit> nearest_in_beam(const Scene& scene, const ScenePose& beam,
                                        double half_angle, double max_range) {
  std::optional<SceneHit> nearest;
  for (std::size_t w = 0; w < scene.walls.size(); ++w) {
    const Wall& wall = scene.walls[w];
    const SeenWall seen{to_frame(beam, wall.from), to_frame(beam, wall.to)};
    const auto offer = [&](double along) {
      if (!(along >= 0 && along <= 1)) return;
      const ScenePoint local = seen.at(along);
      const double range = std::hypot(local.x, local.z);
      if (range > max_range || (nearest && range >= nearest->range)) return;
      nearest = SceneHit{range,
                         {wall.from.x + along * (wall.to.x - wall.from.x),
                          wall.from.z + along * (wall.to.z - wall.from.z)},
                         w};
    };
    // The beam is convex, so it cuts one piece out of the wall, and the nearest point of a piece
    // is the foot of the perpendicular or one of the piece's ends.
    for (const double along : {0.0, 1.0, foot_of_perpendicular(seen)})
      if (in_beam(seen.at(along), half_angle)) offer(along);
    for (const double edge : {-half_angle, half_angle})
      if (const auto along = crossing(seen, edge)) offer(*along);
  }
  for (std::size_t p = 0; p < scene.pillars.size(); ++p) {
    const Pillar& pillar = scene.pillars[p];
    const ScenePoint centre = to_frame(beam, pillar.centre);
    // The nearest point lies towards the centre or, where the beam does not hold that, on an edge.
    const double towards = std::atan2(centre.z, centre.x);
    const double angle = std::clamp(towards, -half_angle, half_angle);
    const auto range = circle_crossing(centre, pillar.radius, angle);
    if (!range || *range > max_range || (nearest && *range >= nearest->range)) continue;
    nearest = SceneHit{*range,
                       {beam.x + *range * std::cos(beam.heading + angle),
                        beam.z + *range * std::sin(beam.heading + angle)},
                       scene.walls.size() + p};
  }
  return nearest;
}

std::optional<SceneHit> cast_ray(const Scene& scene, const ScenePose& ray, double max_range) {
  return nearest_in_beam(scene, ray, 0.0, max_range);
}

}  // namespace ilss
