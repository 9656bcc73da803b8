// The line extractor on simulated scans: what it finds and whether its errors are true.
#include "sensors/range/line_extractor.h"

#include <gtest/gtest.h>

#include "tests/sensors/features/feature_run.h"
#include "tests/sensors/range/scans.h"

namespace ilss {
namespace {

constexpr int scans = 2000;

struct Situation {
  std::string name;
  Scene scene;
  double head_rate = 0;
  bool bandwidth = false;
  double mount_heading = 0;
};

LepRig rig_of(const Situation& situation) {
  LepRig rig(situation.scene);
  rig.head_rate = situation.head_rate;
  if (situation.bandwidth) rig.options.bandwidth = 1000;
  rig.sensor_parameters.value[6] = rig.ranging_parameters.value[6] = situation.mount_heading;
  return rig;
}

/// The readings left and right of an edge's apex, which every scan knows in truth.
std::vector<ReadingRun> true_runs(std::span<const RangeReading> readings, double apex) {
  std::size_t at = 0;
  while (at < readings.size() &&
         std::atan2(apex - readings[at].origin_z, -readings[at].origin_x) < readings[at].bearing)
    ++at;
  return {{0, at}, {at, readings.size()}};
}

/// What 2,000 scans of two walls came to.
struct EdgeTally {
  int exact = 0;
  ConsistencyStatistic lines, starts, ends, corners;
  double square[2] = {};
  double batch_square[2] = {};
  int corner_count = 0;

  void run(const Situation& situation, std::uint64_t seed) {
    const LepRig rig = rig_of(situation);
    const std::vector<Wall>& walls = situation.scene.walls;
    const double apex = walls[0].from.x;
    LineExtractor extractor({});
    for (int k = 0; k < scans; ++k) {
      const Output scan = rig.scan(derive_seed(seed, static_cast<std::uint64_t>(k)));
      const ModuleRun result = extract(extractor, scan);
      if (!result.outcome) continue;
      const auto segments = segments_of(result.output);
      if (segments.size() != 2 || segments[0]->type->name != LineSegment<double>::name ||
          segments[1]->type->name != LineSegment<double>::name)
        continue;
      ++exact;
      const auto readings = readings_of(scan);
      const auto runs = true_runs(readings, apex);
      for (std::size_t i = 0; i < 2; ++i) {
        const InverseLine truth = line_of({}, walls[i]);
        judge(*segments[i], truth, readings);
        compare(*segments[i], truth, readings, runs[i],
                payload_of<RangeScan>(scan.estimate).noise_correlation);
      }
      for (const Estimate* edge : elements_of<Corner>(result.output)) {
        ++corner_count;
        corners.add(error_of(*edge, 0, {0, apex}));
      }
    }
  }

  void judge(const Estimate& segment, const InverseLine& truth,
             std::span<const RangeReading> readings) {
    lines.add(error_of(segment, 0, rho_phi(truth)));
    const RangeReading& first = reading_at(readings, segment.value[2], segment.value[3]);
    const RangeReading& last = reading_at(readings, segment.value[4], segment.value[5]);
    starts.add(error_of(segment, 2, point_on(first, truth)));
    ends.add(error_of(segment, 4, point_on(last, truth)));
  }

