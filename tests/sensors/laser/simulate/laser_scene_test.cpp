// laser_scene and its truth: one world, tick by tick.
#include "sensors/laser/simulate/laser_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sensors/laser/simulate/laser_scene_features.h"
#include "sensors/laser/simulate/laser_scene_segments.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;

Wall wall(ScenePoint from, ScenePoint to) { return {.from = from, .to = to, .targets = {}}; }

/// The parameters' defaults, with a robot at a pose.
Tick tick_at(const ScenePose& robot, std::int64_t number = 0, std::uint64_t seed = 1) {
  Tick tick;
  tick.parameters = Estimate(descriptor<LaserWorldParameters>());
  tick.parameters.value = {0.005, 0.1 * degree, robot.x, robot.z, robot.heading, 0, 0, 0};
  tick.tick = number;
  tick.seed = seed;
  return tick;
}

LaserWorldOptions scene_options(Scene scene) {
  LaserWorldOptions options;
  options.scene.emplace(FileOf<Scene>{{}, std::move(scene)});
  return options;
}

/// A room's far wall and right wall, 4 m ahead and 3 m to the right, and a box's face 2 m ahead
/// to the left, which ends before the far wall.
Scene corner_and_box() {
  Scene scene;
  scene.walls = {wall({4, -12}, {4, 3}), wall({4, 3}, {-4, 3}), wall({2, -3}, {2, -1})};
  return scene;
}

std::vector<const Estimate*> elements_of(const Output& output, std::string_view type) {
  std::vector<const Estimate*> elements;
  for (const Estimate& element : output.elements)
    if (element.type->name == type) elements.push_back(&element);
  return elements;
}

template <typename M>
Output output_of_module(M& module, const Tick& tick) {
  ModuleRun result;
  result.output.estimate = Estimate(*M::interface({}).output, M::interface({}).frame);
  result.outcome = module.evaluate(tick.evaluation(), result.output);
  EXPECT_EQ(fault_of(result.outcome), "output");
  return std::move(result.output);
}

TEST(LaserScene, SaysWhatItsErrorsAre) {
  LaserWorldOptions world = scene_options(corner_and_box());
  world.quantum = 0.01;
  world.max_range = 20;
  LaserScene laser({.world = world});
  const Output scan = output_of_module(laser, tick_at({}));
  EXPECT_EQ(scan.estimate.value[0], 0.005);
  EXPECT_EQ(scan.estimate.value[1], 0.1 * degree);
  EXPECT_EQ(scan.estimate.value[2], 0.01);
  EXPECT_EQ(scan.estimate.value[3], 20);
  EXPECT_EQ(beams_of(scan).size(), 360u);
}

TEST(LaserScene, ScansCarryTheMountThatTheySeeTheSceneFrom) {
  Tick tick = tick_at({});
  tick.parameters.value = {0, 0, 0, 0, 0, 1, -0.5, 10 * degree};
  tick.parameters.lineage.add({7, 0, persistent_tick}, 0, 0.001);  // of range_std: none of a scan's
  tick.parameters.lineage.add({8, 0, persistent_tick}, 7, 0.02);
  LaserScene laser({.world = scene_options(corner_and_box())});
  LaserSceneSegments segments({.world = scene_options(corner_and_box())});
  for (const Output& scan : {output_of_module(laser, tick), output_of_module(segments, tick)}) {
    SCOPED_TRACE(scan.estimate.type->name);
    EXPECT_EQ(scan.estimate.value[first_mount], 1);
    EXPECT_EQ(scan.estimate.value[first_mount + 1], -0.5);
    EXPECT_EQ(scan.estimate.value[first_mount + 2], 10 * degree);
    ASSERT_EQ(scan.estimate.lineage.size(), 1U);
    EXPECT_EQ(scan.estimate.lineage.standard_deviation(first_mount + 2), 0.02);
  }
  const Output scan = output_of_module(laser, tick);
  const LaserBeam& beam = beams_of(scan)[190];
  EXPECT_NEAR(beam.range, 3 / std::cos(10 * degree - beam.bearing), 1e-12) << "1 m nearer, turned";
}

TEST(LaserScene, ExpectsTheScanWithoutNoise) {
  LaserScene laser({.world = scene_options(corner_and_box())});
  Output output;
  ASSERT_TRUE(laser.expect(tick_at({}).evaluation(), nullptr, output));
  const LaserBeam& beam = beams_of(output)[190];
  EXPECT_NEAR(beam.range, 4 / std::cos(beam.bearing), 1e-12);
}

