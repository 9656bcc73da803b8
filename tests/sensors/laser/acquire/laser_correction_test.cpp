// The systematic error of ranges: calibrated, taken off, and what is left of it stated.
#include "sensors/laser/acquire/laser_correction.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <vector>

#include "framework/estimate/consistency.h"
#include "sensors/laser/acquire/laser_calibration.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

/// A made-up laser's systematic error (m).
double true_bias(double range) {
  return 0.012 - 0.004 * range + 0.0009 * range * range - 0.00002 * std::pow(range, 4);
}

std::vector<CalibrationRange> measure(int count, double stated, std::mt19937_64& draw) {
  constexpr double noise = 0.005;
  std::normal_distribution<double> normal(0, noise);
  std::vector<CalibrationRange> ranges;
  for (int i = 0; i < count; ++i) {
    const double truth = 0.3 + 7.7 * i / (count - 1);
    ranges.push_back({truth + true_bias(truth) + normal(draw), truth, stated});
  }
  return ranges;
}

TEST(LaserCalibration, IsAsWrongAsItSays) {
  std::mt19937_64 draw(20261122);
  ConsistencyStatistic statistic;
  double chi_squared = 0;
  double degrees = 0;
  constexpr int runs = 1000;
  for (int i = 0; i < runs; ++i) {
    const auto calibration = calibrate_laser(measure(100, 0.005, draw), 6);
    ASSERT_TRUE(calibration);
    chi_squared += calibration->chi_squared;
    degrees += calibration->degrees_of_freedom();
    // Judged where it is used: at seven ranges, which seven coefficients tell apart.
    Eigen::Matrix<double, 7, 7> powers;
    Eigen::Matrix<double, 7, 1> error;
    for (int k = 0; k < 7; ++k) {
      const double truth = 0.5 + 1.2 * k;
      const double share = (truth + true_bias(truth)) / calibration->reference;
      for (int j = 0; j < 7; ++j) powers(k, j) = std::pow(share, j);
      error[k] = range_bias(calibration->bias, share) - true_bias(truth);
    }
    statistic.add(
        normalized_squared_error(error, powers * calibration->covariance * powers.transpose()));
  }
  const Interval bounds = chi_square_interval(7.0 * runs, 0.99);
  const double mean = statistic.mean();
  EXPECT_GT(mean, bounds.low / (7 * runs));
  EXPECT_LT(mean, bounds.high / (7 * runs));
  EXPECT_NEAR(chi_squared / degrees, 1, 0.02);
}

TEST(LaserCalibration, WithoutStatedNoiseItIsThatOfTheResiduals) {
  std::mt19937_64 draw(3);
  const auto calibration = calibrate_laser(measure(400, 0, draw), 6);
  ASSERT_TRUE(calibration);
  EXPECT_FALSE(calibration->noise_is_stated);
  EXPECT_NEAR(calibration->range_std, 0.005, 0.0006);
}

TEST(LaserCalibration, CoefficientsBeyondTheOrderAreZero) {
  std::mt19937_64 draw(4);
  const auto calibration = calibrate_laser(measure(50, 0.005, draw), 2);
  ASSERT_TRUE(calibration);
  for (std::size_t k = 3; k < range_biases; ++k) {
    EXPECT_EQ(calibration->bias[k], 0);
    EXPECT_EQ(calibration->covariance.row(static_cast<Eigen::Index>(k)).norm(), 0);
  }
}

TEST(LaserCalibration, RefusesWhatDeterminesNoPolynomial) {
  std::mt19937_64 draw(5);
  const auto fault_kind = [](const std::vector<CalibrationRange>& ranges) {
    return calibrate_laser(ranges, 6).fault().kind;
  };
  EXPECT_EQ(fault_kind(measure(7, 0.005, draw)), FaultKind::degenerate);
  EXPECT_EQ(fault_kind(std::vector<CalibrationRange>(20, {2.01, 2, 0.005})), FaultKind::degenerate);
  auto ranges = measure(20, 0.005, draw);
  ranges[3].deviation = 0;
  EXPECT_EQ(fault_kind(ranges), FaultKind::bad_data);
  ranges = measure(20, 0.005, draw);
  ranges[4].measured = NAN;
  EXPECT_EQ(fault_kind(ranges), FaultKind::bad_data);
}

