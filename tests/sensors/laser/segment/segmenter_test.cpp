// What every segmenter must do, whatever its method.
#include "sensors/laser/segment/segmenter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "sensors/laser/features/laser_features.h"
#include "sensors/laser/segment/breakpoints.h"
#include "sensors/laser/segment/cuba.h"
#include "sensors/laser/segment/curvature_scale_space.h"
#include "sensors/laser/segment/hough.h"
#include "sensors/laser/segment/iterative_end_point_fit.h"
#include "sensors/laser/segment/maximum_likelihood_segments.h"
#include "sensors/laser/segment/split_and_merge.h"
#include "sensors/laser/segment/split_and_merge_fuzzy.h"
#include "sensors/laser/segment/triangle_area.h"
#include "tests/allocation_count.h"
#include "tests/sensors/laser/segment/segmenter_run.h"

namespace ilss {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double half_turn = pi / 2;

template <typename Algorithm>
class SegmenterTest : public testing::Test {
 protected:
  /// Scans with noise of the usual size, or of another.
  std::vector<LaserBeam> noisy(std::vector<LaserBeam> beams, std::uint64_t seed,
                               double range_std = usual_errors.range_std) {
    std::mt19937_64 draw(seed);
    std::normal_distribution<double> normal;
    for (LaserBeam& beam : beams)
      if (beam.range > 0) beam.range += range_std * normal(draw);
    return beams;
  }
  SegmenterChain<Algorithm> chain;
};

template <typename Algorithm>
class CurveSegmenterTest : public SegmenterTest<Algorithm> {};

struct AlgorithmNames {
  template <typename Algorithm>
  static std::string GetName(int) {
    return std::string(Algorithm::name);
  }
};

using Algorithms =
    testing::Types<IterativeEndPointFit, SplitAndMerge, SplitAndMergeFuzzy, Hough,
                   CurvatureScaleSpace, Cuba, TriangleArea, MaximumLikelihoodSegments>;
using CurveAlgorithms =
    testing::Types<CurvatureScaleSpace, Cuba, TriangleArea, MaximumLikelihoodSegments>;
TYPED_TEST_SUITE(SegmenterTest, Algorithms, AlgorithmNames);
TYPED_TEST_SUITE(CurveSegmenterTest, CurveAlgorithms, AlgorithmNames);

/// A corner of two walls that meet at 45 degrees left of forward: at x = 2 and at y = 2.
double range_to_corner(double bearing) {
  return bearing < pi / 4 ? range_to_line(bearing, 2, 0) : range_to_line(bearing, 2, half_turn);
}

/// A room of 6 m by 5 m, seen from (3.4 m, 2.2 m) in it.
double range_to_room(double bearing) {
  double range = 1e9;
  const double distances[4] = {2.6, 2.8, 3.4, 2.2};
  for (int side = 0; side < 4; ++side) {
    const double to_side = range_to_line(bearing, distances[side], side * half_turn);
    if (to_side > 0) range = std::min(range, to_side);
  }
  return range;
}

TYPED_TEST(SegmenterTest, PartsTheWallsOfACornerWhereTheyMeet) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const auto beams = this->noisy(beams_to(-0.6, 2.1, 360, range_to_corner), seed);
    std::size_t corner = 0;
    while (beams[corner].bearing < pi / 4) ++corner;
    const auto runs = this->chain.runs(scan_output(beams));
    ASSERT_EQ(runs.size(), 2U);
    EXPECT_EQ(runs[0].begin, 0U);
    EXPECT_NEAR(static_cast<double>(runs[0].end), static_cast<double>(corner), 3);
    EXPECT_EQ(runs[1].begin, runs[0].end) << "no reading is lost at the split";
    EXPECT_EQ(runs[1].end, beams.size());
  }
}

TYPED_TEST(SegmenterTest, TakesAWallAcrossAnyAxisAsOne) {
  for (int side = 0; side < 4; ++side) {
    SCOPED_TRACE(testing::Message() << "wall towards " << 90 * side << " degrees");
    const double direction = std::remainder(side * half_turn, 2 * pi);
    const auto beams =
        this->noisy(beams_to(direction - 1, direction + 1, 230,
                             [&](double bearing) { return range_to_line(bearing, 2, direction); }),
                    7);
    EXPECT_EQ(this->chain.runs(scan_output(beams)), (std::vector<ReadingRun>{{0, 230}}));
  }
}

