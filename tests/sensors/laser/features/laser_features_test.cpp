// Features of segmented scans: where they are, what they say of their errors, and from whom.
#include "sensors/laser/features/laser_features.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <iterator>

#include "framework/estimate/consistency.h"
#include "framework/estimate/differentiate.h"
#include "tests/sensors/laser/features/simulated_readings.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

/// A wall from a to b in the laser's frame.
struct TestWall {
  Eigen::Vector2d a, b;
  /// The range at which a ray meets it; infinite where it does not.
  double range(double cosine, double sine) const {
    const Eigen::Vector2d along = b - a;
    const double determinant = along.x() * sine - along.y() * cosine;
    const double range = (along.x() * a.y() - along.y() * a.x()) / determinant;
    const double share = (cosine * a.y() - sine * a.x()) / determinant;
    return range > 0 && share >= 0 && share <= 1 ? range : INFINITY;
  }
};

struct TestScene {
  std::vector<TestWall> walls;
  double operator()(double cosine, double sine) const {
    double nearest = INFINITY;
    for (const TestWall& wall : walls) nearest = std::min(nearest, wall.range(cosine, sine));
    return nearest;
  }
};

/// A segmented scan of a device.
Output scan_of(std::span<const ScanPoint> points, std::span<const ReadingRun> runs,
               const LaserDevice& device) {
  Output scan = output_of<SegmentedScan>(
      {device.range_std, device.bearing_std, device.quantum, 100, 0, 0, 0, 0, 0, 0, 0, 2});
  scan.estimate.frame = "laser";
  const auto rows = make_rows<SegmentedBeam>(scan, points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    rows[i] = {points[i].bearing, points[i].range, 0};
    for (std::size_t k = 0; k < runs.size(); ++k)
      if (i >= runs[k].begin && i < runs[k].end) rows[i].segment = static_cast<double>(k + 1);
  }
  return scan;
}

struct Mount {
  double x = 0, z = 0, heading = 0;
  double x_std = 0, z_std = 0, heading_std = 0;
  /// Lets a scan carry it: its errors are sources 0 to 2 of owner 200.
  void give_to(Estimate& scan) const {
    const std::array value{x, z, heading};
    const std::array deviation{x_std, z_std, heading_std};
    std::ranges::copy(value, scan.value.begin() + first_mount);
    for (std::uint32_t k = 0; k < mount_size; ++k)
      if (deviation[k] > 0)
        scan.lineage.add({200, k, persistent_tick}, first_mount + k, deviation[k]);
  }
};

ModuleRun features_of(Output scan, const Mount& mount = {},
                      const LaserFeatures::Options& options = {}) {
  LaserFeatures module(options);
  mount.give_to(scan.estimate);
  Tick tick;
  tick.inputs = {&scan};
  ModuleRun result;
  result.output.estimate = Estimate(descriptor<RangeFeatures>(), options.frame);
  result.outcome = module.evaluate(tick.evaluation(), result.output);
  return result;
}

template <template <typename> class Payload>
std::vector<const Estimate*> elements_of(const Output& features) {
  std::vector<const Estimate*> list;
  for (const Estimate& element : features.elements)
    if (element.type->name == Payload<double>::name) list.push_back(&element);
  return list;
}

/// Two walls that meet in a corner at random, seen by a hundred beams, split where they meet.
struct RandomCorner {
  Eigen::Vector2d corner;
  Output scan;

  RandomCorner(const LaserDevice& device, std::mt19937_64& draw) {
    std::uniform_real_distribution<double> unit;
    const double range = 1.5 + 4 * unit(draw);
    const double bearing = 2 * std::numbers::pi * unit(draw);
    corner = range * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
    // The walls leave the corner to either side at 25 to 155 degrees to the beam.
    const auto wall = [&](double side) {
      const double turn = bearing + side * (25 + 130 * unit(draw)) * degree;
      return TestWall{corner, corner + 20 * Eigen::Vector2d(std::cos(turn), std::sin(turn))};
    };
    TestScene scene;
    do {
      scene.walls = {wall(-1), wall(1)};
    } while (std::abs((scene.walls[0].b - corner)
                          .normalized()
                          .dot((scene.walls[1].b - corner).normalized())) > std::cos(30 * degree));
    const double step = 0.5 * degree;
    constexpr int half = 20;
    const double phase = unit(draw);  // of the beams to the corner
    const auto points =
        simulate_readings(device, bearing - (half - phase) * step, step, 2 * half, scene, draw);
    const std::array<ReadingRun, 2> runs{{{0, half}, {half, 2 * half}}};
    scan = scan_of(points, runs, device);
  }
};

