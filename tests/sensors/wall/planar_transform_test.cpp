// Wall points from a mounted sensor's frame into the robot's.
#include "sensors/wall/planar_transform.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;

ModuleRun transform(const WallPoints<double>& points, double x, double z, double heading,
                    PlaneAxes axes, double heading_std = 0) {
  FunctionModule<PlanarTransform> module(PlanarTransform({"camera", "robot", axes}));
  const Output input = output_of(points);
  Tick tick;
  tick.parameters = Estimate(descriptor<PlanarTransform::Parameters>());
  tick.parameters.value = {x, z, heading};
  tick.parameters.lineage.reset(3);
  if (heading_std > 0) tick.parameters.lineage.add({7, 0, persistent_tick}, 2, heading_std);
  tick.inputs = {&input};
  return run(module, tick);
}

void expect_points(const ModuleRun& result, const WallPoints<double>& expected) {
  ASSERT_TRUE(result.outcome);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(result.output.estimate.value[i], components(expected)[i], 1e-12);
}

TEST(PlanarTransform, TurnsCameraAxesIntoTheRobots) {
  // In the camera: 0.2 to the right, 1.5 ahead.
  expect_points(transform({0.2, 1.5, 0, 1, {}}, 0, 0, 0, PlaneAxes::camera), {1.5, 0.2, 1, 0, {}});
}

TEST(PlanarTransform, LeavesRobotAxesAsTheyAreBeforeMoving) {
  expect_points(transform({1.5, 0.2, 1, 0, {}}, 0.1, -0.2, 0, PlaneAxes::robot),
                {1.6, 0, 1.1, -0.2, {}});
}

TEST(PlanarTransform, TurnsToTheRightForAPositiveHeading) {
  // A camera that looks to the robot's right has what is ahead of it on the robot's right.
  expect_points(transform({0, 1, 0.3, 1, {}}, 0.1, 0, 90 * degree, PlaneAxes::camera),
                {0.1, 1, 0.1 - 0.3, 1, {}});
}

TEST(PlanarTransform, PassesTheLabelThrough) {
  const auto result = transform({0, 1, 1, 1, {6}}, 0, 0, 0, PlaneAxes::camera);
  ASSERT_TRUE(result.outcome);
  EXPECT_EQ(result.output.estimate.labels, std::vector<int>{6});
}

TEST(PlanarTransform, CarriesTheMountsErrorIntoBothPoints) {
  const auto result = transform({0, 2, 0, 1, {}}, 0, 0, 0, PlaneAxes::camera, 0.01);
  ASSERT_TRUE(result.outcome);
  const Eigen::MatrixXd covariance = result.output.estimate.lineage.covariance();
  EXPECT_NEAR(covariance(1, 1), 0.02 * 0.02, 1e-12);
  EXPECT_NEAR(covariance(1, 3), 0.02 * 0.01, 1e-12);  // one mount error moves both
}

TEST(PlanarTransform, ConnectsTheFramesOfItsOptions) {
  Diagnostics diagnostics;
  const auto options =
      options_from<PlanarTransform::Options>("{from: left_camera, to: base}", diagnostics);
  ASSERT_TRUE(diagnostics.empty());
  Interface interface = function_type<PlanarTransform>().interface({});
  PlanarTransform::set_frames(interface, options);
  EXPECT_EQ(interface.inputs[0].frame, "left_camera");
  EXPECT_EQ(interface.frame, "base");
}

TEST(PlanarTransform, RefusesToConnectAFrameWithItself) {
  Diagnostics diagnostics;
  options_from<PlanarTransform::Options>("{from: robot}", diagnostics);
  EXPECT_EQ(diagnostics.size(), 1u);
}

}  // namespace
}  // namespace ilss