TYPED_TEST(SegmenterTest, TakesAWallWhoseLinePassesTheLaserAsOne) {
  // At a distance of 1 cm and of nothing: at y = 0.01 from x = 1 on, and along the axis itself.
  const auto near = beams_to(0.01, 0.003, 100, [](double b) { return 0.01 / std::sin(b); });
  const auto through = beams_to(0, 0, 100, [x = 1.0](double) mutable { return x += 0.02; });
  for (const auto& beams : {near, through}) {
    TypeParam algorithm({});
    const LaserErrors exact{0.001, 0, 0};
    EXPECT_EQ(segment_cluster(algorithm, cluster_output(this->noisy(beams, 3, 0.001), exact)),
              (std::vector<ReadingRun>{{0, 100}}));
  }
}

TYPED_TEST(SegmenterTest, FindsNothingOnAWallSeenEdgeOn) {
  const auto beams = beams_to(-half_turn, half_turn, 361, [](double bearing) {
    // The edge of a wall along the x axis, 1 m to 4 m away, hit by two beams at most.
    return std::abs(bearing) < 0.005 ? 1.0 : 0.0;
  });
  EXPECT_EQ(fault_of(this->chain(scan_output(beams)).outcome), "no_detection");
}

TYPED_TEST(SegmenterTest, TakesTheWallBehindAsOnePieceAtEachEndOfTheScan) {
  const auto beams = this->noisy(beams_to(-pi, pi, 720, range_to_room), 5);
  const auto runs = this->chain.runs(scan_output(beams));
  ASSERT_EQ(runs.size(), 5U) << "four walls, the one behind in two pieces";
  EXPECT_EQ(runs.front().begin, 0U);
  EXPECT_EQ(runs.back().end, beams.size());
  const double left_corner = std::atan2(2.8, -3.4);
  EXPECT_NEAR(beams[runs.back().begin].bearing, left_corner, 0.02);
}

TYPED_TEST(SegmenterTest, DoesNotMergeTheWallsBesideADoorway) {
  for (const double behind : {0.0, 3.0}) {  // no return, or a wall 1 m behind this one
    SCOPED_TRACE(testing::Message() << "behind the doorway " << behind);
    const auto beams =
        this->noisy(beams_to(-0.9, 0.9, 360,
                             [&](double bearing) {
                               const double range = range_to_line(bearing, 2, 0);
                               const bool is_door = std::abs(range * std::sin(bearing)) < 0.4;
                               return is_door ? range_to_line(bearing, behind, 0) : range;
                             }),
                    11);
    const auto runs = this->chain.runs(scan_output(beams));
    ASSERT_EQ(runs.size(), behind > 0 ? 3U : 2U);
    EXPECT_LT(beams[runs.front().end - 1].bearing, -0.19);
    EXPECT_GT(beams[runs.back().begin].bearing, 0.19);
  }
}

TYPED_TEST(SegmenterTest, PutsEveryReadingOfAClusterIntoOneRun) {
  if constexpr (std::is_same_v<TypeParam, MaximumLikelihoodSegments>)
    GTEST_SKIP() << "by design: ours leaves out readings that fit nothing";
  TypeParam algorithm({});
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 draw(seed);
    std::normal_distribution<double> normal;
    // A walk of noise, which nothing describes; from one reading to a few hundred.
    std::vector<LaserBeam> beams =
        beams_to(-1.5, 1.5, 2 + draw() % 300, [&, range = 4.0](double) mutable {
          return range = std::abs(range + 0.03 * normal(draw)) + 0.1;
        });
    if (seed == 1) beams.resize(1);
    const auto runs = segment_cluster(algorithm, cluster_output(beams));
    std::size_t end = 0;
    for (const ReadingRun& run : runs) {
      EXPECT_EQ(run.begin, end);
      EXPECT_GT(run.end, run.begin);
      end = run.end;
    }
    EXPECT_EQ(end, beams.size());
  }
}

TYPED_TEST(SegmenterTest, FindsNothingWithoutReturns) {
  const auto beams = beams_to(-1, 1, 180, [](double) { return 0.0; });
  EXPECT_EQ(fault_of(this->chain(scan_output(beams)).outcome), "no_detection");
  Segmenter<TypeParam> segmenter({});
  const Output cluster = cluster_output(beams);
  EXPECT_EQ(fault_of(run(segmenter, {.inputs = {&cluster}}).outcome), "no_detection");
}