  void compare(const Estimate& segment, const InverseLine& truth,
               std::span<const RangeReading> readings, const ReadingRun& run,
               double noise_correlation) {
    const auto batch = fit_line(readings, std::span(&run, 1), truth, noise_correlation);
    ASSERT_TRUE(batch);
    const auto expected = rho_phi(truth);
    const auto fitted = rho_phi(batch->line);
    for (std::size_t i = 0; i < 2; ++i) {
      square[i] += std::pow(wrap_angle(segment.value[i] - expected[i]), 2);
      batch_square[i] += std::pow(wrap_angle(fitted[i] - expected[i]), 2);
    }
  }
};

class Edge : public ::testing::TestWithParam<Situation> {};

// The "must show": two segments in 99.5 % of scans, NEES per dimension within 0.9 to 1.1,
// and variances at most 1.10 times those of the fit that knows where the edge is.
TEST_P(Edge, IsTwoSegmentsWithTrueErrors) {
  const std::uint64_t seed = 121;
  SCOPED_TRACE(::testing::Message() << GetParam().name << ", seed " << seed);
  EdgeTally tally;
  tally.run(GetParam(), seed);
  EXPECT_GE(tally.exact, 0.995 * scans);
  EXPECT_NEAR(tally.lines.mean(), 1, 0.1);
  EXPECT_NEAR(tally.starts.mean(), 1, 0.1);
  EXPECT_NEAR(tally.ends.mean(), 1, 0.1);
  EXPECT_NEAR(tally.corners.mean(), 1, 0.1);
  EXPECT_LT(std::max(tally.starts.unexplained(), tally.ends.unexplained()), 1e-3)
      << "an end lies on its ray";
  EXPECT_GE(tally.corner_count, 0.99 * scans);
  for (int i = 0; i < 2; ++i)
    EXPECT_LE(tally.square[i], 1.1 * tally.batch_square[i]) << (i == 0 ? "rho" : "phi");
}

INSTANTIATE_TEST_SUITE_P(
    Of, Edge,
    ::testing::Values(
        Situation{"Convex07", edge_scene(0.7, 120 * degree)},
        Situation{"Convex07Turning", edge_scene(0.7, 120 * degree), 90 * degree},
        Situation{"Convex07Backwards", edge_scene(0.7, 120 * degree), -90 * degree},
        Situation{"Convex07Bandwidth", edge_scene(0.7, 120 * degree), 0, true},
        Situation{"Convex12", edge_scene(1.2, 120 * degree)},
        Situation{"Convex12Turning", edge_scene(1.2, 120 * degree), 90 * degree},
        Situation{"Convex12Bandwidth", edge_scene(1.2, 120 * degree), 0, true},
        Situation{"Convex12Mounted", edge_scene(1.2, 120 * degree), 0, false, 4 * degree},
        Situation{"Concave15", edge_scene(1.5, 90 * degree, false)},
        Situation{"Concave15Turning", edge_scene(1.5, 90 * degree, false), 90 * degree}),
    [](const auto& of) { return of.param.name; });

/// Scans of surfaces that jump: segments are judged against what they are of, from left to right.
struct JumpTally {
  int scans_taken = 0;
  int exact = 0;
  ConsistencyStatistic lines, arcs, jumps;
  int jump_count = 0;
  int jumps_in_ellipse = 0;

  /// A wall's line, or a circle (x, z, radius) of the LEP's frame.
  struct Truth {
    InverseLine line = {};
    std::vector<double> circle = {};
  };

  void run(const LepRig& rig, const std::vector<Truth>& truths,
           const std::vector<std::vector<double>>& places, std::uint64_t seed, int count) {
    LineExtractor extractor({});
    for (int k = 0; k < count; ++k) {
      ++scans_taken;
      const Output scan = rig.scan(derive_seed(seed, static_cast<std::uint64_t>(k)));
      const ModuleRun result = extract(extractor, scan);
      if (!result.outcome) continue;
      const auto segments = segments_of(result.output);
      bool right = segments.size() == truths.size();
      for (std::size_t i = 0; right && i < segments.size(); ++i)
        right = (segments[i]->type->name == ArcSegment<double>::name) == !truths[i].circle.empty();
      if (!right) continue;
      ++exact;
      for (std::size_t i = 0; i < segments.size(); ++i)
        if (truths[i].circle.empty())
          lines.add(error_of(*segments[i], 0, rho_phi(truths[i].line)));
        else
          arcs.add(error_of(*segments[i], 0, truths[i].circle));
      judge_jumps(result.output, places);
    }
  }

