// The simulated laser against geometry, and its noise against what it was told.
#include "sensors/laser/simulate/laser_simulation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;

Wall wall(ScenePoint from, ScenePoint to) { return {.from = from, .to = to, .targets = {}}; }

/// A wall across the way, 2 m ahead, from 5 m to the left to 5 m to the right.
Scene wall_ahead() {
  Scene scene;
  scene.walls = {wall({2, -5}, {2, 5})};
  return scene;
}

TEST(LaserSweep, BeamsGoInEqualStepsFromTheRightToTheLeft) {
  const LaserSweep sweep{.beams = 181, .field_of_view = 180 * degree};
  EXPECT_DOUBLE_EQ(sweep.bearing(0), -90 * degree);
  EXPECT_DOUBLE_EQ(sweep.bearing(90), 0);
  EXPECT_NEAR(sweep.bearing(91), 1 * degree, 1e-12);
  EXPECT_DOUBLE_EQ(sweep.bearing(180), 90 * degree);
}

TEST(LaserSweep, IsByDefault360BeamsHalfADegreeApart) {
  const LaserSweep sweep;
  EXPECT_EQ(sweep.beams, 360u);
  EXPECT_NEAR(sweep.bearing(1) - sweep.bearing(0), 0.5 * degree, 1e-12);
}

TEST(SimulateScan, WithoutErrorsTellsTheDistanceAlongEachBeam) {
  const LaserSweep sweep{.beams = 91, .field_of_view = 90 * degree};
  const ScenePose laser{0.5, 1, 20 * degree};
  const auto scan = simulate_scan(wall_ahead(), laser, sweep, {}, 1);
  for (const LaserBeam& beam : scan)
    EXPECT_NEAR(beam.range, 1.5 / std::cos(laser.heading - beam.bearing), 1e-12);
}

TEST(SimulateScan, SeesWhatIsToTheRightUnderNegativeBearings) {
  Scene scene;
  scene.pillars = {{.centre = {2, 2}, .radius = 0.5}};  // x forward, z to the right
  const auto scan = simulate_scan(scene, {}, {.beams = 181, .field_of_view = 180 * degree}, {}, 1);
  EXPECT_NEAR(scan[45].range, std::sqrt(8.0) - 0.5, 1e-12);  // at -45 degrees
  EXPECT_EQ(scan[135].range, 0);
}

TEST(SimulateScan, PillarHidesTheWallBehindIt) {
  Scene scene = wall_ahead();
  scene.pillars = {{.centre = {1, 0}, .radius = 0.25}};
  const auto scan = simulate_scan(scene, {}, {.beams = 181, .field_of_view = 180 * degree}, {}, 1);
  EXPECT_NEAR(scan[90].range, 0.75, 1e-12);
  const double half_width = std::asin(0.25);  // 14.5 degrees
  EXPECT_LT(scan[90 + 14].range, 1);
  EXPECT_NEAR(scan[90 + 15].range, 2 / std::cos(15 * degree), 1e-12);
  EXPECT_LT(half_width, 15 * degree);
}

TEST(SimulateScan, HasNoReturnBeyondItsRange) {
  const LaserSweep sweep{.beams = 3, .field_of_view = 120 * degree, .max_range = 3};
  const auto scan = simulate_scan(wall_ahead(), {}, sweep, {}, 1);
  EXPECT_EQ(scan[0].range, 0);  // 4 m away
  EXPECT_EQ(scan[1].range, 2);
  EXPECT_EQ(scan[2].range, 0);
}

TEST(SimulateScan, RangesHaveTheNoiseThatTheyWereGiven) {
  constexpr std::uint64_t seed = 7;
  SCOPED_TRACE(seed);
  // A circle around the laser as its own scene: every beam meets a wall at about 2 m.
  const LaserSweep sweep{.beams = 20'001, .field_of_view = 1e-3};
  const LaserErrors errors{.range_std = 0.02};
  const auto scan = simulate_scan(wall_ahead(), {}, sweep, errors, seed);
  double sum = 0;
  double squares = 0;
  for (const LaserBeam& beam : scan) {
    const double error = beam.range - 2 / std::cos(beam.bearing);
    sum += error;
    squares += error * error;
  }
  const auto n = static_cast<double>(scan.size());
  EXPECT_NEAR(sum / n, 0, 4 * 0.02 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), 0.02, 4 * 0.02 / std::sqrt(2 * n));
}