Output scan_of(std::vector<LaserBeam> beams) {
  Output scan;
  scan.estimate = Estimate(descriptor<LaserScan>(), "laser");
  const auto rows = make_beams(scan, beams.size());
  std::copy(beams.begin(), beams.end(), rows.begin());
  return scan;
}

TEST(LaserCorrection, TakesThePolynomialOffEveryReturn) {
  const Output scan = scan_of({{-0.5, 2}, {0, 0}, {0.5, 4}});
  Tick tick{.parameters = Estimate(descriptor<LaserCorrection::Parameters>()), .inputs = {&scan}};
  tick.parameters.value = {0.01, 0.02, 0, 0, 0, 0, 0.03, 4};
  LaserCorrection correction;
  const ModuleRun result = run(correction, tick);
  ASSERT_TRUE(result.outcome);
  const auto beams = beams_of(result.output);
  EXPECT_DOUBLE_EQ(beams[0].range, 2 - (0.01 + 0.02 / 2 + 0.03 / 64));
  EXPECT_EQ(beams[1].range, 0) << "no return stays none";
  EXPECT_DOUBLE_EQ(beams[2].range, 4 - 0.06);
}

TEST(LaserCorrection, WhatTheCalibrationSaysTooMuchIsMissing) {
  Output scan = scan_of({{0, 2}});
  scan.estimate.value[bias_range] = 2;
  scan.estimate.lineage.add({8, 0, persistent_tick}, first_bias + 1, 0.001);
  Tick tick{.parameters = Estimate(descriptor<LaserCorrection::Parameters>()), .inputs = {&scan}};
  tick.parameters.value[range_biases] = 4;
  tick.parameters.lineage.add({9, 0, persistent_tick}, 1, 0.005);
  LaserCorrection correction;
  const ModuleRun result = run(correction, tick);
  ASSERT_TRUE(result.outcome);
  const Estimate& out = result.output.estimate;
  EXPECT_EQ(out.value[bias_range], 4);
  ASSERT_EQ(out.lineage.size(), 2U);
  EXPECT_DOUBLE_EQ(out.lineage.column(0)[first_bias + 1], 0.002) << "told by the new reference";
  EXPECT_DOUBLE_EQ(out.lineage.column(1)[first_bias + 1], -0.005);
}

TEST(LaserCorrection, LeavesTheMountAsItIs) {
  Output scan = scan_of({{0, 2}});
  const std::array mount{0.2, -0.1, 0.3};
  std::ranges::copy(mount, scan.estimate.value.begin() + first_mount);
  for (std::uint32_t k = 0; k < mount_size; ++k)
    scan.estimate.lineage.add({8, k, persistent_tick}, first_mount + k, 0.01);
  const Tick tick{.parameters = Estimate(descriptor<LaserCorrection::Parameters>()),
                  .inputs = {&scan}};
  LaserCorrection correction;
  const ModuleRun result = run(correction, tick);
  ASSERT_TRUE(result.outcome);
  const Estimate& out = result.output.estimate;
  EXPECT_TRUE(std::ranges::equal(mount, std::span(out.value).subspan(first_mount)));
  EXPECT_EQ(out.lineage.factor(), scan.estimate.lineage.factor());
}

TEST(LaserCorrection, NeedsARangeToReferTo) {
  const Output scan = scan_of({{0, 2}});
  Tick tick{.parameters = Estimate(descriptor<LaserCorrection::Parameters>()), .inputs = {&scan}};
  tick.parameters.value[range_biases] = 0;
  LaserCorrection correction;
  EXPECT_EQ(fault_of(run(correction, tick).outcome), "out_of_range");
}

}  // namespace
}  // namespace ilss