// Honest corners give 2 on average over 10,000, within 0.05 with a probability of 99 %.
TEST(LaserFeatures, NeesOfCornersIsTwo) {
  std::mt19937_64 draw(20261122);
  const LaserDevice device;
  double sum = 0;
  int found = 0;
  constexpr int runs = 10000;
  for (int i = 0; i < runs; ++i) {
    const RandomCorner random(device, draw);
    const ModuleRun result = features_of(random.scan);
    ASSERT_TRUE(result.outcome);
    const auto corners = elements_of<Corner>(result.output);
    if (corners.size() != 1) continue;
    ++found;
    // The robot's plane has z to the right.
    const std::array<double, 2> truth{random.corner.x(), -random.corner.y()};
    sum += nees(*corners[0], truth).value;
  }
  EXPECT_GT(found, 0.99 * runs);
  EXPECT_GT(sum / found, 1.9);
  EXPECT_LT(sum / found, 2.1);
}

/// A wall seen 40 degrees off at most by 10 to 60 beams, and another far behind its second end.
struct RandomEdge {
  TestWall wall;
  Output scan;
  std::size_t beams = 0;  ///< of the wall
  double first = 0;
  double step = 0.5 * degree;

  RandomEdge(const LaserDevice& device, std::mt19937_64& draw) {
    std::uniform_real_distribution<double> unit;
    const double rho = 1 + 3 * unit(draw);
    const double off = 80 * degree * (unit(draw) - 0.5);
    beams = 10 + static_cast<std::size_t>(50 * unit(draw));
    first = -static_cast<double>(beams) / 2 * step;
    // The wall's normal is `off` the forward axis; its end lies anywhere between two beams.
    const Eigen::Vector2d normal(std::cos(off), std::sin(off));
    const auto at = [&](double bearing) {
      const Eigen::Vector2d beam(std::cos(bearing), std::sin(bearing));
      return Eigen::Vector2d(rho / normal.dot(beam) * beam);
    };
    const double last = first + (static_cast<double>(beams - 1) + unit(draw)) * step;
    wall = {at(first - 3 * degree), at(last)};
    const TestScene scene{{wall, {{20, -20}, {20, 20}}}};
    const auto points =
        simulate_readings(device, first, step, static_cast<int>(beams) + 20, scene, draw);
    while (beams > 0 && points[beams - 1].range > 15) --beams;
    while (points[beams].range < 15) ++beams;
    const std::array<ReadingRun, 2> runs{{{0, beams}, {beams, points.size()}}};
    scan = scan_of(points, runs, device);
  }
  /// Where a beam that looks where it says meets the wall, in the robot's plane.
  Eigen::Vector2d met(std::size_t beam) const {
    const double bearing = first + static_cast<double>(beam) * step;
    const Eigen::Vector2d along = wall.b - wall.a;
    const double c = std::cos(bearing);
    const double s = std::sin(bearing);
    const double range =
        (along.x() * wall.a.y() - along.y() * wall.a.x()) / (along.x() * s - along.y() * c);
    return {range * c, -range * s};
  }
  /// rho and phi in the robot's plane.
  Eigen::Vector2d line() const {
    const Eigen::Vector2d along = (wall.b - wall.a).normalized();
    Eigen::Vector2d normal(along.y(), -along.x());
    if (normal.dot(wall.a) < 0) normal = -normal;
    return {normal.dot(wall.a), std::atan2(-normal.y(), normal.x())};
  }
};

