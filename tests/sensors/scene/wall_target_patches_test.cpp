#include "sensors/scene/wall_target_patches.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace ilss {
namespace {

double area(const std::vector<WallPatch>& patches) {
  double sum = 0;
  for (const WallPatch& patch : patches)
    sum += (patch.along_end - patch.along_begin) * (patch.top - patch.bottom);
  return sum;
}

Wall wall_with_target() {
  Wall wall;
  wall.to = {0, 4};
  WallTarget target;
  target.along = 1;
  target.line_length = 1;
  wall.targets.push_back(target);
  return wall;
}

TEST(TargetPatches, CrossingOfLineAndStripeCountsOnce) {
  // Line 1 m x 30 mm, two stripes 20 mm x 200 mm.
  EXPECT_NEAR(area(target_patches(wall_with_target())), 0.03 + 2 * 0.02 * (0.2 - 0.03), 1e-15);
}

TEST(TargetPatches, NoTwoPatchesOverlap) {
  Wall wall = wall_with_target();
  wall.targets.push_back(wall.targets.front());
  wall.targets.back().along += 0.013;
  wall.targets.back().height += 0.01;
  wall.targets.back().reflectivity = 0.5;
  const auto patches = target_patches(wall);
  for (std::size_t i = 0; i < patches.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double width = std::min(patches[i].along_end, patches[j].along_end) -
                           std::max(patches[i].along_begin, patches[j].along_begin);
      const double height =
          std::min(patches[i].top, patches[j].top) - std::max(patches[i].bottom, patches[j].bottom);
      EXPECT_FALSE(width > 0 && height > 0) << i << " " << j;
    }
}

TEST(TargetPatches, LaterTargetIsInFront) {
  Wall wall = wall_with_target();
  wall.targets.push_back(wall.targets.front());
  wall.targets.back().reflectivity = 0.5;
  for (const WallPatch& patch : target_patches(wall)) EXPECT_EQ(patch.reflectivity, 0.5);
}

TEST(TargetPatches, PartsBeyondTheWallAreCutOff) {
  Wall wall = wall_with_target();
  wall.targets[0].line_length = 100;
  for (const WallPatch& patch : target_patches(wall)) {
    EXPECT_GE(patch.along_begin, 0);
    EXPECT_LE(patch.along_end, 4);
  }
}

}  // namespace
}  // namespace ilss
