// What is particular to the segmenters by lines.
#include <gtest/gtest.h>

#include "sensors/laser/segment/hough.h"
#include "sensors/laser/segment/iterative_end_point_fit.h"
#include "sensors/laser/segment/split_and_merge.h"
#include "sensors/laser/segment/split_and_merge_fuzzy.h"
#include "tests/sensors/laser/segment/cluster_points.h"

namespace ilss {
namespace {

constexpr double pi = std::numbers::pi;
constexpr LaserNoise usual_noise{0.005 * 0.005, 1.7e-3 * 1.7e-3};

template <typename Algorithm>
std::vector<ReadingRun> runs_of_points(std::span<const ScanPoint> points,
                                       typename Algorithm::Options options = {},
                                       const LaserNoise& noise = usual_noise) {
  Algorithm algorithm(options);
  std::vector<ReadingRun> runs;
  algorithm.segment(points, noise, runs);
  return runs;
}

std::vector<ScanPoint> wall_points(std::uint64_t seed, double range_std = 0.005) {
  return points_of(
      beams_to(-1, 1, 230, [](double bearing) { return range_to_line(bearing, 2, 0); }), range_std,
      seed);
}

/// The end-point fit as it is told: one reading after another from the middle outwards.
void fit_plainly(std::span<const ScanPoint> points, const ReadingRun& run, double limit,
                 std::vector<ReadingRun>& runs) {
  const ScanPoint& first = points[run.begin];
  const double dx = points[run.end - 1].x - first.x;
  const double dy = points[run.end - 1].y - first.y;
  const bool is_closed = dx * dx + dy * dy <= limit * limit;
  double most = is_closed ? limit * limit : limit * std::sqrt(dx * dx + dy * dy);
  std::size_t split = 0;
  const auto consider = [&](std::size_t i) {
    if (i <= run.begin || i + 1 >= run.end) return;
    const double x = points[i].x - first.x;
    const double y = points[i].y - first.y;
    const double distance = is_closed ? x * x + y * y : std::abs(dx * y - dy * x);
    if (distance <= most) return;
    most = distance;
    split = i;
  };
  const std::size_t middle = run.begin + run.size() / 2;
  for (std::size_t i = middle; i < run.end; ++i) consider(i);
  for (std::size_t i = middle; i-- > run.begin;) consider(i);
  if (split == 0) return runs.push_back(run);
  fit_plainly(points, {run.begin, split}, limit, runs);
  fit_plainly(points, {split, run.end}, limit, runs);
}

TEST(IterativeEndPointFit, GivesTheSegmentsOfItsPlainFormOnRandomPoints) {
  constexpr std::uint64_t seed = 20261128;
  SCOPED_TRACE(seed);
  std::mt19937_64 draw(seed);
  std::uniform_int_distribution<int> count(1, 60);
  std::uniform_int_distribution<int> step(-2, 2);
  constexpr double threshold = 0.05;
  for (int scan = 0; scan < 2000; ++scan) {
    // A walk on a coarse grid: many distances are equal.
    std::vector<ScanPoint> points(static_cast<std::size_t>(count(draw)));
    double x = 0;
    double y = 0;
    for (ScanPoint& p : points) {
      p.x = x += 0.04 * step(draw);
      p.y = y += 0.04 * step(draw);
    }
    std::vector<ReadingRun> plain;
    fit_plainly(points, {0, points.size()}, threshold, plain);
    EXPECT_EQ(
        runs_of_points<IterativeEndPointFit>(points, {.threshold = threshold, .deviations = 0}),
        plain)
        << "scan " << scan;
  }
}

TEST(IterativeEndPointFit, TakesAClosedRunApartAtThePointFarthestFromItsEnd) {
  // A square room around the laser, whose last reading is the first again.
  const auto points = points_of(beams_to(-pi, pi, 361, [](double bearing) {
    return 2 / std::max(std::abs(std::cos(bearing)), std::abs(std::sin(bearing)));
  }));
  const std::size_t split = farthest_from_chord(points, {0, 361}, 0.05);
  EXPECT_TRUE(split == 135 || split == 225) << split << " is no corner across the room";
  EXPECT_EQ(runs_of_points<IterativeEndPointFit>(points),
            (std::vector<ReadingRun>{{0, 45}, {45, 135}, {135, 225}, {225, 315}, {315, 361}}));
}

TEST(IterativeEndPointFit, SplitsAStaircaseInItsMiddle) {
  // Steps all as far from the chord: split at an end they would cost as many passes as steps.
  std::vector<ScanPoint> points(10001);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].x = static_cast<double>(i);
    points[i].y = i % 10 == 5 ? 1 : 0;
  }
  const std::size_t split = farthest_from_chord(points, {0, points.size()}, 0.05);
  EXPECT_NEAR(static_cast<double>(split), 5000, 10);
}