TYPED_TEST(SegmenterTest, TakesTwoReadingsAsOneSegmentIfThatIsEnough) {
  if constexpr (std::is_same_v<TypeParam, MaximumLikelihoodSegments>)
    GTEST_SKIP() << "by design: ours takes three readings at least";
  const auto beams = beams_to(0, 0.01, 2, [](double) { return 2.0; });
  EXPECT_EQ(fault_of(this->chain(scan_output(beams)).outcome), "no_detection");
  Segmenter<TypeParam> segmenter({{}, {.least_readings = 2, .least_length = 0}});
  const Output cluster = cluster_output(beams);
  EXPECT_EQ(runs_of(run(segmenter, {.inputs = {&cluster}}).output),
            (std::vector<ReadingRun>{{0, 2}}));
}

TYPED_TEST(SegmenterTest, RefusesNumbersThatAreNone) {
  auto beams = beams_to(-1, 1, 180, [](double) { return 2.0; });
  beams[90].range = NAN;
  Segmenter<TypeParam> segmenter({});
  const Output cluster = cluster_output(beams);
  const ModuleRun result = run(segmenter, {.inputs = {&cluster}});
  ASSERT_EQ(fault_of(result.outcome), "bad_data");
  EXPECT_NE(result.outcome.fault().message.find("beam 90"), std::string::npos);
  EXPECT_EQ(fault_of(this->chain(scan_output(beams)).outcome), "bad_data");
}

TYPED_TEST(SegmenterTest, GivesAnOutcomeForRangesBeyondAnySquare) {
  const auto beams = beams_to(-1, 1, 180, [](double bearing) { return 1e200 * (2 + bearing); });
  Segmenter<TypeParam> segmenter({});
  const Output cluster = cluster_output(beams);
  const ModuleRun result = run(segmenter, {.inputs = {&cluster}});
  EXPECT_TRUE(result.outcome || fault_of(result.outcome) == "no_detection");
}

TYPED_TEST(SegmenterTest, FindsTheWallsOfARoomWithAHundredThousandBeams) {
  if constexpr (std::is_same_v<TypeParam, MaximumLikelihoodSegments>)
    GTEST_SKIP() << "by design: ours costs n times the length of segments: not for so many beams";
  const auto beams = this->noisy(beams_to(-pi, pi, 100000, range_to_room), 9);
  Segmenter<TypeParam> segmenter({});
  const Output cluster = cluster_output(beams);
  const auto runs = runs_of(run(segmenter, {.inputs = {&cluster}}).output);
  ASSERT_EQ(runs.size(), 5U);
  const double corners[4] = {std::atan2(-2.2, -3.4), std::atan2(-2.2, 2.6), std::atan2(2.8, 2.6),
                             std::atan2(2.8, -3.4)};
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(beams[runs[k + 1].begin].bearing, corners[k], 0.02);
}

TYPED_TEST(SegmenterTest, CoversACircleSeenAllAround) {
  const auto beams = this->noisy(beams_to(-pi, pi, 720, [](double) { return 2.0; }), 13);
  Segmenter<TypeParam> segmenter({{}, {.least_readings = 2, .least_length = 0}});
  const Output cluster = cluster_output(beams);
  const ModuleRun result = run(segmenter, {.inputs = {&cluster}});
  ASSERT_TRUE(result.outcome);
  for (const SegmentedBeam& beam : segmented_beams_of(result.output)) EXPECT_GT(beam.segment, 0);
}

TYPED_TEST(CurveSegmenterTest, TakesACircleSeenAllAroundAsOne) {
  if constexpr (std::is_same_v<TypeParam, MaximumLikelihoodSegments>)
    GTEST_SKIP() << "by design: ours has a largest radius";
  for (const double radius : {0.5, 2.0, 5.0}) {
    SCOPED_TRACE(testing::Message() << "radius " << radius);
    const auto beams = this->noisy(beams_to(-pi, pi, 720, [&](double) { return radius; }), 17);
    EXPECT_EQ(this->chain.runs(scan_output(beams)), (std::vector<ReadingRun>{{0, 720}}));
  }
}

TYPED_TEST(SegmenterTest, DoesNotSplitAWallForItsNoise) {
  int split = 0;
  constexpr std::uint64_t scans = 200;
  for (std::uint64_t seed = 1; seed <= scans; ++seed) {
    const LaserErrors errors{0.02, usual_errors.bearing_std, 0};
    const auto beams = this->noisy(
        beams_to(-1, 1, 230, [](double bearing) { return range_to_line(bearing, 2, 0); }), seed,
        errors.range_std);
    split += this->chain.runs(scan_output(beams, errors)).size() != 1;
  }
  EXPECT_LE(split, 4) << "of " << scans;
}

