// Pillars in a scene, for every sensor that looks at it; and what is wrong with a scene file.
#include "sensors/scene/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <random>

#include "sensors/camera/camera.h"
#include "sensors/scene/beam.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double far = std::numeric_limits<double>::infinity();

Scene pillar_at(double x, double z, double radius) {
  Scene scene;
  scene.pillars = {{{x, z}, radius, 0.8}};
  return scene;
}

std::string mistakes_in(const std::string& yaml) {
  Diagnostics diagnostics;
  options_from<Scene>(yaml, diagnostics);
  std::string text;
  for (const Diagnostic& d : diagnostics.sorted()) text += format_diagnostic(d) + "\n";
  return text;
}

TEST(PillarInBeam, IsNearestTowardsItsCentre) {
  const ScenePose beam{0.5, -0.2, 20 * degree};
  const double towards = beam.heading + 7 * degree;
  const Scene scene =
      pillar_at(beam.x + 2 * std::cos(towards), beam.z + 2 * std::sin(towards), 0.3);
  const auto hit = nearest_in_beam(scene, beam, 11 * degree, far);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range, 1.7, 1e-12);
  EXPECT_NEAR(hit->point.x, beam.x + 1.7 * std::cos(towards), 1e-12);
  EXPECT_NEAR(hit->point.z, beam.z + 1.7 * std::sin(towards), 1e-12);
  EXPECT_EQ(hit->wall, 0u) << "counted after the walls, of which there are none";
}

TEST(PillarInBeam, IsMetAtTheBeamsEdgeWhereItsCentreIsOutside) {
  const Scene scene = pillar_at(2 * std::cos(15 * degree), -2 * std::sin(15 * degree), 0.3);
  const auto hit = nearest_in_beam(scene, {}, 11 * degree, far);
  ASSERT_TRUE(hit);
  const double across = 2 * std::sin(4 * degree);
  const double range = 2 * std::cos(4 * degree) - std::sqrt(0.09 - across * across);
  EXPECT_NEAR(hit->range, range, 1e-12);
  EXPECT_NEAR(hit->point.z, -range * std::sin(11 * degree), 1e-12);
}

TEST(PillarInBeam, IsNotSeenBesideTheBeamBehindItOrFromInside) {
  EXPECT_FALSE(nearest_in_beam(pillar_at(2, 1, 0.3), {}, 11 * degree, far));
  EXPECT_FALSE(nearest_in_beam(pillar_at(-2, 0, 0.3), {}, 11 * degree, far));
  EXPECT_FALSE(nearest_in_beam(pillar_at(0.1, 0, 0.3), {}, 11 * degree, far));
  EXPECT_FALSE(nearest_in_beam(pillar_at(2, 0, 0.3), {}, 11 * degree, 1.69));
}

TEST(PillarInBeam, CountsAfterTheWallsAndHidesWhatIsBehindIt) {
  Scene scene = pillar_at(2, 0, 0.3);
  scene.walls = {{{3, -5}, {3, 5}, 0.8, {}}, {{4, -5}, {4, 5}, 0.8, {}}};
  const auto before = cast_ray(scene, {}, far);
  ASSERT_TRUE(before);
  EXPECT_EQ(before->wall, 2u);
  EXPECT_NEAR(before->range, 1.7, 1e-12);
  const auto beside = cast_ray(scene, {0, 0.31, 0}, far);
  ASSERT_TRUE(beside);
  EXPECT_EQ(beside->wall, 0u);
}

