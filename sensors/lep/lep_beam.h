// What the LEP sensor's laser beam, nine rays wide, brings back from a scene.
#pragma once

#include <cstdint>
#include <vector>

#include "sensors/lep/lep_geometry.h"
#include "sensors/scene/scene.h"

namespace ilss {

/// The laser beam and what of its light comes back (Pears 1997, sec. 3.3).
struct LepBeam {
  double width = 0.003;   ///< between the outermost rays: two standard deviations each side
  std::int64_t rays = 9;  ///< parallel, of Gaussian intensity
  double current_at_1m = 25.8e-9;  ///< I_0 z² of a surface of reflectivity 1 (A m²), Table 2
};

/// The light of one reading on the photodiode: nothing where `current` is 0.
struct LepImage {
  double current = 0;         ///< detector current I_0 (A)
  double image_position = 0;  ///< of its centroid (m)
};

/// Casts the rays of one laser position after another into a scene; keeps its buffers.
class LepBeamCaster {
 public:
  LepBeamCaster(const LepGeometry<double>& geometry, const LepBeam& beam);

  /// The image with the projection frame at `projection` (heading: where its z axis looks) and the
  /// laser at `scan_angle` (rad, from z towards x, to the right). Each ray ends at the nearest wall
  /// or pillar and adds current ~ intensity · reflectivity / range² at its own image position,
  /// unless the scene hides its end from the lens (a missing part).
  LepImage cast(const Scene& scene, const ScenePose& projection, double scan_angle);

 private:
  /// A point as the laser sees it: along the beam, and across it to the right (m).
  struct Seen {
    double along;
    double across;
  };
  struct SeenWall {
    Seen from;
    Seen to;
    double reflectivity;
  };
  struct SeenPillar {
    Seen centre;
    double radius;
    double reflectivity;
  };
  struct Hit {
    Seen point;
    double reflectivity;
    std::size_t surface;  ///< wall, or, after the walls, pillar
    bool found;
  };

  void look(const Scene& scene, const ScenePose& laser);
  Hit nearest(double across) const;
  bool hidden(const Hit& hit, const Seen& lens) const;

  LepGeometry<double> geometry_;
  double current_at_1m_;
  std::vector<double> offsets_;  ///< of each ray to the right of the beam's axis (m)
  std::vector<double> weights_;  ///< their shares of the laser's power
  std::vector<SeenWall> walls_;
  std::vector<SeenPillar> pillars_;
};

}  // namespace ilss