// Of the six, four follow from two parameters; what second order leaves of the rest has longer
// tails than a normal error, so a little less than 95 % are inside.
TEST(LaserFeatures, ALinesSixComponentsAreTogetherAsWrongAsTheySay) {
  std::mt19937_64 draw(20261123);
  const LaserDevice device;
  int inside = 0;
  double ends = 0;
  constexpr int runs = 5000;
  for (int i = 0; i < runs; ++i) {
    const RandomEdge random(device, draw);
    const ModuleRun result = features_of(random.scan);
    const auto lines = elements_of<LineSegment>(result.output);
    ASSERT_GE(lines.size(), 1u);
    const auto line = payload_of<LineSegment>(*lines[0]);
    Eigen::VectorXd truth(6);
    truth << random.line(), random.met(static_cast<std::size_t>(line.first_reading)),
        random.met(static_cast<std::size_t>(line.last_reading));
    Eigen::VectorXd error = lines[0]->vector().head<6>() - truth;
    error[1] = wrap_angle(error[1]);
    const Eigen::MatrixXd covariance = lines[0]->lineage.covariance();
    const NormalizedError all = normalized_squared_error(error, covariance.topLeftCorner<6, 6>());
    inside += all.value < chi_square_quantile(all.rank, 0.95) ? 1 : 0;
    ends += normalized_squared_error(error.segment<2>(2), covariance.block<2, 2>(2, 2)).value;
  }
  EXPECT_GT(inside, 0.92 * runs);
  EXPECT_LT(ends, 2.1 * runs);
}

TEST(LaserFeatures, NeesOfEdgesIsTwo) {
  std::mt19937_64 draw(20261124);
  const LaserDevice device;
  double sum = 0;
  int found = 0;
  constexpr int runs = 10000;
  for (int i = 0; i < runs; ++i) {
    const RandomEdge random(device, draw);
    const ModuleRun result = features_of(random.scan);
    const auto edges = elements_of<SurfaceEdge>(result.output);
    if (edges.size() != 1) continue;  // one in some thousands is no line by chance
    ++found;
    const Eigen::Vector2d error(edges[0]->value[0] - random.wall.b.x(),
                                edges[0]->value[1] + random.wall.b.y());
    sum +=
        normalized_squared_error(error, edges[0]->lineage.covariance().topLeftCorner<2, 2>()).value;
  }
  EXPECT_GT(found, 0.999 * runs);
  EXPECT_GT(sum / found, 1.9);
  EXPECT_LT(sum / found, 2.1);
}

/// Two walls that meet in a corner, and a pillar before the second one: an exact scan.
struct ExactScene {
  LaserDevice device{0.005, 0.1 * degree};
  std::vector<ScanPoint> points;
  std::vector<ReadingRun> runs;

  /// All ranges are off by the sum of bias[k] (r / 2 m)^k.
  explicit ExactScene(std::array<double, 3> bias = {}) {
    const TestWall first{{2, -1.5}, {2.5, 0.2}};
    const TestWall second{{2.5, 0.2}, {0.5, 1.8}};
    int last_seen = -1;
    for (int i = -60; i < 140; ++i) {
      const double bearing = i * 0.5 * degree;
      const double c = std::cos(bearing);
      const double s = std::sin(bearing);
      const std::array<double, 3> ranges{first.range(c, s), second.range(c, s), to_pillar(c, s)};
      const auto nearest = std::min_element(ranges.begin(), ranges.end());
      const int seen = std::isfinite(*nearest) ? static_cast<int>(nearest - ranges.begin()) : -1;
      const double r = seen < 0 ? 0 : *nearest;
      const double range = r == 0 ? 0 : r + bias[0] + bias[1] * r / 2 + bias[2] * r * r / 4;
      if (seen >= 0 && seen != last_seen) runs.push_back({points.size(), points.size()});
      points.push_back({bearing, c, s, range, range * c, range * s});
      if (seen >= 0) runs.back().end = points.size();
      last_seen = seen;
    }
  }
  /// The pillar's near side: centre (0.9, 1.0), radius 0.3.
  static double to_pillar(double c, double s) {
    const double along = 0.9 * c + 1.0 * s;
    const double across = 0.9 * s - 1.0 * c;
    const double square = 0.3 * 0.3 - across * across;
    return square > 0 ? along - std::sqrt(square) : INFINITY;
  }
  Output scan() const { return scan_of(points, runs, device); }
};

TEST(LaserFeatures, AreLinesAnArcTheCornerAndTheEdgeThatAreThere) {
  const ExactScene scene;
  const ModuleRun result = features_of(scene.scan());
  ASSERT_TRUE(result.outcome);
  EXPECT_GE(elements_of<LineSegment>(result.output).size(), 2u);
  const auto corners = elements_of<Corner>(result.output);
  ASSERT_EQ(corners.size(), 1u);
  EXPECT_NEAR(corners[0]->value[0], 2.5, 1e-9);
  EXPECT_NEAR(corners[0]->value[1], -0.2, 1e-9);
  EXPECT_EQ(corners[0]->labels[0], static_cast<int>(CornerKind::real_corner));
  const auto arcs = elements_of<ArcSegment>(result.output);
  ASSERT_EQ(arcs.size(), 1u);
  const auto arc = payload_of<ArcSegment>(*arcs[0]);
  EXPECT_NEAR(arc.centre_x, 0.9, 1e-3);
  EXPECT_NEAR(arc.centre_z, -1.0, 1e-3);
  EXPECT_NEAR(arc.radius, 0.3, 1e-3);
}

