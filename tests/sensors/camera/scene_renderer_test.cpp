#include "sensors/camera/scene_renderer.h"

#include <gtest/gtest.h>

#include <numeric>

#include "sensors/camera/lens_distortion.h"
#include "tests/sensors/camera/camera_rig.h"

namespace ilss {
namespace {

CameraView view_from(const ScenePose& pose) {
  CameraRig rig;
  return {pose, rig.intrinsics(), 128, 128, 0};
}

Wall plain_wall(ScenePoint from, ScenePoint to, double reflectivity) {
  Wall wall;
  wall.from = from;
  wall.to = to;
  wall.reflectivity = reflectivity;
  return wall;
}

TEST(RenderScene, WallEndsWhereProjectionSays) {
  Scene scene;
  scene.walls = {plain_wall({2, -0.4}, {2, 0.3}, 0.8)};
  const std::vector<double> seen = render_scene(scene, view_from({}));
  // f / pitch = 150 pixels: columns 63.5 - 30 to 63.5 + 22.5, to either side of pixel 33 and 85.5.
  const double* row = seen.data() + 50 * 128;
  EXPECT_NEAR(row[33], 0, 1e-12);
  EXPECT_NEAR(row[34], 0.8, 1e-12);
  EXPECT_NEAR(row[85], 0.8, 1e-12);
  EXPECT_NEAR(row[86], 0.8 * 0.5, 1e-12);
  EXPECT_NEAR(row[87], 0, 1e-12);
  for (std::size_t i = 0; i < 128; ++i) EXPECT_NEAR(seen[i * 128 + 60], 0.8, 1e-12);
}

TEST(RenderScene, NearerWallHidesFartherOneUpToWhereTheyCross) {
  Scene scene;
  scene.walls = {plain_wall({2, -3}, {2, 3}, 0.4), plain_wall({1, -3}, {3, 3}, 0.9)};
  const std::vector<double> seen = render_scene(scene, view_from({}));
  EXPECT_NEAR(seen[50 * 128 + 50], 0.9, 1e-12);  // to the left the second wall is nearer
  EXPECT_NEAR(seen[50 * 128 + 76], 0.4, 1e-12);
  EXPECT_NEAR(seen[50 * 128 + 63], 0.9, 1e-12);  // they cross on the optical axis, column 63.5
  EXPECT_NEAR(seen[50 * 128 + 64], 0.4, 1e-12);
}

TEST(RenderScene, LineAndStripesDoNotCountTwiceWhereTheyCross) {
  const std::vector<double> seen = render_scene(target_scene(), view_from({-1.242, 0, 0}));
  for (const double value : seen) {
    EXPECT_GE(value, 0.1 - 1e-12);
    EXPECT_LE(value, 0.8 + 1e-12);
  }
}

TEST(RenderScene, DarknessOfTheTargetIsItsProjectedArea) {
  Scene scene = target_scene();
  WallTarget& target = scene.walls[0].targets[0];
  target.stripe_count = 1;
  target.along = 3;
  target.line_length = 0.5;
  const std::vector<double> seen = render_scene(scene, view_from({-1.5, 0, 0}));
  double darkness = 0;
  for (const double value : seen) darkness += (0.8 - value) / 0.7;
  // Line 500 x 30 mm and stripe 20 x 200 mm less their crossing, at 100 pixels per metre.
  EXPECT_NEAR(darkness, (0.5 * 0.03 + 0.02 * 0.2 - 0.02 * 0.03) * 1e4, 1e-9);
}

TEST(RenderScene, WallFromEitherSideLooksTheMirrorImage) {
  Scene scene = target_scene();
  const std::vector<double> front = render_scene(scene, view_from({-1.2, 0.05, 0}));
  const std::vector<double> back = render_scene(scene, view_from({1.2, 0.05, std::numbers::pi}));
  for (std::size_t i = 0; i < 128; ++i)
    for (std::size_t j = 0; j < 128; ++j)
      ASSERT_NEAR(front[i * 128 + j], back[i * 128 + 127 - j], 1e-9) << i << " " << j;
}

TEST(RenderScene, DistortionMovesAnEdgeToWhereTheLensShowsIt) {
  Scene scene;
  scene.walls = {plain_wall({2, -3}, {2, 0.4}, 1)};
  CameraView view = view_from({});
  view.intrinsics.k1 = -0.3;
  view.intrinsics.p2 = 0.01;
  const std::vector<double> seen = render_scene(scene, view);
  for (const std::size_t row : {5u, 40u, 63u, 120u}) {
    const double* begin = seen.data() + row * 128;
    const double shown_edge = std::accumulate(begin, begin + 128, 0.0) - 0.5;
    const auto ideal =
        undistort_pixel(view.intrinsics, ImagePoint<double>{shown_edge, static_cast<double>(row)});
    ASSERT_TRUE(ideal);
    EXPECT_NEAR(ideal->column, 63.5 + 150 * 0.2, 2e-4);
  }
}

TEST(RenderScene, WallsBehindAndInThePlaneOfTheCameraAreNotSeen) {
  Scene scene;
  scene.walls = {plain_wall({-2, -3}, {-2, 3}, 1), plain_wall({1, 0}, {3, 0}, 1),
                 plain_wall({0, 1}, {0, 2}, 1)};
  for (const double value : render_scene(scene, view_from({}))) EXPECT_EQ(value, 0);
}

}  // namespace
}  // namespace ilss
