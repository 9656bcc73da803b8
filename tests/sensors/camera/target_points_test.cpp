#include "sensors/camera/target_points.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "framework/estimate/consistency.h"
#include "framework/graph/given_outputs.h"
#include "sensors/camera/vision_line.h"
#include "sensors/wall/wall_pose.h"
#include "tests/sensors/camera/camera_rig.h"

namespace ilss {
namespace {

constexpr double confidence = 0.99;

/// Renders and measures: the image stays in `image`, the rows in `rows`.
struct Measurement {
  CameraRig rig;
  std::unique_ptr<Camera> camera;
  TargetPoints points;
  Output image;
  Output rows;

  explicit Measurement(const CameraRig& with, TargetPoints::Options options = {})
      : rig(with), camera(std::make_unique<Camera>(with.options)), points(options) {
    image.estimate = Estimate(descriptor<Image>(), "camera");
    rows.estimate = Estimate(descriptor<TargetRows>(), "camera");
  }
  Outcome<> operator()(std::uint64_t seed) {
    if (auto outcome = run(*camera, rig.parameters, nullptr, seed, image, 1); !outcome)
      return outcome;
    return run(points, Estimate{}, &image, seed, rows, 2);
  }
};

/// Depth along the optical axis and angle, which are what the three rows say of a wall.
NormalizedError nees_of_two(const Estimate& rows, const TargetRows<double>& truth) {
  Eigen::Matrix<double, 2, 3> selection;
  selection << 0, 1, 0, 1, 0, -1;
  return normalized_squared_error(selection * difference(rows, components(truth)),
                                  selection * rows.lineage.covariance() * selection.transpose());
}

/// NEES of the wall's range and angle from a wall line in the camera's frame.
NormalizedError nees_of_wall_pose(const Estimate& points, const WallPoseTruth& truth) {
  std::array<Dual<4>, 4> p;
  seed_variables<4>(points.value, 0, p);
  const auto pose = wall_pose_through(p[1], p[0], p[3], p[2]);
  EXPECT_TRUE(pose);
  Eigen::Matrix<double, 2, 4> jacobian;
  jacobian << pose->range.v.transpose(), pose->angle.v.transpose();
  const Eigen::Vector2d error(pose->range.a - truth.range, pose->angle.a - truth.angle);
  return normalized_squared_error(error,
                                  jacobian * points.lineage.covariance() * jacobian.transpose());
}

class PaperPoses : public ::testing::TestWithParam<WallPoseTruth> {};
INSTANTIATE_TEST_SUITE_P(TargetPoints, PaperPoses, ::testing::ValuesIn(paper_poses),
                         [](const auto& pose) {
                           return std::to_string(std::lround(pose.param.range * 1000)) + "mm";
                         });

TEST_P(PaperPoses, RowsAndWallPoseAreAsWrongAsTheySay) {
  SCOPED_TRACE("seeds 1000 to 2999");
  CameraRig rig;
  rig.place(GetParam());
  Measurement measure(rig);
  FunctionModule<VisionLine> vision_line{VisionLine()};
  Estimate parameters(descriptor<VisionLine::Parameters>());
  parameters.value = {target_height, stripe_spacing, rig.parameter("focal_length"), 1};
  Output points;
  points.estimate = Estimate(descriptor<WallPoints>(), "camera");
  const TargetRows<double> truth = rig.true_rows(GetParam());

  ConsistencyStatistic three_rows, two_rows, wall_pose;
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
  constexpr int runs = 2000;
  for (std::uint64_t seed = 1000; seed < 1000 + runs; ++seed) {
    const auto outcome = measure(seed);
    ASSERT_TRUE(outcome) << (outcome.is_fault() ? outcome.fault().message : "") << " " << seed;
    three_rows.add(nees(measure.rows.estimate, components(truth)));
    two_rows.add(nees_of_two(measure.rows.estimate, truth));
    error += difference(measure.rows.estimate, components(truth)) / rig.parameter("pixel_pitch");
    ASSERT_TRUE(run(vision_line, parameters, &measure.rows, seed, points));
    wall_pose.add(nees_of_wall_pose(points.estimate, GetParam()));
  }
  EXPECT_TRUE(two_rows.consistent(confidence)) << two_rows.mean();
  EXPECT_TRUE(wall_pose.consistent(confidence)) << wall_pose.mean();
  // Seen square on, the line is level: where along it the stripes stand has no part in the error,
  // and the third direction's error, a product of two, is below what first order says.
  if (GetParam().angle != 0) {
    EXPECT_TRUE(three_rows.consistent(confidence)) << three_rows.mean();
  }
  EXPECT_LT((error / runs).cwiseAbs().maxCoeff(), 1e-4);  // pixels; one image's error is 1e-3
}

TEST(TargetPoints, RowsThroughADistortingLensAreAsWrongAsTheySay) {
  SCOPED_TRACE("seeds 1 to 500");
  const WallPoseTruth pose = paper_poses[3];
  CameraRig rig;
  rig.place(pose);
  rig.parameter("k1") = -0.25;
  rig.parameter("k2") = 0.06;
  rig.parameter("p1") = 1e-3;
  rig.parameter("p2") = -2e-3;
  rig.parameter("principal_row") = 66;
  rig.parameter("principal_column") = 60;
  Measurement measure(rig);
  const TargetRows<double> truth = rig.true_rows(pose);
  ConsistencyStatistic statistic;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    ASSERT_TRUE(measure(seed));
    statistic.add(nees(measure.rows.estimate, components(truth)));
  }
  EXPECT_TRUE(statistic.consistent(confidence)) << statistic.mean();
}

TEST(TargetPoints, RowsOfALargeImageAreAsWrongAsTheySay) {
  SCOPED_TRACE("seeds 1 to 100");
  const WallPoseTruth pose = paper_poses[1];
  CameraRig rig;
  rig.place(pose);
  rig.options.rows = 480;
  rig.options.columns = 640;
  rig.parameter("pixel_pitch") = 10e-6;
  rig.parameter("principal_row") = 239.5;
  rig.parameter("principal_column") = 319.5;
  Measurement measure(rig);
  ConsistencyStatistic statistic;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    ASSERT_TRUE(measure(seed));
    statistic.add(nees(measure.rows.estimate, components(rig.true_rows(pose))));
  }
  EXPECT_TRUE(statistic.consistent(confidence)) << statistic.mean();
}

