// The nearest point of a scene inside a beam.
#include "sensors/scene/beam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double far = std::numeric_limits<double>::infinity();

Scene scene_of(std::initializer_list<std::pair<ScenePoint, ScenePoint>> walls) {
  Scene scene;
  for (const auto& [from, to] : walls) scene.walls.push_back({from, to, 0.8, {}});
  return scene;
}

TEST(NearestInBeam, IsTheFootOfThePerpendicularInsideTheBeam) {
  const Scene scene = scene_of({{{2, -5}, {2, 5}}});
  const auto hit = nearest_in_beam(scene, {0, 0.5, 5 * degree}, 11 * degree, far);
  ASSERT_TRUE(hit);
  EXPECT_DOUBLE_EQ(hit->range, 2);
  EXPECT_NEAR(hit->point.x, 2, 1e-12);
  EXPECT_NEAR(hit->point.z, 0.5, 1e-12);
}

TEST(NearestInBeam, LiesOnTheBeamsEdgeWhenThePerpendicularIsOutside) {
  const Scene scene = scene_of({{{2, -5}, {2, 5}}});
  const auto hit = nearest_in_beam(scene, {0, 0, 30 * degree}, 11 * degree, far);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range, 2 / std::cos(19 * degree), 1e-12);
  EXPECT_NEAR(hit->point.z, 2 * std::tan(19 * degree), 1e-12);
}

TEST(NearestInBeam, EndsWhereTheWallEnds) {
  const Scene scene = scene_of({{{2, 0.1}, {2, 5}}});
  const auto hit = nearest_in_beam(scene, {0, 0, 0}, 11 * degree, far);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range, std::hypot(2, 0.1), 1e-12);
}

TEST(NearestInBeam, SeesNothingBehindTheSonar) {
  const Scene scene = scene_of({{{-2, -5}, {-2, 5}}});
  EXPECT_FALSE(nearest_in_beam(scene, {0, 0, 0}, 11 * degree, far));
}

TEST(NearestInBeam, SeesNothingBeyondItsMaximumRange) {
  const Scene scene = scene_of({{{2, -5}, {2, 5}}});
  EXPECT_FALSE(nearest_in_beam(scene, {0, 0, 0}, 11 * degree, 1.99));
}

TEST(NearestInBeam, TakesTheNearerOfTwoWalls) {
  const Scene scene = scene_of({{{3, -5}, {3, 5}}, {{2, -5}, {2, 5}}});
  const auto hit = nearest_in_beam(scene, {0, 0, 0}, 11 * degree, far);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->wall, 1u);
}

TEST(CastRay, MeetsTheFirstWallOnItsWay) {
  const Scene scene = scene_of({{{3, -5}, {3, 5}}, {{2, 1}, {2, 5}}});
  const auto straight = cast_ray(scene, {0, 0, 0}, far);
  ASSERT_TRUE(straight);
  EXPECT_DOUBLE_EQ(straight->range, 3);
  const auto aside = cast_ray(scene, {0, 0, 45 * degree}, far);
  ASSERT_TRUE(aside);
  EXPECT_NEAR(aside->range, 2 * std::numbers::sqrt2, 1e-12);
  EXPECT_EQ(aside->wall, 1u);
}

// A beam is the union of its rays, so no ray is nearer than the beam and a fine fan comes close.
TEST(NearestInBeam, IsTheShortestOfItsRaysOverRandomScenes) {
  constexpr unsigned seed = 20;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int seen = 0;
  for (int run = 0; run < 1000; ++run) {
    Scene scene;
    for (int w = 0; w < 3; ++w)
      scene.walls.push_back(
          {{uniform(-3, 3), uniform(-3, 3)}, {uniform(-3, 3), uniform(-3, 3)}, 0.8, {}});
    const ScenePose beam{uniform(-1, 1), uniform(-1, 1), uniform(-4, 4)};
    const double half_angle = uniform(2, 40) * degree;
    double shortest = far;
    constexpr int rays = 2000;
    for (int i = 0; i <= rays; ++i) {
      const double offset = half_angle * (2.0 * i / rays - 1);
      if (const auto hit = cast_ray(scene, {beam.x, beam.z, beam.heading + offset}, far))
        shortest = std::min(shortest, hit->range);
    }
    const auto hit = nearest_in_beam(scene, beam, half_angle, far);
    if (!hit) {
      EXPECT_EQ(shortest, far) << "run " << run;
      continue;
    }
    ++seen;
    EXPECT_LE(hit->range, shortest + 1e-9) << "run " << run;
    EXPECT_NEAR(std::hypot(hit->point.x - beam.x, hit->point.z - beam.z), hit->range, 1e-9);
    EXPECT_TRUE(shortest == far || hit->range > shortest - 0.05) << "run " << run;
  }
  EXPECT_GT(seen, 300);
}

}  // namespace
}  // namespace ilss
