// Sums of readings, and which runs of them lie on a line each.
#include "sensors/range/line_segmentation.h"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include "tests/sensors/range/scans.h"

namespace ilss {
namespace {

double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Weighted least squares of u = m · h by a dense QR decomposition.
struct DenseFit {
  Eigen::Vector2d line;
  double chi_squared;
};
DenseFit dense_fit(std::span<const RangeReading> readings) {
  const auto n = static_cast<Eigen::Index>(readings.size());
  Eigen::MatrixXd a(n, 2);
  Eigen::VectorXd b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const RangeReading& r = readings[static_cast<std::size_t>(i)];
    a.row(i) << std::cos(r.bearing) + r.inverse_range * r.origin_x,
        std::sin(r.bearing) + r.inverse_range * r.origin_z;
    a.row(i) /= r.deviation;
    b[i] = r.inverse_range / r.deviation;
  }
  const Eigen::Vector2d line = a.colPivHouseholderQr().solve(b);
  return {line, (a * line - b).squaredNorm()};
}

TEST(LineInformation, OfARunIsThatOfItsReadings) {
  std::mt19937_64 random(81);
  const auto readings = ScanOf{}.on(on_line(polar_line(1.2, 1.4)), random);
  const LineInformationSums sums = sums_of(readings);
  ASSERT_EQ(sums.size(), readings.size());
  for (const auto& [begin, end] :
       {std::pair<std::size_t, std::size_t>{0, 128}, {0, 5}, {60, 90}, {123, 128}}) {
    const LineInformation run = sums.of(begin, end);
    const LineInformation alone =
        sums_of(std::span(readings).subspan(begin, end - begin)).of(0, end - begin);
    EXPECT_NEAR(run.hxhx / alone.hxhx, 1, 1e-9);
    EXPECT_NEAR(run.hzhz / alone.hzhz, 1, 1e-9);
    EXPECT_NEAR(run.uu / alone.uu, 1, 1e-9);
    EXPECT_NEAR(run.hzu / alone.hzu, 1, 1e-9);
    EXPECT_NEAR(run.hxhz, alone.hxhz, 1e-9 * alone.hzhz);
    EXPECT_NEAR(run.hxu, alone.hxu, 1e-9 * alone.hzu);
  }
}

TEST(LineInformation, GivesTheLineAndChiSquaredOfADenseLeastSquares) {
  constexpr unsigned seed = 82;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  for (int run = 0; run < 300; ++run) {
    ScanOf scan;
    scan.deviation = uniform(random, 0.001, 0.03);
    const auto readings =
        scan.on(on_line(polar_line(uniform(random, 0.5, 2), uniform(random, 0.8, 2.3))), random);
    const auto begin = static_cast<std::size_t>(uniform(random, 0, 100));
    const std::size_t size = 5 + static_cast<std::size_t>(uniform(random, 0, 20));
    const DenseFit fit = dense_fit(std::span(readings).subspan(begin, size));
    const LineInformation information = sums_of(readings).of(begin, begin + size);
    EXPECT_NEAR(information.line().x, fit.line.x(), 1e-6);
    EXPECT_NEAR(information.line().z, fit.line.y(), 1e-6);
    EXPECT_NEAR(information.chi_squared(), fit.chi_squared, 1e-6 + 1e-5 * fit.chi_squared);
    EXPECT_NEAR(information.chi_squared(information.line()), fit.chi_squared,
                1e-6 + 1e-5 * fit.chi_squared);
  }
}

/// Runs of readings that come one by one.
std::vector<ReadingRun> segment(std::span<const RangeReading> readings,
                                const SegmentationRule& rule = {}) {
  LineSegmentation segmentation(rule);
  segmentation.clear();
  LineInformationSums sums;
  for (const RangeReading& r : readings) {
    sums.add(std::cos(r.bearing), std::sin(r.bearing), r.origin_x, r.origin_z, r.inverse_range,
             1 / (r.deviation * r.deviation));
    segmentation.advance(sums);
  }
  segmentation.refine(sums);
  return segmentation.runs();
}

double cost_of(const std::vector<ReadingRun>& runs, const LineInformationSums& sums) {
  const LineSegmentation segmentation{SegmentationRule{}};
  double sum = 0;
  for (const ReadingRun& run : runs) sum += segmentation.cost(sums, run.begin, run.end);
  return sum;
}

TEST(LineSegmentation, RunsFollowEachOtherAndLoseNoReading) {
  constexpr unsigned seed = 83;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  for (int run = 0; run < 300; ++run) {
    const Surface a = on_line(polar_line(uniform(random, 0.6, 2), uniform(random, 1, 2)));
    const Surface b = on_line(polar_line(uniform(random, 0.6, 2), uniform(random, 1, 2)));
    const auto period = static_cast<std::size_t>(uniform(random, 1, 60));
    const auto readings = ScanOf{}.on(
        [&](std::size_t i) -> const Surface& { return i / period % 2 == 0 ? a : b; }, random);
    const auto runs = segment(readings);
    std::size_t next = 0;
    for (const ReadingRun& r : runs) {
      ASSERT_EQ(r.begin, next);
      ASSERT_GT(r.end, r.begin);
      next = r.end;
    }
    ASSERT_EQ(next, readings.size());
  }
}

TEST(LineSegmentation, KeepsOneLineInOneRun) {
  constexpr unsigned seed = 84;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  for (int run = 0; run < 2000; ++run) {
    const Surface line = on_line(polar_line(uniform(random, 0.6, 2), uniform(random, 1, 2)));
    std::size_t segments = 0;
    std::size_t outliers = 0;
    for (const ReadingRun& r : segment(ScanOf{}.on(line, random)))
      (r.size() >= 5 ? segments : outliers) += r.size() >= 5 ? 1 : r.size();
    ASSERT_EQ(segments, 1u) << "run " << run;
    ASSERT_LE(outliers, 1u) << "run " << run << ": what is 3.5 standard deviations off at an end";
  }
}

// The best two segments out of all, or one, where the two lines are clearly different.
TEST(LineSegmentation, FindsTheBestOfAllPairsOfSegments) {
  constexpr unsigned seed = 85;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  int two = 0;
  for (int run = 0; run < 1000; ++run) {
    const InverseLine first = polar_line(uniform(random, 0.6, 2), uniform(random, 1, 2));
    const Surface a = on_line(first);
    // From hardly to very different.
    const double difference = std::exp(uniform(random, std::log(0.005), std::log(0.3)));
    const Surface b = on_line({first.x + difference * uniform(random, -3, 3),
                               first.z + difference * uniform(random, -1, 1)});
    const auto at = static_cast<std::size_t>(uniform(random, 10, 118));
    const auto readings =
        ScanOf{}.on([&](std::size_t i) -> const Surface& { return i < at ? a : b; }, random);
    const LineInformationSums sums = sums_of(readings);
    double best = cost_of({{0, 128}}, sums);
    for (std::size_t k = 1; k < 128; ++k) best = std::min(best, cost_of({{0, k}, {k, 128}}, sums));
    const auto runs = segment(readings);
    EXPECT_LE(cost_of(runs, sums), best + 1e-3) << "run " << run;
    two += runs.size() == 2 ? 1 : 0;
  }
  EXPECT_GT(two, 300);
  EXPECT_LT(two, 900) << "some differ by less than the evidence";
}

TEST(LineSegmentation, EndsARunWithinAFewReadingsOfAClearEdge) {
  std::mt19937_64 random(86);
  const Surface near = on_line(polar_line(1, 1.6));
  const Surface behind = on_line(polar_line(1.5, 1.6));
  const auto readings =
      ScanOf{}.on([&](std::size_t i) -> const Surface& { return i < 64 ? near : behind; }, random);
  LineSegmentation segmentation{SegmentationRule{}};
  segmentation.clear();
  LineInformationSums sums;
  std::size_t ended_at = 0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const RangeReading& r = readings[i];
    sums.add(std::cos(r.bearing), std::sin(r.bearing), r.origin_x, r.origin_z, r.inverse_range,
             1 / (r.deviation * r.deviation));
    if (!segmentation.advance(sums)) continue;
    EXPECT_EQ(ended_at, 0u) << "once";
    ended_at = i;
  }
  EXPECT_GE(ended_at, 64u);
  EXPECT_LE(ended_at, 70u);
  ASSERT_EQ(segmentation.runs().size(), 2u);
  EXPECT_NEAR(static_cast<double>(segmentation.runs()[0].end), 64, 1);
}

