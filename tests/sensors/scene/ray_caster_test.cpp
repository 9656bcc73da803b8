// Many rays: the same as one ray after another.
#include "sensors/scene/ray_caster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sensors/scene/beam.h"

namespace ilss {
namespace {

Wall wall(ScenePoint from, ScenePoint to) { return {.from = from, .to = to, .targets = {}}; }

TEST(RayCaster, MeetsTheNearestOfWallsAndPillars) {
  Scene scene;
  scene.walls = {wall({4, -5}, {4, 5}), wall({2, 1}, {2, 5})};
  scene.pillars = {{.centre = {3, -2}, .radius = 0.5}};
  const RayCaster caster(scene);
  const auto ahead = caster.cast({0, 0}, 1, 0, 100);
  ASSERT_TRUE(ahead);
  EXPECT_DOUBLE_EQ(ahead->range, 4);
  EXPECT_EQ(ahead->surface, 0u);
  const auto to_pillar = caster.cast({0, -2}, 1, 0, 100);
  ASSERT_TRUE(to_pillar);
  EXPECT_DOUBLE_EQ(to_pillar->range, 2.5);
  EXPECT_EQ(to_pillar->surface, 2u);
  const auto occluded = caster.cast({0, 3}, 1, 0, 100);
  ASSERT_TRUE(occluded);
  EXPECT_EQ(occluded->surface, 1u);
}

TEST(RayCaster, FindsNothingBehindBeyondItsRangeOrFromInsideAPillar) {
  Scene scene;
  scene.walls = {wall({4, -5}, {4, 5})};
  scene.pillars = {{.centre = {-10, 0}, .radius = 1}};
  const RayCaster caster(scene);
  EXPECT_FALSE(caster.cast({5, 0}, 1, 0, 100));
  EXPECT_FALSE(caster.cast({0, 0}, 1, 0, 3.999));
  EXPECT_FALSE(caster.cast({-10, 0}, 0, 1, 100));
}

TEST(RayCaster, AgreesWithCastRayInRandomScenes) {
  constexpr unsigned seed = 5;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-5, 5);
  std::uniform_real_distribution<double> radius(0.1, 1);
  const auto point = [&] {
    const double x = place(random);
    return ScenePoint{x, place(random)};
  };
  int hits = 0;
  for (int i = 0; i < 200; ++i) {
    Scene scene;
    for (int w = 0; w < 6; ++w) {
      const ScenePoint from = point();
      scene.walls.push_back(wall(from, point()));
    }
    for (int p = 0; p < 3; ++p)
      scene.pillars.push_back({.centre = point(), .radius = radius(random)});
    const RayCaster caster(scene);
    for (int r = 0; r < 20; ++r) {
      const ScenePoint from = point();
      const double heading = place(random);
      const auto expected = cast_ray(scene, {from.x, from.z, heading}, 8);
      const auto hit = caster.cast(from, std::cos(heading), std::sin(heading), 8);
      ASSERT_EQ(hit.has_value(), expected.has_value());
      if (!hit) continue;
      ++hits;
      EXPECT_NEAR(hit->range, expected->range, 1e-9);
      EXPECT_EQ(hit->surface, expected->wall);
    }
  }
  EXPECT_GT(hits, 1000);
}

}  // namespace
}  // namespace ilss
