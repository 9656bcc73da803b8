// Range and angle of a wall from two of its points.
#include "sensors/wall/wall_pose.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "framework/module/registry.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;

ModuleRun run_wall_pose(const Output& points) {
  FunctionModule<WallPoseModule> module{WallPoseModule()};
  Tick tick;
  tick.inputs = {&points};
  return run(module, tick);
}

/// Points of the wall at (range, angle), `along1` and `along2` from the foot of the perpendicular.
WallPoints<double> points_on(double range, double angle, double along1, double along2) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {range * c - along1 * s,
          range * s + along1 * c,
          range * c - along2 * s,
          range * s + along2 * c,
          {}};
}

TEST(WallPose, IsTheFootOfThePerpendicularWhicheverPointsTheWallIsGivenBy) {
  constexpr unsigned seed = 4;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int run = 0; run < 1000; ++run) {
    const double range = uniform(0.1, 5);
    const double angle = uniform(-3.1, 3.1);
    const double along = uniform(-2, 2);
    const double spacing = uniform(0.1, 2) * (run % 2 == 0 ? 1 : -1);
    const auto result = run_wall_pose(output_of(points_on(range, angle, along, along + spacing)));
    ASSERT_TRUE(result.outcome);
    ASSERT_NEAR(result.output.estimate.value[0], range, 1e-9);
    ASSERT_NEAR(result.output.estimate.value[1], angle, 1e-9);
  }
}

// Points d apart with independent errors sigma across the wall, the foot midway:
// sd of range = sigma / sqrt(2), sd of angle = sigma sqrt(2) / d.
TEST(WallPose, PropagatesErrorsAcrossTheWallAsByHand) {
  const auto result =
      run_wall_pose(output_of(points_on(1, 0, -0.25, 0.25), {0.001, 0.001, 0.001, 0.001}));
  ASSERT_TRUE(result.outcome);
  EXPECT_NEAR(result.output.estimate.lineage.standard_deviation(0), 0.001 / std::sqrt(2), 1e-12);
  EXPECT_NEAR(result.output.estimate.lineage.standard_deviation(1), 0.001 * std::sqrt(2) / 0.5,
              1e-12);
}

TEST(WallPose, IsDegenerateForOnePointOrAWallThroughTheOrigin) {
  EXPECT_EQ(fault_of(run_wall_pose(output_of<WallPoints>({1, 2, 1, 2, {}})).outcome), "degenerate");
  EXPECT_EQ(fault_of(run_wall_pose(output_of<WallPoints>({1, 2, 2, 4, {}})).outcome), "degenerate");
  EXPECT_EQ(fault_of(run_wall_pose(output_of<WallPoints>({0, 0, 0, 0, {}})).outcome), "degenerate");
}

TEST(WallPose, TakesOnlyPointsInTheRobotsFrame) {
  const Interface interface = function_type<WallPoseModule>().interface({});
  EXPECT_EQ(interface.inputs[0].frame, "robot");
  EXPECT_EQ(interface.frame, "robot");
  EXPECT_FALSE(interface.frame_of_input);
}

TEST(WallPose, KnowsThatItsAngleIsCircular) {
  const Output output = output_of<WallPose>({1, 179 * degree});
  const double truth[] = {1, -179 * degree};
  EXPECT_NEAR(difference(output.estimate, truth)[1], -2 * degree, 1e-12);
}

}  // namespace
}  // namespace ilss