TEST(SimulateScan, BearingNoiseShowsWhereTheRangeDependsOnTheBearing) {
  constexpr std::uint64_t seed = 8;
  SCOPED_TRACE(seed);
  // Seen at 60 degrees off its normal, the range 2 / cos changes by r tan(60 degrees) a radian.
  const LaserSweep sweep{.beams = 20'001, .field_of_view = 1e-3};
  const LaserErrors errors{.bearing_std = 0.1 * degree};
  const ScenePose laser{0, 0, 60 * degree};
  const auto scan = simulate_scan(wall_ahead(), laser, sweep, errors, seed);
  double squares = 0;
  for (const LaserBeam& beam : scan) {
    const double range = 2 / std::cos(laser.heading - beam.bearing);
    squares += std::pow((beam.range - range) / (range * std::tan(laser.heading - beam.bearing)), 2);
  }
  const auto n = static_cast<double>(scan.size());
  const double expected = 0.1 * degree;
  EXPECT_NEAR(std::sqrt(squares / n), expected, 5 * expected / std::sqrt(2 * n) + 0.01 * expected);
}

TEST(SimulateScan, TellsRangesInWholeQuanta) {
  const LaserErrors errors{.range_std = 0.02, .quantum = 0.01};
  for (const LaserBeam& beam : simulate_scan(wall_ahead(), {}, {}, errors, 3)) {
    const double steps = beam.range / 0.01;
    EXPECT_NEAR(steps, std::round(steps), 1e-9);
  }
}

TEST(SimulateScan, ErrorsOfOneSeedDifferInSizeOnly) {
  const LaserSweep sweep{.beams = 11, .field_of_view = 60 * degree};
  const auto exact = simulate_scan(wall_ahead(), {}, sweep, {}, 9);
  const auto small = simulate_scan(wall_ahead(), {}, sweep, {.range_std = 0.001}, 9);
  const auto large = simulate_scan(wall_ahead(), {}, sweep, {.range_std = 0.003}, 9);
  for (std::size_t i = 0; i < exact.size(); ++i)
    EXPECT_NEAR(large[i].range - exact[i].range, 3 * (small[i].range - exact[i].range), 1e-12);
}

TEST(SimulateScan, BeamThatStraddlesAnEdgeGivesAMixtureOfBothSurfaces) {
  Scene scene;
  scene.walls = {wall({1, 0}, {1, 3}), wall({3, -9}, {3, 9})};  // the nearer one to the right
  const LaserSweep thin{.beams = 3, .field_of_view = 20 * degree};
  const LaserSweep wide{.beams = 3, .field_of_view = 20 * degree, .beam_width = 1 * degree};
  const auto sharp = simulate_scan(scene, {0, 1e-6, 0}, thin, {}, 1);
  const auto mixed = simulate_scan(scene, {0, 1e-6, 0}, wide, {}, 1);
  EXPECT_NEAR(sharp[1].range, 1, 1e-9);
  EXPECT_GT(mixed[1].range, 1.5);
  EXPECT_LT(mixed[1].range, 2.5);
  EXPECT_EQ(mixed[0].range, sharp[0].range);
  EXPECT_EQ(mixed[2].range, sharp[2].range);
}

TEST(SimulateScan, RobotThatDrivesAtTheWallSeesItNearerFromBeamToBeam) {
  const LaserSweep sweep{.beams = 11, .field_of_view = 1e-9, .speed = 1, .duration = 0.1};
  const auto scan = simulate_scan(wall_ahead(), {}, sweep, {}, 1);
  for (std::size_t i = 0; i < scan.size(); ++i)
    EXPECT_NEAR(scan[i].range, 2.1 - 0.01 * static_cast<double>(i), 1e-9);
}

TEST(SimulateScan, RobotThatTurnsLooksElsewhereFromBeamToBeam) {
  const LaserSweep sweep{
      .beams = 11, .field_of_view = 1e-9, .turn_rate = 30 * degree, .duration = 1};
  const auto scan = simulate_scan(wall_ahead(), {}, sweep, {}, 1);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double heading = -30 * degree * (1 - 0.1 * static_cast<double>(i));
    EXPECT_NEAR(scan[i].range, 2 / std::cos(heading), 1e-9);
  }
}

TEST(SimulateScan, SaysWhichSurfaceEachBeamMet) {
  Scene scene = wall_ahead();
  scene.pillars = {{.centre = {1, 0}, .radius = 0.25}};
  const LaserSweep sweep{.beams = 3, .field_of_view = 170 * degree, .max_range = 10};
  std::vector<LaserBeam> scan(3);
  std::vector<std::size_t> surfaces(3);
  simulate_scan(RayCaster(scene), sweep, {}, {}, 1, scan, surfaces);
  EXPECT_EQ(surfaces, (std::vector<std::size_t>{no_surface, 1, no_surface}));
}

}  // namespace
}  // namespace ilss
