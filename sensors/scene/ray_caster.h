// Many rays against one scene, for scanners: what each of them meets first.
#pragma once

#include <optional>
#include <vector>

#include "sensors/scene/scene.h"

namespace ilss {

/// What a ray meets.
struct RayHit {
  double range = 0;         ///< m
  std::size_t surface = 0;  ///< index into the scene's walls and, after these, its pillars
};

/// A scene made ready for rays: as cast_ray, but without a sine, an angle or an allocation a ray.
class RayCaster {
 public:
  explicit RayCaster(const Scene& scene);

  std::size_t walls() const { return walls_.size(); }

  /// Where the ray from `origin` along (cosine, sine), from x towards z, first meets a wall or a
  /// pillar's outside, within `max_range` (m).
  std::optional<RayHit> cast(const ScenePoint& origin, double cosine, double sine,
                             double max_range) const;

 private:
  struct Segment {
    double x, z;    ///< its first end (m)
    double dx, dz;  ///< from there to its other end (m)
  };
  struct Circle {
    double x, z, squared_radius;
  };

  std::vector<Segment> walls_;
  std::vector<Circle> pillars_;
};

}  // namespace ilss
