#include "sensors/lep/lep_beam.h"

#include <cmath>

namespace ilss {

LepBeamCaster::LepBeamCaster(const LepGeometry<double>& geometry, const LepBeam& beam)
    : geometry_(geometry), current_at_1m_(beam.current_at_1m) {
  double sum = 0;
  for (std::int64_t i = 0; i < beam.rays; ++i) {
    // From -1 to 1 across the beam.
    const double place =
        beam.rays == 1 ? 0 : 2.0 * static_cast<double>(i) / static_cast<double>(beam.rays - 1) - 1;
    constexpr double edge = 2;  // standard deviations
    offsets_.push_back(place * beam.width / 2);
    weights_.push_back(std::exp(-(edge * place) * (edge * place) / 2));
    sum += weights_.back();
  }
  for (double& weight : weights_) weight /= sum;
}

/// The scene in the laser's axes: those that lie wholly behind it or beside the beam are left to
/// `nearest` and `hidden`, for which they are cheap.
void LepBeamCaster::look(const Scene& scene, const ScenePose& laser) {
  const double c = std::cos(laser.heading);
  const double s = std::sin(laser.heading);
  const auto seen = [&](const ScenePoint& point) {
    const double dx = point.x - laser.x;
    const double dz = point.z - laser.z;
    return Seen{c * dx + s * dz, -s * dx + c * dz};
  };
  walls_.clear();
  pillars_.clear();
  for (const Wall& wall : scene.walls)
    walls_.push_back({seen(wall.from), seen(wall.to), wall.reflectivity});
  for (const Pillar& pillar : scene.pillars)
    pillars_.push_back({seen(pillar.centre), pillar.radius, pillar.reflectivity});
}

/// Where the ray at `across` first meets something.
LepBeamCaster::Hit LepBeamCaster::nearest(double across) const {
  Hit hit{{INFINITY, across}, 0, 0, false};
  const auto offer = [&](double along, double reflectivity, std::size_t surface) {
    if (along > 0 && along < hit.point.along) hit = {{along, across}, reflectivity, surface, true};
  };
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    const SeenWall& wall = walls_[w];
    const double from = across - wall.from.across;
    const double to = across - wall.to.across;
    if ((from < 0) == (to < 0)) continue;
    offer(wall.from.along + from / (from - to) * (wall.to.along - wall.from.along),
          wall.reflectivity, w);
  }
  for (std::size_t p = 0; p < pillars_.size(); ++p) {
    const SeenPillar& pillar = pillars_[p];
    const double offset = across - pillar.centre.across;
    const double square = pillar.radius * pillar.radius - offset * offset;
    if (square > 0)
      offer(pillar.centre.along - std::sqrt(square), pillar.reflectivity, walls_.size() + p);
  }
  return hit;
}

/// Whether something stands between a ray's end and the lens, or the surface turns its back to it.
bool LepBeamCaster::hidden(const Hit& hit, const Seen& lens) const {
  const Seen& p = hit.point;
  const Seen d{lens.along - p.along, lens.across - p.across};
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    const SeenWall& wall = walls_[w];
    const Seen e{wall.to.along - wall.from.along, wall.to.across - wall.from.across};
    const auto side_of_wall = [&](const Seen& point) {
      return e.along * (point.across - wall.from.across) -
             e.across * (point.along - wall.from.along);
    };
    if (w == hit.surface) {
      // The ray came from across the origin; the lens must be on that side, too.
      if ((side_of_wall({p.along - 1, p.across}) < 0) != (side_of_wall(lens) < 0)) return true;
      continue;
    }
    if ((side_of_wall(p) < 0) == (side_of_wall(lens) < 0)) continue;
    const auto side_of_sight = [&](const Seen& point) {
      return d.along * (point.across - p.across) - d.across * (point.along - p.along);
    };
    if ((side_of_sight(wall.from) < 0) != (side_of_sight(wall.to) < 0)) return true;
  }
  const double length = std::hypot(d.along, d.across);
  for (std::size_t c = 0; c < pillars_.size(); ++c) {
    const SeenPillar& pillar = pillars_[c];
    const Seen to{pillar.centre.along - p.along, pillar.centre.across - p.across};
    const double along = (to.along * d.along + to.across * d.across) / length;
    if (walls_.size() + c == hit.surface) {
      if (along > 0) return true;  // the way to the lens starts into the pillar
      continue;
    }
    const double across = (to.along * d.across - to.across * d.along) / length;
    if (along > 0 && along < length && std::abs(across) < pillar.radius) return true;
  }
  return false;
}

LepImage LepBeamCaster::cast(const Scene& scene, const ScenePose& projection, double scan_angle) {
  look(scene, {projection.x, projection.z, projection.heading + scan_angle});
  // The lens lies s behind q = (d, 0) along the optical axis, which is turned from the laser beam
  // by the vergence alone (Pears 1997, figure 2).
  const double gamma = geometry_.vergence;
  const double s = geometry_.lens_distance;
  const double d = geometry_.baseline;
  const Seen lens{d * std::sin(scan_angle) - s * std::cos(gamma),
                  d * std::cos(scan_angle) + s * std::sin(gamma)};
  const double c = std::cos(gamma);
  const double n = std::sin(gamma);
  LepImage image;
  double moment = 0;
  for (std::size_t i = 0; i < offsets_.size(); ++i) {
    const Hit hit = nearest(offsets_[i]);
    if (!hit.found || hidden(hit, lens)) continue;
    const Seen from_lens{hit.point.along - lens.along, hit.point.across - lens.across};
    // Along and across the optical axis, which looks to the left of the beam by gamma.
    const double depth = c * from_lens.along - n * from_lens.across;
    const double side = n * from_lens.along + c * from_lens.across;
    if (depth <= 0) continue;
    const double range_squared =
        hit.point.along * hit.point.along + hit.point.across * hit.point.across;
    const double current = weights_[i] * hit.reflectivity * current_at_1m_ / range_squared;
    image.current += current;
    moment -= current * geometry_.focal_length * side / depth;
  }
  if (image.current > 0) image.image_position = moment / image.current;
  return image;
}

}  // namespace ilss