/// A room without a place that is hidden from another: a rectangle with a corner cut off.
Scene convex_room() {
  Scene room;
  const ScenePoint corners[5] = {{-3, -2.5}, {3, -2.5}, {3, 1}, {1.5, 2.5}, {-3, 2.5}};
  for (int k = 0; k < 5; ++k)
    room.walls.push_back({.from = corners[k], .to = corners[(k + 1) % 5], .targets = {}});
  return room;
}

TYPED_TEST(SegmenterTest, FindsTheSameWallsFromWhereverTheLaserStands) {
  const Scene room = convex_room();
  const RayCaster caster(room);
  const LaserSweep sweep{.beams = 720, .field_of_view = 2 * pi * 719 / 720};
  int scans = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 draw(seed);
    const auto between = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(draw);
    };
    const ScenePose laser{between(-1, 1), between(-1, 0.5), between(-pi, pi)};
    const RoomScan exact = scan_room(room, caster, sweep, laser, {}, seed);
    const bool is_fair = std::all_of(exact.pieces.begin(), exact.pieces.end(),
                                     [](const VisiblePiece& piece) { return piece.counts; });
    if (!is_fair) continue;  // a scrap of a wall at an end of the scan
    ++scans;
    const auto runs = this->chain.runs(exact.scan);
    std::size_t found = 0;
    for (const VisiblePiece& piece : exact.pieces)
      for (const ReadingRun& run : runs)
        found += std::abs(static_cast<double>(run.begin) - static_cast<double>(piece.first)) <= 1 &&
                 std::abs(static_cast<double>(run.end) - static_cast<double>(piece.last + 1)) <= 1;
    EXPECT_EQ(runs.size(), exact.pieces.size());
    EXPECT_EQ(found, exact.pieces.size());
  }
  EXPECT_GE(scans, 60);
}

TYPED_TEST(CurveSegmenterTest, TakesAPillarAsOneFromWhereverTheLaserStands) {
  Scene room = convex_room();
  room.pillars.push_back({.centre = {0, 0}, .radius = 0.6});
  const RayCaster caster(room);
  const LaserSweep sweep{.beams = 360};
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 draw(seed);
    const double around = std::uniform_real_distribution<double>(-pi, pi)(draw);
    const double distance = std::uniform_real_distribution<double>(1.1, 2)(draw);
    const double aside = std::uniform_real_distribution<double>(-0.5, 0.5)(draw);
    const ScenePose laser{distance * std::cos(around), distance * std::sin(around),
                          std::remainder(around + pi + aside, 2 * pi)};
    const RoomScan exact = scan_room(room, caster, sweep, laser, {}, seed);
    const auto pillar = std::find_if(exact.pieces.begin(), exact.pieces.end(),
                                     [](const VisiblePiece& piece) { return piece.is_arc; });
    ASSERT_NE(pillar, exact.pieces.end());
    const auto runs = this->chain.runs(exact.scan);
    // Beams that graze the pillar's sides are broken off before the segmenter.
    EXPECT_TRUE(std::any_of(runs.begin(), runs.end(), [&](const ReadingRun& run) {
      return run.begin >= pillar->first && run.begin <= pillar->first + 2 &&
             run.end <= pillar->last + 1 && run.end + 2 >= pillar->last + 1;
    }));
  }
}

/// Counts by the protocol of Núñez et al. 2009, matched by overlap.
struct Tally {
  int lines = 0, lines_found = 0, arcs = 0, arcs_found = 0, extracted = 0, wrong = 0;

  void add(const std::vector<VisiblePiece>& pieces, const std::vector<ReadingRun>& runs) {
    constexpr double match = 0.7;
    for (const VisiblePiece& piece : pieces) {
      if (!piece.counts) continue;
      const bool is_found = std::any_of(runs.begin(), runs.end(), [&](const ReadingRun& run) {
        return overlap(run, run_of(piece)) >= match;
      });
      ++(piece.is_arc ? arcs : lines);
      (piece.is_arc ? arcs_found : lines_found) += is_found;
    }
    for (const ReadingRun& run : runs) {
      ++extracted;
      wrong += std::none_of(pieces.begin(), pieces.end(), [&](const VisiblePiece& piece) {
        return overlap(run, run_of(piece)) >= match;
      });
    }
  }
};