/// How all values of all features change, by a central difference.
template <typename Values>
std::vector<double> slope(const Values& values_at, double step) {
  const std::vector<double> above = values_at(step);
  const std::vector<double> below = values_at(-step);
  std::vector<double> result(above.size());
  for (std::size_t i = 0; i < above.size(); ++i) result[i] = (above[i] - below[i]) / (2 * step);
  return result;
}

std::vector<double> values_of(const ModuleRun& result) {
  std::vector<double> values;
  for (const Estimate& element : result.output.elements)
    values.insert(values.end(), element.value.begin(), element.value.end());
  return values;
}

/// The sensitivity of all values of all features to a source of an owner.
std::vector<double> sensitivity(const ModuleRun& result, std::uint32_t owner,
                                std::uint32_t column) {
  std::vector<double> values;
  for (const Estimate& element : result.output.elements) {
    std::vector<double> of_element(element.dimension());
    for (std::size_t k = 0; k < element.lineage.size(); ++k)
      if (const Source& source = element.lineage.sources()[k];
          source.owner == owner && source.column == column)
        of_element.assign(element.lineage.column(k).begin(), element.lineage.column(k).end());
    values.insert(values.end(), of_element.begin(), of_element.end());
  }
  return values;
}

void expect_alike(const std::vector<double>& stated, const std::vector<double>& seen,
                  double tolerance) {
  ASSERT_EQ(stated.size(), seen.size());
  double largest = 0;
  for (const double v : seen) largest = std::max(largest, std::abs(v));
  EXPECT_GT(largest, 0);
  for (std::size_t i = 0; i < stated.size(); ++i)
    EXPECT_NEAR(stated[i], seen[i], tolerance * std::max(1.0, std::abs(seen[i]))) << "value " << i;
}

using Dual3 = Dual<3>;

/// Where a mount puts features that were made for a laser in the robot's origin: places, lines and
/// directions of lines, by their names; everything else stays as it is.
std::vector<Dual3> mounted(const Estimate& feature, const std::array<Dual3, 3>& mount) {
  const auto& [x, z, heading] = mount;
  std::vector<Dual3> moved(feature.value.begin(), feature.value.end());
  const auto move_place = [&](const std::string& prefix) {
    const auto i = feature.type->find(prefix + "x");
    const auto j = feature.type->find(prefix + "z");
    if (!i || !j) return;
    moved[*i] = x + cos(heading) * feature.value[*i] - sin(heading) * feature.value[*j];
    moved[*j] = z + sin(heading) * feature.value[*i] + cos(heading) * feature.value[*j];
  };
  for (const char* prefix : {"", "start_", "end_", "centre_"}) move_place(prefix);
  const auto phi = feature.type->find("phi");
  if (!phi) return moved;
  moved[*phi] += heading;
  const auto rho = feature.type->find("rho");
  if (!rho) return moved;
  moved[*rho] += x * cos(moved[*phi]) + z * sin(moved[*phi]);
  if (moved[*rho] >= 0.0) return moved;
  moved[*rho] = -moved[*rho];
  moved[*phi] += std::numbers::pi;
  return moved;
}