TEST(LineSegmentation, EndsAtAGapWhateverTheReadingsSay) {
  std::mt19937_64 random(87);
  const auto readings = ScanOf{}.on(on_line(polar_line(1, 1.6)), random);
  LineSegmentation segmentation{SegmentationRule{}};
  segmentation.clear();
  LineInformationSums sums;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const RangeReading& r = readings[i];
    sums.add(std::cos(r.bearing), std::sin(r.bearing), r.origin_x, r.origin_z, r.inverse_range,
             1 / (r.deviation * r.deviation));
    if (i == 50)
      segmentation.break_before_last(sums);
    else
      segmentation.advance(sums);
  }
  segmentation.refine(sums);
  EXPECT_EQ(segmentation.runs(), (std::vector<ReadingRun>{{0, 50}, {50, 128}}));
}

TEST(LineSegmentation, BearsWithAnOutlierInAScan) {
  constexpr unsigned seed = 88;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  for (int run = 0; run < 300; ++run) {
    auto readings = ScanOf{}.on(on_line(polar_line(1, 1.6)), random);
    const auto at = static_cast<std::size_t>(uniform(random, 10, 118));
    readings[at].inverse_range += 0.3;
    std::size_t in_segments = 0;
    for (const ReadingRun& r : segment(readings)) {
      EXPECT_TRUE(r.size() >= 5 || (r.begin <= at && at < r.end)) << "run " << run;
      if (r.size() >= 5) in_segments += r.size();
    }
    EXPECT_GE(in_segments, 120u) << "run " << run;
  }
}

}  // namespace
}  // namespace ilss