TEST(TargetPoints, CovarianceFollowsTheImagesNoise) {
  CameraRig quiet;
  quiet.place(paper_poses[0]);
  CameraRig loud = quiet;
  quiet.options.noise_std = 2;
  loud.options.noise_std = 8;
  Measurement measure_quiet(quiet);
  Measurement measure_loud(loud);
  ASSERT_TRUE(measure_quiet(1));
  ASSERT_TRUE(measure_loud(1));
  const double ratio = measure_loud.rows.estimate.lineage.standard_deviation(1) /
                       measure_quiet.rows.estimate.lineage.standard_deviation(1);
  EXPECT_NEAR(ratio, 4, 0.4);
}

TEST(TargetPoints, CamerasErrorsAreMappedThroughTheWholeFit) {
  // Measures one image with the camera's components a little more and less than they are.
  CameraRig rig;
  rig.place(paper_poses[3]);
  rig.parameter("k1") = -0.2;
  rig.parameter("k2") = 0.05;
  rig.parameter("p1") = 1e-3;
  rig.parameter("k3") = 0.01;
  Measurement measure(rig);
  ASSERT_TRUE(measure(17));
  const std::array<double, dimension_of<Image>> steps = {1e-9, 1e-3, 1e-3, 1e-7, 1e-5,
                                                         1e-5, 1e-6, 1e-6, 1e-5, 0};
  const Output image = measure.image;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i] == 0) continue;
    Output rows = measure.rows;
    Output varied = image;
    constexpr Source source{9, 0, persistent_tick};
    varied.estimate.lineage.add(source, i, steps[i]);
    ASSERT_TRUE(run(measure.points, Estimate{}, &varied, 1, rows, 2));
    const auto& sources = rows.estimate.lineage.sources();
    const auto k = std::find(sources.begin(), sources.end(), source) - sources.begin();
    ASSERT_LT(k, std::ssize(sources));
    const std::vector<double> stated = [&] {
      const auto column = rows.estimate.lineage.column(static_cast<std::size_t>(k));
      return std::vector<double>(column.begin(), column.end());
    }();
    varied = image;
    varied.estimate.value[i] += steps[i];
    ASSERT_TRUE(run(measure.points, Estimate{}, &varied, 1, rows, 2));
    const std::vector<double> more = rows.estimate.value;
    varied.estimate.value[i] -= 2 * steps[i];
    ASSERT_TRUE(run(measure.points, Estimate{}, &varied, 1, rows, 2));
    for (std::size_t c = 0; c < 3; ++c) {
      const double found = 0.5 * (more[c] - rows.estimate.value[c]);
      EXPECT_NEAR(stated[c], found, 0.02 * std::abs(found) + 2e-11)
          << Image<double>::fields[i].name << " row " << c;
    }
  }
}