// Also where the robot's origin is on the other side of a line than the laser.
TEST(LaserFeatures, SensitivityToTheMountIsTheDerivativeByAutomaticDifferentiation) {
  const Output scan = ExactScene().scan();
  const ModuleRun plain = features_of(scan);
  ASSERT_TRUE(plain.outcome);
  ASSERT_FALSE(elements_of<LineSegment>(plain.output).empty());
  ASSERT_FALSE(elements_of<ArcSegment>(plain.output).empty());
  ASSERT_FALSE(elements_of<Corner>(plain.output).empty());
  ASSERT_FALSE(elements_of<SurfaceEdge>(plain.output).empty());
  for (const Mount& mount :
       {Mount{0, 0, 0, 1, 1, 1}, Mount{0.2, -0.1, 0.3, 1, 1, 1}, Mount{-5, 4, 2.5, 1, 1, 1}}) {
    SCOPED_TRACE(testing::Message() << mount.x << " " << mount.z << " " << mount.heading);
    const ModuleRun result = features_of(scan, mount);
    ASSERT_EQ(result.output.elements.size(), plain.output.elements.size());
    const std::array dual_mount{Dual3(mount.x, 0), Dual3(mount.z, 1), Dual3(mount.heading, 2)};
    std::vector<Dual3> moved;
    for (const Estimate& element : plain.output.elements)
      std::ranges::copy(mounted(element, dual_mount), std::back_inserter(moved));
    for (std::uint32_t k = 0; k < mount_size; ++k) {
      SCOPED_TRACE(k);
      const std::vector<double> stated = sensitivity(result, 200, k);
      ASSERT_EQ(stated.size(), moved.size());
      for (std::size_t i = 0; i < stated.size(); ++i)
        EXPECT_NEAR(stated[i], moved[i].v[k], 1e-12) << "value " << i;
    }
  }
}

TEST(LaserFeatures, SensitivityToTheRangesBiasesIsTheirDerivative) {
  Output scan = ExactScene().scan();
  for (std::size_t k = 0; k < 3; ++k)
    scan.estimate.lineage.add({300, static_cast<std::uint32_t>(k), persistent_tick}, first_bias + k,
                              1);
  const ModuleRun result = features_of(scan, {0.2, -0.1, 0.3});
  ASSERT_TRUE(result.outcome);
  for (std::uint32_t k = 0; k < 3; ++k) {
    SCOPED_TRACE(k);
    const auto values_at = [&](double change) {
      std::array<double, 3> bias{};
      bias[k] = change;
      return values_of(features_of(ExactScene(bias).scan(), {0.2, -0.1, 0.3}));
    };
    // What the weights change by is second order, as they come from the fit.
    expect_alike(sensitivity(result, 300, k), slope(values_at, 1e-6), 2e-2);
  }
}

TEST(LaserFeatures, ACornerIsCorrelatedWithItsTwoLinesAndTheseAreNotWithEachOther) {
  const ModuleRun result = features_of(ExactScene().scan());
  const auto lines = elements_of<LineSegment>(result.output);
  const auto corners = elements_of<Corner>(result.output);
  ASSERT_GE(lines.size(), 2u);
  ASSERT_EQ(corners.size(), 1u);
  EXPECT_EQ(cross_covariance(lines[0]->lineage, lines[1]->lineage).norm(), 0);
  EXPECT_GT(cross_covariance(corners[0]->lineage, lines[0]->lineage).norm(), 0);
  EXPECT_GT(cross_covariance(corners[0]->lineage, lines[1]->lineage).norm(), 0);
}

TEST(LaserFeatures, AVirtualCornerLiesWhereTwoLinesWouldMeet) {
  // The corner of the two walls is hidden: the readings about it are missing.
  ExactScene scene;
  ASSERT_GE(scene.runs.size(), 2u);
  const std::size_t corner = scene.runs[1].begin;
  for (std::size_t i = corner - 8; i < corner + 8; ++i) scene.points[i].range = 0;
  scene.runs[0].end = corner - 8;
  scene.runs[1].begin = corner + 8;
  LaserFeatures::Options options;
  EXPECT_TRUE(elements_of<Corner>(features_of(scene.scan(), {}, options).output).empty());
  options.virtual_reach = 0.5;
  const ModuleRun result = features_of(scene.scan(), {}, options);
  const auto corners = elements_of<Corner>(result.output);
  ASSERT_EQ(corners.size(), 1u);
  EXPECT_EQ(corners[0]->labels[0], static_cast<int>(CornerKind::virtual_corner));
  EXPECT_NEAR(corners[0]->value[0], 2.5, 1e-9);
  EXPECT_NEAR(corners[0]->value[1], -0.2, 1e-9);
}