template <typename Algorithm>
Tally tally_rooms(double range_std) {
  Tally tally;
  SegmenterChain<Algorithm> chain;
  const LaserSweep sweep;
  for (std::uint64_t map = 0; map < 20; ++map) {
    const Scene room = generate_room(derive_seed(20260, map));
    const RayCaster caster(room);
    for (std::uint64_t k = 0; k < 5; ++k) {
      const std::uint64_t seed = derive_seed(map, k);
      const auto laser = draw_standpoint(room, caster, sweep, {}, seed);
      if (!laser) continue;
      const RoomScan scan =
          scan_room(room, caster, sweep, *laser, {range_std, usual_errors.bearing_std, 0}, seed);
      tally.add(scan.pieces, chain.runs(scan.scan));
    }
  }
  return tally;
}

TYPED_TEST(SegmenterTest, FindsTheLinesOfGeneratedRooms) {
  for (const double range_std : {0.005, 0.02}) {
    SCOPED_TRACE(testing::Message() << "range_std " << range_std);
    const Tally tally = tally_rooms<TypeParam>(range_std);
    ASSERT_GT(tally.lines, 300);
    EXPECT_GE(tally.lines_found, 0.96 * tally.lines);
    EXPECT_LE(tally.wrong, 0.32 * tally.extracted) << "chords of the pillars among them";
  }
}

TYPED_TEST(CurveSegmenterTest, FindsThePillarsOfGeneratedRooms) {
  for (const double range_std : {0.005, 0.02}) {
    SCOPED_TRACE(testing::Message() << "range_std " << range_std);
    const Tally tally = tally_rooms<TypeParam>(range_std);
    ASSERT_GT(tally.arcs, 90);
    EXPECT_GE(tally.arcs_found, 0.93 * tally.arcs);
    EXPECT_LE(tally.wrong, 0.015 * tally.extracted);
  }
}

TYPED_TEST(SegmenterTest, AllocatesNothingInSteadyState) {
  SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED();
  const Output cluster = cluster_output(this->noisy(beams_to(-pi, pi, 720, range_to_room), 5));
  Segmenter<TypeParam> segmenter({});
  Output output;
  const std::vector<const Output*> inputs = {&cluster};
  const Estimate parameters(no_parameters());
  const Evaluation evaluation{0, {}, 1, 1, parameters, inputs};
  ASSERT_TRUE(segmenter.evaluate(evaluation, output));
  const std::size_t before = allocation_count;
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(segmenter.evaluate(evaluation, output));
  EXPECT_EQ(allocation_count, before);
}

// From beams to features, of scans that show more and less in turn.
TEST(LaserPipeline, AllocatesNothingInSteadyState) {
  SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED();
  std::array<Output, 2> scans;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    scans[k].estimate = Estimate(descriptor<LaserScan>(), "laser");
    assign<LaserScan>(scans[k].estimate,
                      {.range_std = 0.005, .bearing_std = 0, .quantum = 0, .max_range = 80});
    const double side = k == 0 ? pi : half_turn;
    const auto beams = beams_to(-side, side, 720, range_to_room);
    std::ranges::copy(beams, make_beams(scans[k], beams.size()).begin());
  }
  Breakpoints breakpoints({});
  Segmenter<IterativeEndPointFit> segmenter({});
  LaserFeatures features({});
  Output clusters;
  Output segments;
  Output found;
  clusters.estimate = segments.estimate = Estimate(descriptor<SegmentedScan>(), "laser");
  found.estimate = Estimate(descriptor<RangeFeatures>(), "robot");
  const Estimate none(no_parameters());
  const auto run_all = [&](const Output& scan) {
    const std::array<const Output*, 3> inputs{&scan, &clusters, &segments};
    const std::span<const Output* const> all(inputs);
    return breakpoints.evaluate({0, {}, 1, 1, none, all.subspan(0, 1)}, clusters) &&
           segmenter.evaluate({0, {}, 1, 2, none, all.subspan(1, 1)}, segments) &&
           features.evaluate({0, {}, 1, 3, none, all.subspan(2, 1)}, found);
  };
  for (int k = 0; k < 3; ++k)
    for (const Output& scan : scans) ASSERT_TRUE(run_all(scan));
  const std::size_t before = allocation_count;
  for (int k = 0; k < 3; ++k)
    for (const Output& scan : scans) ASSERT_TRUE(run_all(scan));
  EXPECT_EQ(allocation_count, before);
}

}  // namespace
}  // namespace ilss