TEST(LaserScene, RefusesANegativeDeviation) {
  LaserScene laser({.world = scene_options(corner_and_box())});
  Tick tick = tick_at({});
  tick.parameters.value[0] = -0.001;
  EXPECT_EQ(fault_of(run(laser, tick).outcome), "out_of_range");
}

TEST(LaserScene, StaysInARoomForItsScansAndThenGoesOn) {
  LaserWorld world({});
  const auto first_wall = [&](std::int64_t number) {
    const Outcome<LaserStand> stand =
        world.enter(tick_at({}, number, 100 + static_cast<std::uint64_t>(number)).evaluation());
    EXPECT_TRUE(stand.has_output());
    return world.scene().walls[0].from.x;
  };
  const double first = first_wall(0);
  for (int i = 1; i < 5; ++i) EXPECT_EQ(first_wall(i), first);
  EXPECT_NE(first_wall(5), first);
}

template <typename M>
void expect_no_order_of_ticks(const typename M::Options& options) {
  const auto at = [](std::int64_t number) {
    return tick_at({0.1, -0.2, 0.3}, number, derive_seed(1, static_cast<std::uint64_t>(number)));
  };
  M in_order(options);
  std::vector<Output> ticks;
  for (std::int64_t number = 0; number < 13; ++number)
    ticks.push_back(output_of_module(in_order, at(number)));
  M other(options);
  for (const std::int64_t number : {7, 3, 12, 7, 0}) {
    const Output output = output_of_module(other, at(number));
    const Output& expected = ticks[static_cast<std::size_t>(number)];
    EXPECT_EQ(output.samples.bytes, expected.samples.bytes) << "tick " << number;
    EXPECT_EQ(output.estimate.value, expected.estimate.value) << "tick " << number;
    ASSERT_EQ(output.elements.size(), expected.elements.size()) << "tick " << number;
    for (std::size_t e = 0; e < output.elements.size(); ++e)
      EXPECT_EQ(output.elements[e].value, expected.elements[e].value);
  }
}

TEST(LaserScene, DoesNotDependOnWhichTickIsAskedFirst) {
  expect_no_order_of_ticks<LaserScene>({});
  expect_no_order_of_ticks<LaserSceneFeatures>({});
  expect_no_order_of_ticks<LaserSceneSegments>({});
  LaserScene::Options moving{.world = scene_options(corner_and_box())};
  moving.world.speed = 0.3;
  moving.world.turn_rate = 0.2;
  moving.world.sweep_time = 0.05;
  expect_no_order_of_ticks<LaserScene>(moving);
}

TEST(LaserScene, GivesTheSameScansAgainAfterAReset) {
  LaserScene laser({});
  const Output before = output_of_module(laser, tick_at({}, 0, 11));
  output_of_module(laser, tick_at({}, 1, 12));
  laser.reset();
  const Output after = output_of_module(laser, tick_at({}, 0, 11));
  EXPECT_EQ(before.samples.bytes, after.samples.bytes);
}

TEST(LaserSceneFeatures, AreTheSceneSeenFromTheRobot) {
  LaserSceneFeatures truth({.world = scene_options(corner_and_box())});
  const Output output = output_of_module(truth, tick_at({}));
  const auto lines = elements_of(output, "line_segment");
  ASSERT_EQ(lines.size(), 4u);  // the far wall shows on both sides of the box
  EXPECT_EQ(output.estimate.value[0], 4);
  const auto right = payload_of<LineSegment>(*lines[0]);
  EXPECT_NEAR(right.rho, 3, 1e-12);
  EXPECT_NEAR(right.phi, 90 * degree, 1e-12);
  EXPECT_NEAR(right.start_z, 3, 1e-12);
  const auto ahead = payload_of<LineSegment>(*lines[1]);
  EXPECT_NEAR(ahead.rho, 4, 1e-12);
  EXPECT_NEAR(ahead.phi, 0, 1e-12);
}

TEST(LaserSceneFeatures, SayWhichReadingsTheyWereMadeOf) {
  LaserSceneFeatures truth({.world = scene_options(corner_and_box())});
  const Output output = output_of_module(truth, tick_at({}));
  const auto right = payload_of<LineSegment>(*elements_of(output, "line_segment").at(0));
  const auto ahead = payload_of<LineSegment>(*elements_of(output, "line_segment").at(1));
  EXPECT_EQ(right.first_reading, 0);
  EXPECT_EQ(ahead.first_reading, right.last_reading + 1);
  EXPECT_EQ(ahead.readings, ahead.last_reading - ahead.first_reading + 1);
  const double first_bearing = LaserSweep{}.bearing(static_cast<std::size_t>(ahead.first_reading));
  EXPECT_NEAR(ahead.start_z, -4 * std::tan(first_bearing), 1e-12);
}