// A beam is the union of its rays.
TEST(PillarInBeam, IsTheShortestOfItsRaysOverRandomScenes) {
  constexpr unsigned seed = 41;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int seen = 0;
  for (int run = 0; run < 500; ++run) {
    Scene scene;
    for (int p = 0; p < 3; ++p) {
      Pillar pillar{{uniform(-3, 3), uniform(-3, 3)}, uniform(0.05, 0.6), 0.8};
      scene.pillars.push_back(pillar);
    }
    const ScenePose beam{uniform(-1, 1), uniform(-1, 1), uniform(-4, 4)};
    const double half_angle = uniform(2, 40) * degree;
    double shortest = far;
    constexpr int rays = 1000;
    for (int i = 0; i <= rays; ++i) {
      const double heading = beam.heading + half_angle * (2.0 * i / rays - 1);
      if (const auto hit = cast_ray(scene, {beam.x, beam.z, heading}, far))
        shortest = std::min(shortest, hit->range);
    }
    const auto hit = nearest_in_beam(scene, beam, half_angle, far);
    if (!hit) {
      EXPECT_EQ(shortest, far) << "run " << run;
      continue;
    }
    ++seen;
    EXPECT_LE(hit->range, shortest + 1e-9) << "run " << run;
    EXPECT_GT(hit->range, shortest - 0.1) << "run " << run;
    const Pillar& pillar = scene.pillars[hit->wall];
    EXPECT_NEAR(std::hypot(hit->point.x - pillar.centre.x, hit->point.z - pillar.centre.z),
                pillar.radius, 1e-9);
  }
  EXPECT_GT(seen, 100);
}

TEST(SceneFile, ReadsWallsAndPillars) {
  Diagnostics diagnostics;
  const auto scene = options_from<Scene>(
      "{scene: Hall, walls: [{from: {x: 1 m, z: -1 m}, to: {x: 1 m, z: 1 m}, reflectivity: 0.5}], "
      "pillars: [{centre: {x: 80 cm, z: 0.1 m}, radius: 5 cm}]}",
      diagnostics);
  EXPECT_TRUE(diagnostics.sorted().empty());
  ASSERT_EQ(scene.walls.size(), 1u);
  EXPECT_EQ(scene.walls[0].reflectivity, 0.5);
  ASSERT_EQ(scene.pillars.size(), 1u);
  EXPECT_DOUBLE_EQ(scene.pillars[0].centre.x, 0.8);
  EXPECT_DOUBLE_EQ(scene.pillars[0].radius, 0.05);
  EXPECT_EQ(scene.pillars[0].reflectivity, 0.8);
}

TEST(SceneFile, SaysWhatIsWrongWithAPillarOrAWall) {
  const std::string walls = "walls: [{from: {x: 1 m, z: 0 m}, to: {x: 1 m, z: 1 m}}]";
  const std::string centre = "centre: {x: 1 m, z: 0 m}";
  EXPECT_NE(mistakes_in("{" + walls + ", pillars: [{" + centre + ", radius: 0 m}]}")
                .find("a pillar's radius must be above 0"),
            std::string::npos);
  EXPECT_NE(mistakes_in("{" + walls + ", pillars: [{" + centre + "}]}").find("radius"),
            std::string::npos);
  EXPECT_NE(mistakes_in("{" + walls + ", pillars: [{radius: 0.1 m}]}").find("centre"),
            std::string::npos);
  EXPECT_NE(mistakes_in("{" + walls + ", pillars: [{" + centre + ", radius: -0.1 m}]}"), "");
  EXPECT_NE(mistakes_in("{" + walls + ", pillars: [{" + centre + ", radius: 0.1}]}"), "")
      << "a length without a unit";
  EXPECT_NE(mistakes_in("{walls: [{from: {x: 1 m, z: 2 m}, to: {x: 1 m, z: 2 m}}]}")
                .find("two different ends"),
            std::string::npos);
  EXPECT_NE(mistakes_in("{pillars: []}").find("walls"), std::string::npos);
  EXPECT_EQ(mistakes_in("{" + walls + "}"), "");
}

TEST(SceneFile, OfACameraMayHoldNoPillar) {
  const std::string path = ::testing::TempDir() + "/ilss_OfACameraMayHoldNoPillar.yaml";
  std::ofstream(path) << "walls: [{from: {x: 1 m, z: -1 m}, to: {x: 1 m, z: 1 m}}]\n"
                         "pillars: [{centre: {x: 0.8 m, z: 0 m}, radius: 5 cm}]\n";
  Diagnostics diagnostics;
  options_from<Camera::Options>("{input: {scene: " + path + "}}", diagnostics);
  bool said = false;
  for (const Diagnostic& d : diagnostics.sorted())
    said |= d.message.find("cannot draw pillars") != std::string::npos;
  EXPECT_TRUE(said);
}

}  // namespace
}  // namespace ilss
