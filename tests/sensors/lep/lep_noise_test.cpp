// The noise current by regression, on the paper's table and on made data.
#include "sensors/lep/lep_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "framework/estimate/consistency.h"
#include "sensors/lep/lep_detector.h"
#include "tests/sensors/lep/pears_table2.h"

namespace ilss {
namespace {

TEST(LepNoise, FindsTheNoiseCurrentOfThePapersTable) {
  ASSERT_EQ(pears_table2().size(), 8u);
  const auto fit = fit_noise_current(pears_noise(), 0.01);
  ASSERT_TRUE(fit);
  // I_n P/2 = 181 um nA and a slope of -1.02, worked out by hand from the table.
  EXPECT_NEAR(fit->noise_current * 0.005, 181e-15, 0.5e-15);
  EXPECT_NEAR(fit->slope, -1.02, 0.005);
  EXPECT_LT(std::abs(fit->slope + 1), 2 * fit->slope_deviation);
  EXPECT_NEAR(fit->noise_current, lep_noise_current, 0.05e-12);  // what ships
}

TEST(LepNoise, IsExactOnExactData) {
  std::vector<LepNoiseReading> readings;
  for (const double current : {1e-9, 3e-9, 20e-9}) readings.push_back({current, 2e-14 / current});
  const auto fit = fit_noise_current(readings, 0.02);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->noise_current, 2e-12, 1e-24);
  EXPECT_NEAR(fit->noise_current_deviation, 0, 1e-24);
  EXPECT_NEAR(fit->slope, -1, 1e-12);
}

TEST(LepNoise, StandardErrorsAreHonest) {
  const std::uint32_t seed = 5;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::normal_distribution<double> scatter(0, 0.05);
  constexpr int runs = 4000;
  constexpr int readings = 8;
  double of_current = 0;
  double of_slope = 0;
  for (int i = 0; i < runs; ++i) {
    std::vector<LepNoiseReading> table = pears_noise();
    for (LepNoiseReading& reading : table)
      reading.deviation = 180e-15 / reading.current * std::exp(scatter(random));
    const auto fit = fit_noise_current(table, 0.01);
    ASSERT_TRUE(fit);
    of_current += std::pow(
        std::log(fit->noise_current / 36e-12) / (fit->noise_current_deviation / fit->noise_current),
        2);
    of_slope += std::pow((fit->slope + 1) / fit->slope_deviation, 2);
  }
  // Squares of Student's t with n - 1 and n - 2 degrees of freedom have the mean v / (v - 2).
  EXPECT_NEAR(of_current / runs / ((readings - 1.0) / (readings - 3.0)), 1, 0.15);
  EXPECT_NEAR(of_slope / runs / ((readings - 2.0) / (readings - 4.0)), 1, 0.2);
}

TEST(LepNoise, RefusesWhatTellsNothing) {
  const auto kind = [](const std::vector<LepNoiseReading>& readings) {
    const auto fit = fit_noise_current(readings, 0.01);
    return fit.is_fault() ? fault_name(fit.fault().kind) : "fit";
  };
  EXPECT_EQ(kind({{1e-9, 1e-6}, {2e-9, 5e-7}}), "degenerate");
  EXPECT_EQ(kind({{1e-9, 1e-6}, {1e-9, 1.1e-6}, {1e-9, 0.9e-6}}), "degenerate");
  EXPECT_EQ(kind({{1e-9, 1e-6}, {2e-9, 5e-7}, {3e-9, 0}}), "bad_data");
  EXPECT_EQ(kind({{1e-9, 1e-6}, {2e-9, 5e-7}, {-3e-9, 1e-7}}), "bad_data");
  EXPECT_EQ(kind({{1e-9, 1e-6}, {2e-9, 5e-7}, {std::nan(""), 1e-7}}), "bad_data");
}

}  // namespace
}  // namespace ilss