TEST(LaserSceneFeatures, AreExactInTheRobotsFrame) {
  LaserSceneFeatures truth({.world = scene_options(corner_and_box())});
  const Output output = output_of_module(truth, tick_at({}));
  ASSERT_FALSE(output.elements.empty());
  for (const Estimate& element : output.elements) {
    EXPECT_TRUE(element.lineage.empty());
    EXPECT_EQ(element.frame, "robot");
  }
}

TEST(LaserSceneFeatures, HaveACornerWhereWallsMeetAndEdgesWhereTheNearerOneEnds) {
  LaserSceneFeatures truth({.world = scene_options(corner_and_box())});
  const Output output = output_of_module(truth, tick_at({}));
  const auto corners = elements_of(output, "corner");
  ASSERT_EQ(corners.size(), 1u);
  EXPECT_NEAR(corners[0]->value[0], 4, 1e-12);
  EXPECT_NEAR(corners[0]->value[1], 3, 1e-12);
  EXPECT_EQ(corners[0]->labels[0], static_cast<int>(CornerKind::real_corner));
  const auto edges = elements_of(output, "edge");
  ASSERT_EQ(edges.size(), 2u);
  EXPECT_NEAR(edges[0]->value[0], 2, 1e-12);
  EXPECT_NEAR(edges[0]->value[1], -1, 1e-12);
  EXPECT_NEAR(edges[0]->value[2], 0, 1e-12);
  EXPECT_NEAR(edges[1]->value[1], -3, 1e-12);
}

TEST(LaserSceneFeatures, ArcOfAPillarBulgesTowardsTheSensor) {
  Scene scene;
  scene.pillars = {{.centre = {3, 1}, .radius = 0.8}};
  LaserSceneFeatures truth({.world = scene_options(scene)});
  const ScenePose robot{1, 0, 30 * degree};
  const Output output = output_of_module(truth, tick_at(robot));
  const auto arcs = elements_of(output, "arc_segment");
  ASSERT_EQ(arcs.size(), 1u);
  const auto arc = payload_of<ArcSegment>(*arcs[0]);
  const ScenePoint centre = to_frame(robot, {3, 1});
  EXPECT_NEAR(arc.centre_x, centre.x, 1e-12);
  EXPECT_NEAR(arc.centre_z, centre.z, 1e-12);
  EXPECT_EQ(arc.radius, 0.8);
  EXPECT_NEAR(std::hypot(arc.start_x - centre.x, arc.start_z - centre.z), 0.8, 1e-12);
  EXPECT_GT(arc.start_z, arc.end_z) << "from the right to the left";
}

TEST(LaserSceneFeatures, WhatIsTooSmallToCountIsAskedForApart) {
  Scene scene = corner_and_box();
  scene.walls[2].to.z = -2.6;  // 0.4 m
  LaserSceneFeatures counted({.world = scene_options(scene)});
  LaserSceneFeatures small({.world = scene_options(scene), .pieces = CountedPieces::small});
  const Tick tick = tick_at({});
  EXPECT_EQ(elements_of(output_of_module(counted, tick), "edge").size(), 0u);
  EXPECT_EQ(elements_of(output_of_module(counted, tick), "line_segment").size(), 3u);
  const Output pieces = output_of_module(small, tick);
  EXPECT_EQ(elements_of(pieces, "edge").size(), 2u);
  const auto lines = elements_of(pieces, "line_segment");
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NEAR(payload_of<LineSegment>(*lines[0]).rho, 2, 1e-12);
}

