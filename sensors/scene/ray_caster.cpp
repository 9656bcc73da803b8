#include "sensors/scene/ray_caster.h"

#include <cmath>

namespace ilss {

RayCaster::RayCaster(const Scene& scene) {
  for (const Wall& wall : scene.walls)
    walls_.push_back({wall.from.x, wall.from.z, wall.to.x - wall.from.x, wall.to.z - wall.from.z});
  for (const Pillar& pillar : scene.pillars)
    pillars_.push_back({pillar.centre.x, pillar.centre.z, pillar.radius * pillar.radius});
}

std::optional<RayHit> RayCaster::cast(const ScenePoint& origin, double cosine, double sine,
                                      double max_range) const {
  std::optional<RayHit> nearest;
  double limit = max_range;
  const auto offer = [&](double range, std::size_t surface) {
    if (!(range > 0 && range <= limit)) return;
    limit = range;
    nearest = {range, surface};
  };
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    const Segment& wall = walls_[w];
    const double x = wall.x - origin.x;
    const double z = wall.z - origin.z;
    // Signed distances of the wall's ends from the ray; the ray meets it between unlike ones.
    const double from = cosine * z - sine * x;
    const double to = from + cosine * wall.dz - sine * wall.dx;
    if ((from > 0 && to > 0) || (from < 0 && to < 0) || from == to) continue;
    const double along = from / (from - to);
    offer(cosine * (x + along * wall.dx) + sine * (z + along * wall.dz), w);
  }
  for (std::size_t p = 0; p < pillars_.size(); ++p) {
    const Circle& pillar = pillars_[p];
    const double x = pillar.x - origin.x;
    const double z = pillar.z - origin.z;
    const double across = cosine * z - sine * x;
    const double half_chord = pillar.squared_radius - across * across;
    if (half_chord < 0) continue;
    offer(cosine * x + sine * z - std::sqrt(half_chord), walls_.size() + p);
  }
  return nearest;
}

}  // namespace ilss
