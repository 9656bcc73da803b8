// The simulated world behind a picture, as the sensor that looks at it sees it.
#pragma once

#include <optional>

#include "framework/graph/system.h"
#include "framework/report/picture.h"

namespace ilss {

/// The scene that a node of the system simulates its readings in at `time` (s): in the frame of its
/// output, a laser's in its robot's; nothing where it simulates none, or its output is not in a
/// plane.
std::optional<PictureScene> scene_behind(const System& system, std::size_t node, double time);

}  // namespace ilss