TEST(IterativeEndPointFit, FindsNothingFarOnARunOfTwo) {
  const auto points = points_of(corner_beams());
  EXPECT_EQ(farthest_from_chord(points, {149, 151}, 0), 0U);
  EXPECT_EQ(farthest_from_chord(points, {150, 151}, 0), 0U);
}

TEST(IterativeEndPointFit, ThresholdGrowsWithTheNoise) {
  const auto points = wall_points(3, 0.03);
  EXPECT_GT(runs_of_points<IterativeEndPointFit>(points, {.deviations = 0}).size(), 1U);
  EXPECT_EQ(runs_of_points<IterativeEndPointFit>(points, {}, {0.03 * 0.03, 0}).size(), 1U);
}

TEST(SplitAndMerge, LeavesWholeWhatTheChordBetweenTwoBadEndsSplits) {
  auto beams = beams_to(-1, 1, 230, [](double bearing) { return range_to_line(bearing, 2, 0); });
  for (LaserBeam* end : {&beams.front(), &beams.back()}) end->range += 0.045 / std::cos(1);
  for (LaserBeam* middle : {&beams[110], &beams[111]}) middle->range -= 0.01;
  const auto points = points_of(beams);
  EXPECT_GT(runs_of_points<IterativeEndPointFit>(points, {.threshold = 0.05}).size(), 1U);
  EXPECT_EQ(runs_of_points<SplitAndMerge>(points, {.threshold = 0.05}),
            (std::vector<ReadingRun>{{0, 230}}));
}

TEST(SplitAndMerge, SplitsACornerOfEqualArmsAtTheCorner) {
  // Its ends are as far from the line of least squares as the corner is.
  auto beams = corner_beams();
  beams.erase(beams.begin(), beams.begin() + 2 * corner_reading - 280);
  const auto points = points_of(beams);
  EXPECT_EQ(runs_of_points<SplitAndMerge>(points),
            (std::vector<ReadingRun>{{0, points.size() / 2}, {points.size() / 2, points.size()}}));
}

/// A wall 2.5 m away with a buttress of 0.5 m in its middle: the outer runs are of one line.
std::vector<ScanPoint> buttress_points() {
  return points_of(beams_to(-0.7, 0.7, 281,
                            [](double bearing) {
                              return range_to_line(bearing, std::abs(bearing) < 0.1975 ? 2 : 2.5,
                                                   0);
                            }),
                   0.005, 21);
}

TEST(SplitAndMergeFuzzy, SegmentsAreRunsAlsoWhereOneLineHasTwo) {
  EXPECT_EQ(runs_of_points<SplitAndMergeFuzzy>(buttress_points()),
            (std::vector<ReadingRun>{{0, 101}, {101, 180}, {180, 281}}));
}

TEST(SplitAndMergeFuzzy, MergesWhatOneLineExplains) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    EXPECT_EQ(runs_of_points<SplitAndMergeFuzzy>(wall_points(seed)).size(), 1U);
  }
}

TEST(Hough, SegmentsAreRunsAlsoWhereOneLineHasTwo) {
  EXPECT_EQ(runs_of_points<Hough>(buttress_points()),
            (std::vector<ReadingRun>{{0, 101}, {101, 180}, {180, 281}}));
}

TEST(Hough, TakesAWallOfManyMoreVotesThanOneReachesAsOne) {
  // 57 m at a distance of 3 m: 2,850 votes.
  const double reach = std::atan(28.5 / 3);
  const auto points = points_of(
      beams_to(-reach, reach, 20000, [](double bearing) { return range_to_line(bearing, 3, 0); }),
      0.005, 23);
  EXPECT_EQ(runs_of_points<Hough>(points), (std::vector<ReadingRun>{{0, 20000}}));
}

TEST(RunFits, GiveTheLineAndTheNoiseAcrossIt) {
  const auto points = wall_points(31);
  RunFits fits;
  fits.update(points, {0.005 * 0.005, 0});
  const ReadingRun run{40, 190};
  const LeastSquaresLine line = fits.line(run);
  double square = 0;
  double variance = 0;
  for (std::size_t i = run.begin; i < run.end; ++i) {
    square += line.distance(points[i]) * line.distance(points[i]);
    const double across = line.normal_x * points[i].cosine + line.normal_y * points[i].sine;
    variance += 0.005 * 0.005 * across * across / static_cast<double>(run.size());
  }
  EXPECT_NEAR(line.square, square, 1e-12);
  EXPECT_NEAR(line.variance, variance, 1e-15);
  EXPECT_NEAR(std::abs(line.normal_x), 1, 1e-4);
  EXPECT_NEAR(line.distance({.x = 2.1, .y = 0.3}) * line.normal_x, 0.1, 0.003);
}

}  // namespace
}  // namespace ilss
