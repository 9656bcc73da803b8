// The simulated planar world that every simulated sensor looks at.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "framework/module/parameters.h"

namespace ilss {

/// A point of the plane of motion: x forward and z to the right of the world's origin (m).
struct ScenePoint {
  double x = 0;
  double z = 0;
  void declare(OptionVisitor& visit);
};

/// How far two points are apart (m).
inline double distance(const ScenePoint& a, const ScenePoint& b) {
  return std::hypot(a.x - b.x, a.z - b.z);
}

/// Where something stands and looks: heading from x towards z (rad), so positive is to the right.
struct ScenePose {
  double x = 0;
  double z = 0;
  double heading = 0;
};

/// A target on a wall for cameras (Henderson & Dekhil 1997, figure 3): a horizontal line at a known
/// height above the plane of motion, crossed by vertical stripes a known distance apart.
struct WallTarget {
  double along = 0;              ///< where stripe 0 is centred, from the wall's first end (m)
  double height = 0.2;           ///< of the horizontal line's centre (m)
  double line_thickness = 0.03;  ///< m
  double line_length = 3.0;      ///< centred on the middle of the stripes (m)
  std::int64_t stripe_count = 2;
  double stripe_spacing = 0.3;  ///< centre to centre (m)
  double stripe_width = 0.02;   ///< m
  double stripe_bottom = 0.1;   ///< lower end of the stripes (m)
  double stripe_top = 0.3;      ///< upper end of the stripes (m)
  double reflectivity = 0.1;    ///< of line and stripes
  void declare(OptionVisitor& visit);
};

/// A wall: a segment of the plane, upright and infinitely high.
struct Wall {
  ScenePoint from;
  ScenePoint to;
  double reflectivity = 0.8;  ///< 0 to 1
  std::vector<WallTarget> targets;
  void declare(OptionVisitor& visit);
};

/// A round pillar: a circle of the plane, upright and infinitely high. Range sensors see it; a
/// camera's scene must have none.
struct Pillar {
  ScenePoint centre;
  double radius = 0.1;        ///< m
  double reflectivity = 0.8;  ///< 0 to 1
  void declare(OptionVisitor& visit);
};

/// A scene as read from a scene file.
struct Scene {
  std::string description;
  std::vector<Wall> walls;
  std::vector<Pillar> pillars = {};
  void declare(OptionVisitor& visit);
};

/// Where a thing mounted at `mount` in the frame of `base` stands in the world.
ScenePose compose_poses(const ScenePose& base, const ScenePose& mount);

/// Where a thing is that stood at `pose` and has driven for `time` (s, negative: before) at a speed
/// (m/s) and a turn rate (rad/s, to the right): along a circle.
ScenePose drive(const ScenePose& pose, double speed, double turn_rate, double time);

/// A point of the world seen from `pose`: x along its heading, z to its right.
ScenePoint to_frame(const ScenePose& pose, const ScenePoint& point);

}  // namespace ilss
