// The simulated world behind a picture, as the sensor that looks at it sees it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "framework/graph/system.h"

namespace ilss {

/// Walls and pillars; metres, to the right and up in the picture.
struct PictureScene {
  struct Pillar {
    Eigen::Vector2d centre;
    double radius;
  };
  std::string module;  ///< the sensor
  std::string frame;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> walls = {};
  std::vector<Pillar> pillars = {};
};

/// The scene that a node of the system simulates its readings in at `time` (s): in the frame of its
/// output, a laser's in its robot's; nothing where it simulates none, or its output is not in a
/// plane.
std::optional<PictureScene> scene_behind(const System& system, std::size_t node, double time);

}  // namespace ilss
