// Latency histograms against exact statistics of the same durations.
#include "framework/runtime/latency_histogram.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace ilss {
namespace {

std::uint64_t exact_quantile(const std::vector<std::uint64_t>& sorted, double probability) {
  const double rank = std::ceil(probability * static_cast<double>(sorted.size()));
  return sorted[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

TEST(LatencyHistogram, IsZeroBeforeAnythingIsRecorded) {
  const LatencyHistogram histogram;
  EXPECT_EQ(histogram.count(), 0U);
  EXPECT_EQ(histogram.mean(), 0);
  EXPECT_EQ(histogram.quantile(0.99), 0U);
  EXPECT_EQ(histogram.max(), 0U);
}

TEST(LatencyHistogram, KeepsEveryNanosecondApartBelow128) {
  for (std::uint64_t value = 0; value < 128; ++value) {
    LatencyHistogram histogram;
    histogram.record(value);
    histogram.record(1'000'000);
    EXPECT_EQ(histogram.quantile(0.5), value);
  }
}

TEST(LatencyHistogram, BucketsAreAtMost1Over64WideUpToAnHour) {
  // Around each power of two, where an octave's buckets begin, and at odd places between.
  for (double x = 1; x < 3.6e12; x *= 1.0137) {
    const auto value = static_cast<std::uint64_t>(x);
    LatencyHistogram histogram;
    histogram.record(value);
    histogram.record(UINT64_MAX / 4);
    const std::uint64_t shown = histogram.quantile(0.5);
    EXPECT_GE(shown, value);
    EXPECT_LT(static_cast<double>(shown - value), static_cast<double>(value) / 64) << value;
  }
}

TEST(LatencyHistogram, QuantilesAreThoseOfTheSortedDurationsWithinABucket) {
  constexpr unsigned seed = 42;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 generator(seed);
  std::lognormal_distribution<double> duration(6.0, 2.5);
  std::vector<std::uint64_t> all;
  LatencyHistogram histogram;
  for (int i = 0; i < 100'000; ++i) {
    all.push_back(static_cast<std::uint64_t>(duration(generator)));
    histogram.record(all.back());
  }
  std::ranges::sort(all);
  for (const double probability : {0.0, 0.001, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const std::uint64_t exact = exact_quantile(all, probability);
    EXPECT_GE(histogram.quantile(probability), exact) << probability;
    EXPECT_LE(static_cast<double>(histogram.quantile(probability)),
              static_cast<double>(exact) * (1 + 1.0 / 64))
        << probability;
  }
}

TEST(LatencyHistogram, MeanAndMaximumAreExact) {
  LatencyHistogram histogram;
  for (const std::uint64_t value : {1'000'003U, 2'000'001U, 3'000'002U}) histogram.record(value);
  EXPECT_EQ(histogram.mean(), 2'000'002);
  EXPECT_EQ(histogram.max(), 3'000'002U);
  EXPECT_EQ(histogram.quantile(1), 3'000'002U);
}

TEST(LatencyHistogram, CountsDurationsBeyondItsRange) {
  LatencyHistogram histogram;
  const std::uint64_t three_hours = 3ULL * 3600 * 1'000'000'000;
  histogram.record(5);
  histogram.record(three_hours);
  EXPECT_EQ(histogram.quantile(0.99), three_hours);
  EXPECT_EQ(histogram.count(), 2U);
}

TEST(LatencyHistogram, MergedHistogramsEqualOneThatRecordedEverything) {
  LatencyHistogram together;
  LatencyHistogram first;
  LatencyHistogram second;
  for (std::uint64_t i = 1; i < 5000; ++i) {
    together.record(i * i);
    (i % 3 == 0 ? first : second).record(i * i);
  }
  first.merge(second);
  EXPECT_EQ(first.count(), together.count());
  EXPECT_EQ(first.mean(), together.mean());
  EXPECT_EQ(first.max(), together.max());
  for (const double probability : {0.01, 0.5, 0.9, 0.99, 0.999})
    EXPECT_EQ(first.quantile(probability), together.quantile(probability));
}

TEST(LatencyHistogram, SummaryGivesTheFiguresByName) {
  LatencyHistogram histogram;
  for (std::uint64_t i = 1; i <= 100; ++i) histogram.record(i);
  const LatencySummary summary = histogram.summary();
  EXPECT_EQ(summary.count, 100U);
  EXPECT_EQ(summary.mean, 50.5);
  EXPECT_EQ(summary.p50, 50U);
  EXPECT_EQ(summary.p90, 90U);
  EXPECT_EQ(summary.p99, 99U);
  EXPECT_EQ(summary.p999, 100U);
  EXPECT_EQ(summary.max, 100U);
}

TEST(LatencyHistogram, ResetForgetsEverything) {
  LatencyHistogram histogram;
  histogram.record(7);
  histogram.reset();
  EXPECT_EQ(histogram.count(), 0U);
  EXPECT_EQ(histogram.quantile(1), 0U);
}

}  // namespace
}  // namespace ilss
