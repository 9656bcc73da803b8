// What the targets on a wall look like: disjoint rectangles of one reflectivity each.
#pragma once

#include <vector>

#include "sensors/scene/scene.h"

namespace ilss {

/// A rectangle on a wall: along the wall from its first end, and in height (m).
struct WallPatch {
  double along_begin;
  double along_end;
  double bottom;
  double top;
  double reflectivity;
};

/// The rectangles in which a wall's targets differ from the wall. No two overlap, so that what a
/// line and a stripe both cover counts once; where targets overlap, the later one is in front.
/// Parts beyond the wall's ends are cut off.
std::vector<WallPatch> target_patches(const Wall& wall);

}  // namespace ilss