TEST(TargetPoints, PositionStdAddsToEachRowIndependently) {
  CameraRig rig;
  rig.place(paper_poses[0]);
  Measurement without(rig);
  rig.parameter("position_std") = 0.1;
  Measurement with(rig);
  ASSERT_TRUE(without(3));
  ASSERT_TRUE(with(3));
  const Eigen::Matrix3d added =
      with.rows.estimate.lineage.covariance() - without.rows.estimate.lineage.covariance();
  const double variance = std::pow(0.1 * rig.parameter("pixel_pitch"), 2);
  EXPECT_TRUE(added.isApprox(variance * Eigen::Matrix3d::Identity(), 1e-9)) << added;
}

TEST(TargetPoints, ExpectedErrorIsThatOfMeasuredImages) {
  CameraRig rig;
  rig.place(paper_poses[1]);
  Measurement measure(rig);
  ASSERT_TRUE(measure(3));
  const Estimate none;
  const Evaluation for_camera{0, {}, 1, 1, rig.parameters, {}};
  Output image = measure.image;
  ASSERT_TRUE(measure.camera->expect(for_camera, nullptr, image));
  const std::array<const Output*, 1> inputs = {&image};
  Output expected = measure.rows;
  const Evaluation for_points{0, {}, 1, 2, none, inputs};
  ASSERT_TRUE(measure.points.expect(for_points, nullptr, expected));
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(expected.estimate.lineage.standard_deviation(i) /
                    measure.rows.estimate.lineage.standard_deviation(i),
                1, 0.15);
}

TEST(TargetPoints, AtAnOperatingPointTheErrorIsRowStdOrNotKnown) {
  CameraRig rig;
  Output point;
  point.estimate = Estimate(descriptor<TargetRows>(), "camera");
  point.estimate.value = {1e-3, 1.1e-3, 1.2e-3};
  const Estimate none;
  const std::array<const Output*, 1> inputs = {&point};
  const Evaluation evaluation{0, {}, 1, 2, none, inputs};
  Output output = point;
  const auto unknown = TargetPoints({}).expect(evaluation, &point, output);
  ASSERT_TRUE(unknown.is_fault());
  EXPECT_EQ(unknown.fault().kind, FaultKind::no_error_known);
  ASSERT_TRUE(TargetPoints({2e-6}).expect(evaluation, &point, output));
  EXPECT_TRUE(output.estimate.lineage.covariance().isApprox(4e-12 * Eigen::Matrix3d::Identity()));
}

FaultKind fault_of(const CameraRig& rig) {
  Measurement measure(rig);
  const auto outcome = measure(1);
  EXPECT_TRUE(outcome.is_fault());
  return outcome.is_fault() ? outcome.fault().kind : FaultKind::internal;
}

TEST(TargetPoints, StripeOnTheOpticalAxisIsDegenerate) {
  CameraRig rig;
  rig.place({1.2, 0});
  rig.parameter("robot.z") = first_stripe + 4 * stripe_spacing;
  EXPECT_EQ(fault_of(rig), FaultKind::degenerate);
}

TEST(TargetPoints, LineOnTheHorizonIsDegenerate) {
  Scene scene = target_scene();
  WallTarget& target = scene.walls[0].targets[0];
  target.height = 0;
  target.stripe_bottom = -0.1;
  target.stripe_top = 0.1;
  CameraRig rig(scene);
  rig.place({1.2, 0.1});
  EXPECT_EQ(fault_of(rig), FaultKind::degenerate);
}