TEST(LaserSceneFeatures, EndOfACountedLineAtAHardlyVisibleWallIsCornerAndEdgeApart) {
  Scene scene;
  // A box's front, 2 m ahead, and its side, of which a sliver shows; behind it a far wall.
  scene.walls = {wall({2, -1}, {2, 1}), wall({2, 1}, {2.1, 1.02}), wall({5, -9}, {5, 9})};
  LaserSceneFeatures counted({.world = scene_options(scene)});
  LaserSceneFeatures small({.world = scene_options(scene), .pieces = CountedPieces::small});
  const Tick tick = tick_at({0, 2, 0});
  EXPECT_EQ(elements_of(output_of_module(counted, tick), "corner").size(), 0u);
  const Output apart = output_of_module(small, tick);
  ASSERT_EQ(elements_of(apart, "corner").size(), 1u);
  EXPECT_NEAR(elements_of(apart, "corner")[0]->value[0], 2, 1e-12);
  EXPECT_NEAR(elements_of(apart, "corner")[0]->value[1], -1, 1e-12);
  const auto edges = elements_of(apart, "edge");
  ASSERT_EQ(edges.size(), 2u);  // of the sliver, and of the front
  EXPECT_TRUE(std::any_of(edges.begin(), edges.end(), [](const Estimate* edge) {
    return std::hypot(edge->value[0] - 2, edge->value[1] + 1) < 1e-12;
  }));
}

TEST(LaserSceneFeatures, OfADrivingRobotAreThoseFromWhereTheSweepEnds) {
  LaserWorldOptions world = scene_options(corner_and_box());
  world.speed = 1;
  world.sweep_time = 0.1;
  Tick tick = tick_at({-1, 0, 0}, 10);  // at 1 s
  tick.parameters.value[0] = tick.parameters.value[1] = 0;
  LaserSceneFeatures truth({.world = world});
  const Output features = output_of_module(truth, tick);
  EXPECT_NEAR(payload_of<LineSegment>(*elements_of(features, "line_segment").at(1)).rho, 4, 1e-12);
  LaserScene laser({.world = world});
  const Output scan = output_of_module(laser, tick);
  EXPECT_EQ(scan.acquired.oldest, time_at(0.9));
  const LaserBeam& middle = beams_of(scan)[185];
  const double moved = 0.1 * (1 - 185.0 / 359);
  EXPECT_NEAR(middle.range, (4 + moved) / std::cos(middle.bearing), 1e-9);
}

TEST(LaserSceneFeatures, AreThoseOfTheScanOfTheSameSeedThroughAllTicks) {
  LaserSceneFeatures truth({});
  LaserScene laser({});
  for (std::int64_t number = 0; number < 20; ++number) {
    SCOPED_TRACE(number);
    Tick tick = tick_at({}, number, 1000 + static_cast<std::uint64_t>(number));
    const Output features = output_of_module(truth, tick);
    tick.parameters.value[0] = tick.parameters.value[1] = 0;  // a scan without noise
    const Output scan = output_of_module(laser, tick);
    const auto beams = beams_of(scan);
    for (const Estimate* element : elements_of(features, "line_segment")) {
      const auto line = payload_of<LineSegment>(*element);
      const auto last = static_cast<std::size_t>(line.last_reading);
      for (auto i = static_cast<std::size_t>(line.first_reading); i <= last; ++i) {
        const double x = beams[i].range * std::cos(beams[i].bearing);
        const double z = -beams[i].range * std::sin(beams[i].bearing);
        EXPECT_NEAR(x * std::cos(line.phi) + z * std::sin(line.phi), line.rho, 1e-9);
      }
    }
    for (const Estimate* element : elements_of(features, "arc_segment")) {
      const auto arc = payload_of<ArcSegment>(*element);
      const auto last = static_cast<std::size_t>(arc.last_reading);
      for (auto i = static_cast<std::size_t>(arc.first_reading); i <= last; ++i) {
        const double x = beams[i].range * std::cos(beams[i].bearing);
        const double z = -beams[i].range * std::sin(beams[i].bearing);
        EXPECT_NEAR(std::hypot(x - arc.centre_x, z - arc.centre_z), arc.radius, 1e-9);
      }
    }
  }
}

TEST(LaserSceneSegments, AreTheScanOfTheSameSeedWithItsCountedPieces) {
  LaserSceneSegments segments({});
  LaserSceneFeatures truth({});
  LaserScene laser({});
  const Tick tick = tick_at({}, 0, 21);
  const Output segmented = output_of_module(segments, tick);
  const Output scan = output_of_module(laser, tick);
  const Output features = output_of_module(truth, tick);
  const auto beams = segmented_beams_of(segmented);
  ASSERT_EQ(beams.size(), beams_of(scan).size());
  double last = 0;
  for (std::size_t i = 0; i < beams.size(); ++i) {
    EXPECT_EQ(beams[i].range, beams_of(scan)[i].range);
    last = std::max(last, beams[i].segment);
  }
  EXPECT_EQ(last, features.estimate.value[0]);
  EXPECT_EQ(segmented.estimate.value, scan.estimate.value);
}

}  // namespace
}  // namespace ilss