TEST(LaserFeatures, AnEdgeIsWhereALineEndsBeforeAFartherSurface) {
  // A wall before another one, seen past its end at (2, 0.5).
  const TestScene walls{{{{2, -1}, {2, 0.5}}, {{4, -3}, {4, 3}}}};
  std::mt19937_64 draw(1);
  const auto points = simulate_readings({0, 0}, -20 * degree, 0.5 * degree, 100, walls, draw);
  std::size_t end = 0;
  while (points[end].x < 3) ++end;
  const std::array<ReadingRun, 2> runs{{{0, end}, {end, 100}}};
  const ModuleRun result = features_of(scan_of(points, runs, LaserDevice{}));
  const auto edges = elements_of<SurfaceEdge>(result.output);
  ASSERT_EQ(edges.size(), 1u) << "not at the scan's first and last beams, nor of the farther wall";
  const auto edge = payload_of<SurfaceEdge>(*edges[0]);
  EXPECT_NEAR(edge.x, 2, 1e-9);
  EXPECT_NEAR(edge.z, -0.5, 0.01);
  EXPECT_NEAR(edge.phi, 0, 1e-9);
  const double step = 2 * 0.5 * degree / std::pow(std::cos(14 * degree), 2);  // along the wall
  EXPECT_NEAR(edges[0]->lineage.standard_deviation(1), step / std::sqrt(12), 0.1 * step);
}

TEST(LaserFeatures, ARoundTripOfTheMountLeavesTheSegmentsWhereTheyAre) {
  const Output scan = ExactScene().scan();
  const ModuleRun plain = features_of(scan);
  const Mount mount{1, -2, 2.5};
  const ModuleRun moved = features_of(scan, mount);
  ASSERT_EQ(plain.output.elements.size(), moved.output.elements.size());
  for (std::size_t i = 0; i < plain.output.elements.size(); ++i) {
    if (plain.output.elements[i].type->name != LineSegment<double>::name) continue;
    const auto a = payload_of<LineSegment>(plain.output.elements[i]);
    const auto b = payload_of<LineSegment>(moved.output.elements[i]);
    const double c = std::cos(mount.heading);
    const double s = std::sin(mount.heading);
    EXPECT_NEAR(b.start_x, mount.x + c * a.start_x - s * a.start_z, 1e-12);
    EXPECT_NEAR(b.start_z, mount.z + s * a.start_x + c * a.start_z, 1e-12);
    EXPECT_GE(b.rho, 0);
    EXPECT_NEAR(b.start_x * std::cos(b.phi) + b.start_z * std::sin(b.phi), b.rho, 1e-9);
    EXPECT_NEAR(b.end_x * std::cos(b.phi) + b.end_z * std::sin(b.phi), b.rho, 1e-9);
  }
}

TEST(LaserFeatures, ReadingsBesideASegmentThatLieOnItAreIts) {
  ExactScene scene;
  scene.runs[0].begin += 5;
  scene.runs[0].end -= 5;
  const ModuleRun result = features_of(scene.scan());
  const auto lines = elements_of<LineSegment>(result.output);
  ASSERT_FALSE(lines.empty());
  const auto line = payload_of<LineSegment>(*lines[0]);
  EXPECT_EQ(line.first_reading, static_cast<double>(scene.runs[0].begin - 5));
  EXPECT_EQ(line.last_reading, static_cast<double>(scene.runs[0].end + 4));
  EXPECT_EQ(line.readings, static_cast<double>(scene.runs[0].size() + 10));
}

TEST(LaserFeatures, WhatIsNeitherLineNorArcIsLeftOut) {
  std::vector<ScanPoint> points;
  for (int i = 0; i < 60; ++i) {
    const double bearing = i * degree;
    const double range = i % 2 == 0 ? 2 : 2.2;
    const double c = std::cos(bearing);
    const double s = std::sin(bearing);
    points.push_back({bearing, c, s, range, range * c, range * s});
  }
  const std::array<ReadingRun, 1> runs{{{0, 60}}};
  EXPECT_EQ(fault_of(features_of(scan_of(points, runs, LaserDevice{})).outcome), "no_detection");
}

TEST(LaserFeatures, NeedTheLasersNoise) {
  const ExactScene scene;
  EXPECT_EQ(fault_of(features_of(scan_of(scene.points, scene.runs, {0, 0})).outcome),
            "no_error_known");
}

TEST(LaserFeatures, OfANumberThatIsNoneAreBadData) {
  ExactScene scene;
  scene.points[3].range = NAN;
  const ModuleRun result = features_of(scene.scan());
  ASSERT_EQ(fault_of(result.outcome), "bad_data");
  EXPECT_NE(result.outcome.fault().message.find("beam 3"), std::string::npos)
      << result.outcome.fault().message;
}

}  // namespace
}  // namespace ilss