  void judge_jumps(const Output& features, const std::vector<std::vector<double>>& places) {
    for (const Estimate* edge : elements_of<SurfaceEdge>(features)) {
      const std::vector<double>* nearest = nullptr;
      double distance = INFINITY;
      for (const auto& place : places) {
        const double d = std::hypot(edge->value[0] - place[0], edge->value[1] - place[1]);
        if (d < distance) nearest = &place;
        distance = std::min(d, distance);
      }
      if (nearest == nullptr) continue;
      ++jump_count;
      const NormalizedError error = error_of(*edge, 0, *nearest);
      jumps.add(error);
      jumps_in_ellipse += error.value < chi_square_quantile(2, 0.95) ? 1 : 0;
    }
  }

  /// Found in this share of the scans and as wrong as stated. A jump is uniform within an interval,
  /// so that its squared error is less than a normal one's.
  void expect_honest(double share) const {
    EXPECT_GE(exact, share * scans_taken);
    if (lines.count() > 0) {
      EXPECT_NEAR(lines.mean(), 1, 0.1);
    }
    if (arcs.count() > 0) {
      EXPECT_NEAR(arcs.mean(), 1, 0.1);
    }
    if (jump_count > 0) {
      EXPECT_GE(jump_count, 0.9 * scans_taken);
      EXPECT_LE(jumps.mean(), 1.15);
      EXPECT_GE(jumps_in_ellipse, 0.93 * jump_count);
    }
  }
};

TEST(LineExtractor, FindsAStepOfFiveCentimetresAndWhereItIs) {
  const std::uint64_t seed = 131;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  JumpTally tally;
  // The step lies anywhere between two rays.
  for (int place = 0; place < 10; ++place) {
    const double at = 0.1 + 0.0003 * place;
    Scene scene;
    scene.walls = {{{1, -3}, {1, at}, 0.8, {}},
                   {{1, at}, {1.05, at}, 0.8, {}},
                   {{1.05, at}, {1.05, 3}, 0.8, {}}};
    tally.run(LepRig(scene), {{line_of({}, scene.walls[0])}, {line_of({}, scene.walls[2])}},
              {{at, 1}}, seed + static_cast<std::uint64_t>(place), 200);
  }
  tally.expect_honest(0.995);
}

TEST(LineExtractor, FindsAPillarBeforeAWall) {
  const std::uint64_t seed = 151;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  Scene scene;
  scene.walls = {{{1.6, -3}, {1.6, 3}, 0.8, {}}};
  scene.pillars = {{{1, 0}, 0.1, 0.8}};
  const InverseLine wall = line_of({}, scene.walls[0]);
  JumpTally tally;
  tally.run(LepRig(scene), {{wall}, {{}, {0, 1, 0.1}}, {wall}}, {}, seed, 1000);
  tally.expect_honest(0.995);
}

TEST(LineExtractor, FindsADoorwayAndItsTwoSides) {
  const std::uint64_t seed = 161;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  for (const bool behind : {true, false}) {
    JumpTally tally;
    for (int place = 0; place < 10; ++place) {
      const double half = 0.2 + 0.0004 * place;
      Scene scene;
      scene.walls = {{{1.2, -3}, {1.2, -half}, 0.8, {}}, {{1.2, half}, {1.2, 3}, 0.8, {}}};
      if (behind) scene.walls.push_back({{2, -3}, {2, 3}, 0.8, {}});
      const InverseLine front = line_of({}, scene.walls[0]);
      std::vector<JumpTally::Truth> truths{{front}, {front}};
      if (behind) truths.insert(truths.begin() + 1, {line_of({}, scene.walls[2])});
      tally.run(LepRig(scene), truths, {{-half, 1.2}, {half, 1.2}},
                seed + static_cast<std::uint64_t>(place), 150);
    }
    SCOPED_TRACE(behind ? "a wall behind" : "nothing behind");
    tally.expect_honest(0.995);
  }
}

// At both sides of what stands before a wall, near and far, over small and large jumps.
TEST(LineExtractor, JumpsAreWhereItSaysAtAnyRange) {
  const std::uint64_t seed = 171;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  for (const double range : {0.55, 0.7, 1.0, 1.4})
    for (const double behind : {0.1, 0.4})
      for (const bool near_left : {true, false}) {
        JumpTally tally;
        for (int place = 0; place < 10; ++place) {
          const double at = 0.05 + 0.0003 * place;
          const double left = near_left ? range : range + behind;
          const double right = near_left ? range + behind : range;
          Scene scene;
          scene.walls = {{{left, -3}, {left, at}, 0.8, {}}, {{right, at}, {right, 3}, 0.8, {}}};
          tally.run(LepRig(scene), {{line_of({}, scene.walls[0])}, {line_of({}, scene.walls[1])}},
                    {{at, range}}, seed + static_cast<std::uint64_t>(place), 50);
        }
        SCOPED_TRACE(::testing::Message() << range << " m, " << behind << " m behind, nearer "
                                          << (near_left ? "left" : "right"));
        tally.expect_honest(0.99);
      }
}

ModuleRun edge_features(const LepRig& rig, std::uint64_t seed) {
  LineExtractor extractor({});
  return extract(extractor, rig.scan(seed));
}

TEST(LineExtractor, ACornerIsCorrelatedWithItsTwoLinesAndTheseAreNotWithEachOther) {
  const ModuleRun result = edge_features(LepRig(edge_scene(1, 120 * degree)), 1);
  ASSERT_TRUE(result.outcome);
  const auto lines = elements_of<LineSegment>(result.output);
  const auto edges = elements_of<Corner>(result.output);
  ASSERT_EQ(lines.size(), 2u);
  ASSERT_EQ(edges.size(), 1u);
  EXPECT_EQ(edges[0]->labels[0], static_cast<int>(CornerKind::real_corner));
  EXPECT_EQ(cross_covariance(lines[0]->lineage, lines[1]->lineage).norm(), 0);
  const Eigen::Matrix2d corner = edges[0]->lineage.covariance();
  for (const Estimate* line : lines) {
    const Eigen::MatrixXd shared = cross_covariance(edges[0]->lineage, line->lineage);
    const double scale = std::sqrt(corner.norm() * line->lineage.variance(0));
    EXPECT_GT(shared.col(0).norm(), 0.05 * scale);
    // A corner lies on its line: the error across the line is the line's own.
    const double phi = line->value[1];
    const Eigen::Vector2d normal(std::cos(phi), std::sin(phi));
    const double along = std::cos(phi) * edges[0]->value[1] - std::sin(phi) * edges[0]->value[0];
    const Eigen::MatrixXd covariance = line->lineage.covariance();
    EXPECT_NEAR(normal.dot(corner * normal) / (covariance(0, 0) - 2 * along * covariance(0, 1) +
                                               along * along * covariance(1, 1)),
                1, 0.01);
  }
}

// In the scan's frame lines are where they are, wherever the scanner stands in it.
TEST(LineExtractor, AMountInAnotherPlaceGivesTheSameLines) {
  const Scene scene = edge_scene(1, 120 * degree);
  for (const auto& [x, z, turned] : {std::tuple(0.0, 0.0, 0.0), std::tuple(0.05, -0.03, 0.0),
                                     std::tuple(-0.043, 0.06, 0.5), std::tuple(0.02, 0.1, -6.0)}) {
    LepRig rig(scene);
    rig.set_mount(x, z);
    rig.sensor_parameters.value[6] = rig.ranging_parameters.value[6] = turned * degree;
    const ModuleRun result = edge_features(rig, 3);
    ASSERT_TRUE(result.outcome);
    const auto lines = elements_of<LineSegment>(result.output);
    ASSERT_EQ(lines.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      const NormalizedError error = error_of(*lines[i], 0, rho_phi(line_of({}, scene.walls[i])));
      EXPECT_LT(error.value, chi_square_quantile(2, 0.9999)) << x << " " << z << " " << turned;
    }
  }
}

TEST(LineExtractor, EveryOutputIsFinite) {
  const ModuleRun result = edge_features(LepRig(edge_scene(1, 120 * degree)), 5);
  ASSERT_TRUE(result.outcome);
  EXPECT_TRUE(all_finite(result.output));
}

}  // namespace
}  // namespace ilss
