// The truth about a simulated wall.
#include "sensors/scene/scene_wall.h"

#include <gtest/gtest.h>

#include <fstream>
#include <numbers>

#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;

SceneWall::Options wall_across(double x) {
  SceneWall::Options options;
  options.scene.content.walls.push_back({{x, -3}, {x, 3}, 0.8, {}});
  return options;
}

Tick robot_at(double x, double z, double heading) {
  Tick tick;
  tick.parameters = Estimate(descriptor<SceneWall::Parameters>());
  tick.parameters.value = {x, z, heading};
  return tick;
}

TEST(SceneWall, GivesTable1sPosesFromTheRobotsPose) {
  // Henderson & Dekhil 1997, table 1, poses 1 to 5: (range, angle) measured by hand.
  SceneWall module(wall_across(0));
  const double poses[5][2] = {{0.919, -21}, {0.930, 20}, {1.242, 0}, {1.164, -11}, {1.283, 6}};
  for (const auto& [range, angle] : poses) {
    const auto result = run(module, robot_at(-range, 0.4, -angle * degree));
    ASSERT_TRUE(result.outcome);
    EXPECT_NEAR(result.output.estimate.value[0], range, 1e-12);
    EXPECT_NEAR(result.output.estimate.value[1], angle * degree, 1e-12);
  }
}

TEST(SceneWall, IsExactEvenWhereTheRobotsPoseIsNot) {
  SceneWall module(wall_across(2));
  Tick tick = robot_at(0, 0, 0);
  tick.parameters.lineage.add({7, 0, persistent_tick}, 0, 0.01);
  const auto result = run(module, tick);
  ASSERT_TRUE(result.outcome);
  EXPECT_TRUE(result.output.estimate.lineage.empty());
}

TEST(SceneWall, IsDegenerateForAWallThroughTheRobot) {
  SceneWall module(wall_across(1));
  EXPECT_EQ(fault_of(run(module, robot_at(1, 0, 0)).outcome), "degenerate");
}

TEST(SceneWall, RefusesAWallThatTheSceneDoesNotHave) {
  const std::string path = ::testing::TempDir() + "/scene_wall_test_scene.yaml";
  std::ofstream(path) << "walls: [{from: {x: 1 m, z: -1 m}, to: {x: 1 m, z: 1 m}}]\n";
  Diagnostics diagnostics;
  options_from<SceneWall::Options>("{scene: " + path + ", wall: 1}", diagnostics);
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_NE(diagnostics.sorted()[0].message.find("fewer walls"), std::string::npos);
}

}  // namespace
}  // namespace ilss
