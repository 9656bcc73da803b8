// Whether features of simulated scans are honest in the world, under a pose that is known so so.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <limits>

#include "framework/estimate/consistency.h"
#include "sensors/features/features_transform.h"
#include "sensors/laser/features/laser_features.h"
#include "tests/sensors/laser/features/simulated_readings.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

using Place = Eigen::Vector2d;  ///< x and z in the world, z to the right of x

/// Two walls that leave a corner, in the world, at 90 to 150 degrees to each other.
struct WorldCorner {
  Place corner;
  std::array<Place, 2> direction;

  explicit WorldCorner(std::mt19937_64& draw) {
    std::uniform_real_distribution<double> unit;
    corner = Place(3 + 2 * unit(draw), -2 + 4 * unit(draw));
    const double towards = std::atan2(corner.y(), corner.x());
    for (int w = 0; w < 2; ++w) {
      const double turn = towards + (w == 0 ? -1 : 1) * (45 + 30 * unit(draw)) * degree;
      direction[static_cast<std::size_t>(w)] = {std::cos(turn), std::sin(turn)};
    }
  }
  /// The nearer of the walls that a ray meets, and how far off.
  double range(const Place& from, const Place& ray) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Place& along : direction) {
      Eigen::Matrix2d system;
      system << ray, -along;
      const Place solution = system.inverse() * (corner - from);
      if (solution.x() > 0 && solution.y() >= 0) nearest = std::min(nearest, solution.x());
    }
    return nearest;
  }
  /// rho and phi of a wall's line.
  std::array<double, 2> line(std::size_t wall) const {
    const Place normal(-direction[wall].y(), direction[wall].x());
    const double rho = normal.dot(corner);
    return {std::abs(rho), std::atan2(normal.y(), normal.x()) + (rho < 0 ? std::numbers::pi : 0)};
  }
};

/// The scan that a robot at a true pose takes, segmented at the corner; the laser is its origin.
Output scan_from(const PlanarPose<double>& pose, const WorldCorner& world,
                 const LaserDevice& device, std::mt19937_64& draw) {
  const Place from(pose.x, pose.z);
  const Place to_corner = world.corner - from;
  // Bearings of the laser count to the left.
  const double bearing = -wrap_angle(std::atan2(to_corner.y(), to_corner.x()) - pose.heading);
  const double step = 0.5 * degree;
  constexpr int half = 25;
  const auto range_at = [&](double cosine, double sine) {
    const double turn = pose.heading - std::atan2(sine, cosine);
    return world.range(from, {std::cos(turn), std::sin(turn)});
  };
  const auto points =
      simulate_readings(device, bearing - (half - 0.5) * step, step, 2 * half, range_at, draw);
  Output scan = output_of<SegmentedScan>(
      {device.range_std, device.bearing_std, device.quantum, 100, 0, 0, 0, 0, 0, 0, 0});
  scan.estimate.frame = "laser";
  const auto rows = make_rows<SegmentedBeam>(scan, points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    rows[i] = {points[i].bearing, points[i].range, i < half ? 1.0 : 2.0};
  return scan;
}

// The joint error of both walls holds the cross-covariance that they have from the pose; the
// corner's has the pose's error, too. 99.9 % bounds over 3,000 runs.
TEST(FeaturesInWorld, AreHonestUnderAPoseOfKnownError) {
  constexpr std::uint64_t seed = 20261123;
  SCOPED_TRACE(seed);
  std::mt19937_64 draw(seed);
  std::normal_distribution<double> normal;
  const std::vector<double> deviation = {0.02, 0.03, 0.5 * degree};
  ConsistencyStatistic corners;
  ConsistencyStatistic walls;
  ConsistencyStatistic without_pose;
  int runs = 0;
  for (; runs < 3000; ++runs) {
    const WorldCorner world(draw);
    const PlanarPose<double> pose{0.3 * normal(draw), 0.3 * normal(draw), 0.2 * normal(draw)};
    const Output scan = scan_from(pose, world, {}, draw);
    LaserFeatures extractor({});
    Tick tick;
    tick.inputs = {&scan};
    const ModuleRun seen = run(extractor, tick);
    ASSERT_TRUE(seen.outcome) << seen.outcome.fault().message;
    PlanarPose<double> told = pose;
    for (std::size_t i = 0; i < 3; ++i) components(told)[i] += deviation[i] * normal(draw);
    const Output stated = output_of<PlanarPose>(told, deviation, 300);
    FeaturesTransform transform({.pose = PoseSource::input});
    tick.parameters = output_of<FeaturesTransform::Parameters>({0, 0, 0}).estimate;
    tick.inputs = {&seen.output, &stated};
    const ModuleRun result = run(transform, tick);
    ASSERT_TRUE(result.outcome);
    std::vector<const Estimate*> lines;
    for (const Estimate& element : result.output.elements) {
      if (element.type == &descriptor<LineSegment>()) lines.push_back(&element);
      if (element.type != &descriptor<Corner>()) continue;
      const std::array<double, 2> truth{world.corner.x(), world.corner.y()};
      corners.add(nees(element, truth));
    }
    if (lines.size() != 2) continue;
    // The scan runs to the left: the wall to the right comes first.
    Eigen::Vector4d error;
    Eigen::Matrix4d covariance;
    for (Eigen::Index a = 0; a < 2; ++a) {
      const auto truth = world.line(a == 0 ? 1 : 0);
      const Estimate& line = *lines[static_cast<std::size_t>(a)];
      error[2 * a] = line.value[0] - truth[0];
      error[2 * a + 1] = wrap_angle(line.value[1] - truth[1]);
      for (Eigen::Index b = 0; b < 2; ++b)
        covariance.block<2, 2>(2 * a, 2 * b) =
            cross_covariance(line.lineage, lines[static_cast<std::size_t>(b)]->lineage)
                .topLeftCorner<2, 2>();
    }
    walls.add(normalized_squared_error(error, covariance));
    const MovedFeature exact = move_feature(seen.output.elements[0], told, PlaneAxes::robot);
    const Eigen::MatrixXd own = exact.by_feature * seen.output.elements[0].lineage.covariance() *
                                exact.by_feature.transpose();
    without_pose.add(normalized_squared_error(error.head<2>(), own.topLeftCorner<2, 2>()));
  }
  RecordProperty("mean_nees_of_walls", std::to_string(walls.mean() * 4));
  RecordProperty("mean_nees_of_corners", std::to_string(corners.mean() * 2));
  EXPECT_GT(corners.count(), 0.98 * runs);
  EXPECT_GT(walls.count(), 0.98 * runs);
  EXPECT_TRUE(corners.consistent(0.999)) << corners.mean();
  EXPECT_TRUE(walls.consistent(0.999)) << walls.mean();
  EXPECT_GT(without_pose.mean(), 2) << "the pose's error is not needed; the test shows nothing";
}

}  // namespace
}  // namespace ilss