TEST(TargetPoints, FewerThanTwoStripesAreNoDetection) {
  Scene scene = target_scene();
  scene.walls[0].targets[0].stripe_count = 1;
  scene.walls[0].targets[0].along = 3.05;
  CameraRig rig(scene);
  rig.place({1.2, 0});
  EXPECT_EQ(fault_of(rig), FaultKind::no_detection);
}

TEST(TargetPoints, WallWithoutTargetIsNoDetection) {
  Scene scene = target_scene();
  scene.walls[0].targets.clear();
  CameraRig rig(scene);
  rig.place({1.2, 0});
  EXPECT_EQ(fault_of(rig), FaultKind::no_detection);
}

/// What target_points makes of arbitrary levels: a fault's kind, or nothing for finite rows.
std::optional<FaultKind> outcome_of(std::size_t rows, std::size_t columns,
                                    const std::vector<std::uint8_t>& levels) {
  CameraRig rig;
  Output image;
  image.estimate = Estimate(descriptor<Image>(), "camera");
  image.estimate.value.assign(rig.parameters.value.begin(), rig.parameters.value.begin() + 10);
  std::copy(levels.begin(), levels.end(), make_levels(image.samples, rows, columns).begin());
  TargetPoints points({});
  Output output;
  output.estimate = Estimate(descriptor<TargetRows>(), "camera");
  const auto outcome = run(points, Estimate{}, &image, 1, output);
  if (outcome.is_fault()) return outcome.fault().kind;
  for (const double y : output.estimate.value) EXPECT_TRUE(std::isfinite(y));
  EXPECT_TRUE(output.estimate.lineage.covariance().allFinite());
  return std::nullopt;
}

TEST(TargetPoints, BlankImagesOfAnySizeAreNoDetection) {
  for (const std::size_t size : {1u, 2u, 3u, 5u, 8u, 16u, 128u, 300u})
    for (const int level : {0, 127, 255})
      EXPECT_EQ(outcome_of(
                    size, size + 1,
                    std::vector<std::uint8_t>(size * (size + 1), static_cast<std::uint8_t>(level))),
                FaultKind::no_detection);
}

TEST(TargetPoints, AnImageWithoutPixelsIsBadData) {
  EXPECT_EQ(outcome_of(0, 0, {}), FaultKind::bad_data);
}

TEST(TargetPoints, PureNoiseIsNoDetection) {
  const std::uint64_t seed = 23;
  SCOPED_TRACE("seed " + std::to_string(seed));
  RandomBits bits(seed);
  for (int trial = 0; trial < 300; ++trial) {
    const std::size_t rows = 1 + bits() % 150;
    const std::size_t columns = 1 + bits() % 150;
    std::vector<std::uint8_t> levels(rows * columns);
    for (auto& level : levels) level = static_cast<std::uint8_t>(bits());
    EXPECT_EQ(outcome_of(rows, columns, levels), FaultKind::no_detection) << rows << " " << columns;
  }
}

TEST(TargetPoints, RandomBarsNeverGiveRowsThatAreNotFinite) {
  const std::uint64_t seed = 29;
  SCOPED_TRACE("seed " + std::to_string(seed));
  RandomBits bits(seed);
  int detections = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const std::size_t rows = 4 + bits() % 140;
    const std::size_t columns = 4 + bits() % 140;
    std::vector<std::uint8_t> levels(rows * columns, 200);
    for (std::uint64_t bar = 1 + bits() % 6; bar > 0; --bar) {
      const bool horizontal = bits() % 2 == 0;
      const std::size_t length = horizontal ? rows : columns;
      const std::size_t begin = bits() % length;
      const std::size_t end = std::min<std::size_t>(length, begin + 1 + bits() % 9);
      for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t j = 0; j < columns; ++j)
          if (const std::size_t at = horizontal ? i : j; begin <= at && at < end)
            levels[i * columns + j] = static_cast<std::uint8_t>(bits() % 64);
    }
    detections += outcome_of(rows, columns, levels) ? 0 : 1;
  }
  EXPECT_GT(detections, 10);
}

}  // namespace
}  // namespace ilss
