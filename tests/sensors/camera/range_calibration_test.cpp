#include "sensors/camera/range_calibration.h"

#include <gtest/gtest.h>

#include "framework/estimate/consistency.h"
#include "tests/sensors/camera/camera_rig.h"

namespace ilss {
namespace {

constexpr double horizon = 63.5;
constexpr double scale = 30;  // f Y0 / pitch = 6 mm 200 mm / 40 um

double row_at(double range) { return horizon - scale / range; }

Output row_reading(double row, double std) {
  Output output;
  output.estimate = Estimate(descriptor<ImageRow>());
  output.estimate.value = {row};
  output.estimate.lineage.add({7, 0, 0}, 0, std);
  return output;
}

RangeCalibration::Options noisy_pairs(std::size_t count, double row_std, std::uint64_t seed) {
  RandomBits bits(seed);
  RangeCalibration::Options options;
  for (std::size_t i = 0; i < count; ++i) {
    const double range = 0.6 + 1.2 * static_cast<double>(i) / static_cast<double>(count - 1);
    options.pairs.push_back({range, row_at(range) + row_std * draw_normal(bits)});
  }
  return options;
}

TEST(RangeCalibration, RecoversTheHyperbolaFromExactPairs) {
  const auto fit = RangeCalibration::fit(noisy_pairs(5, 0, 1));
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->horizon, horizon, 1e-9);
  EXPECT_NEAR(fit->scale, scale, 1e-9);
}

TEST(RangeCalibration, StatedErrorIsConsistentOverRedrawnCalibrations) {
  SCOPED_TRACE("seeds 41 and 42");
  constexpr double row_std = 0.05;
  constexpr double range = 1.1;
  ConsistencyStatistic statistic;
  for (std::uint64_t run_number = 0; run_number < 1000; ++run_number) {
    auto options = noisy_pairs(7, row_std, derive_seed(41, run_number));
    options.row_std = row_std;
    RangeCalibration calibration(options);
    RandomBits bits(derive_seed(42, run_number));
    const double row = row_at(range) + row_std * draw_normal(bits);
    const Output reading = row_reading(row, row_std);
    Output output;
    output.estimate = Estimate(descriptor<WallRange>());
    ASSERT_TRUE(run(calibration, Estimate{}, &reading, run_number, output));
    statistic.add(nees(output.estimate, std::array{range}));
  }
  EXPECT_TRUE(statistic.consistent(0.99)) << statistic.mean();
}

TEST(RangeCalibration, RowVarianceFromTheResidualsIsUnbiased) {
  SCOPED_TRACE("seed 43");
  constexpr int runs = 1000;
  double sum = 0;
  for (std::uint64_t i = 0; i < runs; ++i)
    sum += std::pow(RangeCalibration::fit(noisy_pairs(12, 0.05, derive_seed(43, i)))->row_std, 2);
  // Ten degrees of freedom each.
  const Interval bounds = chi_square_interval(10 * runs, 0.99);
  EXPECT_TRUE(bounds.contains(10 * sum / (0.05 * 0.05))) << sum / runs;
}

TEST(RangeCalibration, CalibrationErrorIsTheSameAtEveryTick) {
  auto options = noisy_pairs(7, 0.05, 4);
  options.row_std = 0.05;
  RangeCalibration calibration(options);
  const Output reading = row_reading(row_at(1), 0);
  Output first, second;
  first.estimate = second.estimate = Estimate(descriptor<WallRange>());
  ASSERT_TRUE(run(calibration, Estimate{}, &reading, 1, first));
  ASSERT_TRUE(run(calibration, Estimate{}, &reading, 2, second));
  EXPECT_GT(first.estimate.lineage.variance(0), 0);
  EXPECT_DOUBLE_EQ(cross_covariance(first.estimate.lineage, second.estimate.lineage)(0, 0),
                   first.estimate.lineage.variance(0));
}

TEST(RangeCalibration, RowBelowTheHorizonIsOutOfRange) {
  RangeCalibration calibration(noisy_pairs(5, 0, 1));
  const Output reading = row_reading(horizon + 1, 0.1);
  Output output;
  output.estimate = Estimate(descriptor<WallRange>());
  const auto outcome = run(calibration, Estimate{}, &reading, 1, output);
  ASSERT_TRUE(outcome.is_fault());
  EXPECT_EQ(outcome.fault().kind, FaultKind::out_of_range);
}

TEST(RangeCalibration, PairsAtOneRangeAreDegenerate) {
  RangeCalibration::Options options;
  options.pairs = {{1, 10}, {1, 11}, {1, 12}};
  RangeCalibration calibration(options);
  const Output reading = row_reading(10, 0.1);
  Output output;
  output.estimate = Estimate(descriptor<WallRange>());
  const auto outcome = run(calibration, Estimate{}, &reading, 1, output);
  ASSERT_TRUE(outcome.is_fault());
  EXPECT_EQ(outcome.fault().kind, FaultKind::degenerate);
}

}  // namespace
}  // namespace ilss
