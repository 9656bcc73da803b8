// The sonar: where its readings come from and what it says of their error.
#include "sensors/sonar/sonar.h"

#include <gtest/gtest.h>

#include <fstream>
#include <numbers>

#include "framework/estimate/consistency.h"
#include "framework/graph/given_outputs.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;

Sonar::Options sonar_options(const std::string& yaml) {
  Diagnostics diagnostics;
  auto options = options_from<Sonar::Options>(yaml, diagnostics);
  for (const Diagnostic& d : diagnostics.sorted()) ADD_FAILURE() << format_diagnostic(d);
  return options;
}

std::string mistake_in(const std::string& yaml) {
  Diagnostics diagnostics;
  options_from<Sonar::Options>(yaml, diagnostics);
  if (diagnostics.size() != 1) return std::to_string(diagnostics.size()) + " mistakes";
  return diagnostics.sorted()[0].message;
}

Tick tick_at(std::int64_t number, std::uint64_t seed = 1) {
  Tick tick;
  tick.parameters = Estimate(descriptor<Sonar::Parameters>());
  tick.tick = number;
  tick.seed = seed;
  return tick;
}

std::string write_file(const std::string& name, const std::string& text) {
  // Of this test alone: others run beside it.
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::string path = ::testing::TempDir() + "/ilss_" + test->name() + "_" + name;
  std::ofstream(path) << text;
  return path;
}

double range_of(const ModuleRun& result) { return result.output.estimate.value.at(0); }

TEST(Sonar, GivesItsValuesOneATickAndThenNoMore) {
  Sonar sonar(
      sonar_options("{range_std: 2 mm, input: {values: [{range: 0.912 m}, {range: 80 cm}]}}"));
  const auto first = run(sonar, tick_at(0));
  ASSERT_TRUE(first.outcome);
  EXPECT_DOUBLE_EQ(range_of(first), 0.912);
  EXPECT_DOUBLE_EQ(range_of(run(sonar, tick_at(1))), 0.8);
  EXPECT_EQ(fault_of(run(sonar, tick_at(2)).outcome), "end_of_data");
}

TEST(Sonar, IsPendingBetweenItsReadings) {
  Sonar sonar(
      sonar_options("{range_std: 2 mm, period: 3, input: {values: [{range: 1 m}, {range: 2 m}]}}"));
  EXPECT_DOUBLE_EQ(range_of(run(sonar, tick_at(0))), 1);
  EXPECT_TRUE(run(sonar, tick_at(1)).outcome.is_pending());
  EXPECT_TRUE(run(sonar, tick_at(2)).outcome.is_pending());
  EXPECT_DOUBLE_EQ(range_of(run(sonar, tick_at(3))), 2);
}

TEST(Sonar, AddsAFreshErrorATickAndPassesItsMountsErrorOn) {
  Sonar sonar(sonar_options("{range_std: 2 mm, input: {values: [{range: 1 m}, {range: 1 m}]}}"));
  Tick tick = tick_at(1);
  tick.parameters.value = {10 * degree, 0.1, 0.2, 0.3, 5, 6, 7};
  const Source heading{9, 0, persistent_tick};
  tick.parameters.lineage.add(heading, 3, 0.5 * degree);
  const auto result = run(sonar, tick);
  ASSERT_TRUE(result.outcome);
  const Estimate& reading = result.output.estimate;
  const std::vector<double> expected = {1, 10 * degree, 0.1, 0.2, 0.3};
  EXPECT_EQ(reading.value, expected);
  ASSERT_EQ(reading.lineage.size(), 2u);
  EXPECT_EQ(reading.lineage.sources()[0], (Source{1, 0, 1}));
  EXPECT_EQ(reading.lineage.sources()[1], heading);
  EXPECT_DOUBLE_EQ(reading.lineage.standard_deviation(0), 0.002);
  EXPECT_DOUBLE_EQ(reading.lineage.standard_deviation(4), 0.5 * degree);
  EXPECT_EQ(reading.lineage.standard_deviation(1), 0);
}

TEST(Sonar, StatesAVarianceThatGrowsWithRange) {
  Sonar sonar(sonar_options(
      "{range_error: {constant: 3 mm, proportional: 0.002}, input: {values: [{range: 2 m}]}}"));
  const auto result = run(sonar, tick_at(0));
  ASSERT_TRUE(result.outcome);
  EXPECT_DOUBLE_EQ(result.output.estimate.lineage.standard_deviation(0), 0.005);
}

TEST(Sonar, DetectsNothingWhereNoEchoComesBack) {
  Sonar sonar(sonar_options(
      "{range_std: 2 mm, no_echo: 5 m, input: {values: [{range: 5 m}, {range: 4.999 m}]}}"));
  EXPECT_EQ(fault_of(run(sonar, tick_at(0)).outcome), "no_detection");
  EXPECT_TRUE(run(sonar, tick_at(1)).outcome);
}

TEST(Sonar, RefusesAReadingThatIsNotPositive) {
  Sonar sonar(sonar_options("{range_std: 2 mm, input: {values: [{range: 0 m}]}}"));
  EXPECT_EQ(fault_of(run(sonar, tick_at(0)).outcome), "out_of_range");
}

TEST(Sonar, ReadsAColumnOfARecordingInItsUnit) {
  const std::string path = write_file("sonar_test_ring.csv", "S1,S2\n100,912\n101,bad\n102\n");
  Sonar sonar(
      sonar_options("{range_std: 2 mm, input: {csv: {file: " + path + ", column: S2, unit: mm}}}"));
  EXPECT_NEAR(range_of(run(sonar, tick_at(0))), 0.912, 1e-15);
  const auto bad = run(sonar, tick_at(1));
  ASSERT_EQ(fault_of(bad.outcome), "bad_data");
  EXPECT_NE(bad.outcome.fault().message.find(path + ":3:"), std::string::npos);
  const auto short_row = run(sonar, tick_at(2));
  ASSERT_EQ(fault_of(short_row.outcome), "bad_data");
  EXPECT_NE(short_row.outcome.fault().message.find(path + ":4:"), std::string::npos);
  EXPECT_EQ(fault_of(run(sonar, tick_at(3)).outcome), "end_of_data");
}

TEST(Sonar, LosesItsDeviceWhereTheRecordingIsMissing) {
  Sonar sonar(sonar_options("{range_std: 2 mm, input: {csv: {file: /nonexistent.csv}}}"));
  EXPECT_EQ(fault_of(run(sonar, tick_at(0)).outcome), "device_lost");
}

TEST(Sonar, LosesItsDeviceWhereTheRecordingLacksTheColumn) {
  const std::string path = write_file("sonar_test_columns.csv", "S1,S2\n100,912\n");
  Sonar sonar(sonar_options("{range_std: 2 mm, input: {csv: {file: " + path + ", column: S3}}}"));
  for (const std::int64_t tick : {0, 1})
    EXPECT_EQ(fault_of(run(sonar, tick_at(tick)).outcome), "device_lost") << "tick " << tick;
}

TEST(Sonar, DetectsNothingWhereTheRecordedCellIsEmpty) {
  const std::string path = write_file("sonar_test_empty.csv", "S1,S2\n1,\n1,2\n");
  Sonar sonar(sonar_options("{range_std: 2 mm, input: {csv: {file: " + path + ", column: S2}}}"));
  EXPECT_EQ(fault_of(run(sonar, tick_at(0)).outcome), "no_detection");
  EXPECT_EQ(range_of(run(sonar, tick_at(1))), 2);
}

class SonarInScene : public ::testing::Test {
 protected:
  SonarInScene() {
    const std::string path = write_file(
        "sonar_test_scene.yaml", "walls: [{from: {x: 2 m, z: -9 m}, to: {x: 2 m, z: 9 m}}]\n");
    yaml_ = "{range_std: 2 mm, max_range: 3 m, input: {scene: " + path + "}}";
  }
  std::string yaml_;
  Output expected_;
};

TEST_F(SonarInScene, MeasuresFromItsMountOnTheRobot) {
  Sonar sonar(sonar_options(yaml_));
  Tick tick = tick_at(0);
  tick.parameters.value = {11 * degree, 0.2, 0.5, 90 * degree, 0, 1, -60 * degree};
  ASSERT_TRUE(sonar.expect(tick.evaluation(), nullptr, expected_));
  // The sonar looks 30 degrees to the right of the wall's normal, so its left edge is nearest.
  const double x = std::cos(60 * degree) * 0.2 + std::sin(60 * degree) * 0.5;
  EXPECT_NEAR(expected_.estimate.value[0], (2 - x) / std::cos(19 * degree), 1e-12);
}

TEST_F(SonarInScene, DoesNotDependOnWhichTickIsAskedFirst) {
  Sonar in_order(sonar_options(yaml_));
  std::vector<double> ranges;
  for (std::uint64_t tick = 0; tick < 9; ++tick)
    ranges.push_back(range_of(run(in_order, tick_at(static_cast<std::int64_t>(tick), tick))));
  Sonar other(sonar_options(yaml_));
  for (const std::uint64_t tick : {7, 3, 7, 0})
    EXPECT_EQ(range_of(run(other, tick_at(static_cast<std::int64_t>(tick), tick))), ranges[tick]);
}

TEST_F(SonarInScene, ScattersAsItsErrorModelSays) {
  Sonar sonar(sonar_options(yaml_));
  constexpr std::uint64_t seed = 6;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  ConsistencyStatistic statistic;
  for (std::int64_t i = 0; i < 2000; ++i) {
    const auto result = run(sonar, tick_at(i, derive_seed(seed, static_cast<std::uint64_t>(i))));
    ASSERT_TRUE(result.outcome);
    Eigen::VectorXd error(1);
    error << range_of(result) - 2;
    statistic.add(normalized_squared_error(
        error, result.output.estimate.lineage.covariance().topLeftCorner(1, 1)));
  }
  EXPECT_TRUE(statistic.consistent(0.99)) << statistic.mean();
}

TEST_F(SonarInScene, GivesTheSameReadingForTheSameSeed) {
  Sonar sonar(sonar_options(yaml_));
  EXPECT_EQ(range_of(run(sonar, tick_at(0, 3))), range_of(run(sonar, tick_at(0, 3))));
  EXPECT_NE(range_of(run(sonar, tick_at(0, 3))), range_of(run(sonar, tick_at(0, 4))));
}

TEST_F(SonarInScene, DetectsNothingBeyondItsMaximumRange) {
  Sonar sonar(sonar_options(yaml_));
  Tick tick = tick_at(0);
  tick.parameters.value[4] = -1.5;
  EXPECT_EQ(fault_of(run(sonar, tick).outcome), "no_detection");
}

TEST(SonarExpect, AttachesTheErrorModelToAnOperatingPoint) {
  Sonar sonar(
      sonar_options("{range_error: {proportional: 0.01}, input: {values: [{range: 1 m}]}}"));
  Tick tick = tick_at(0);
  tick.parameters.value = {11 * degree, 0.1, 0.2, 0.3, 0, 0, 0};
  tick.parameters.lineage.add({9, 0, persistent_tick}, 1, 0.004);
  const Output point = output_of<SonarReading>({2, required, required, 0.25, required});
  Output output;
  ASSERT_TRUE(sonar.expect(tick.evaluation(), &point, output));
  const std::vector<double> expected = {2, 11 * degree, 0.1, 0.25, 0.3};
  EXPECT_EQ(output.estimate.value, expected);
  EXPECT_DOUBLE_EQ(output.estimate.lineage.standard_deviation(0), 0.02);
  EXPECT_DOUBLE_EQ(output.estimate.lineage.standard_deviation(2), 0.004);
}

TEST(SonarExpect, TakesTheFirstReadingWithoutAnOperatingPoint) {
  Sonar sonar(sonar_options("{range_std: 2 mm, input: {values: [{range: 1 m}, {range: 3 m}]}}"));
  Output output;
  ASSERT_TRUE(sonar.expect(tick_at(5).evaluation(), nullptr, output));
  EXPECT_EQ(output.estimate.value[0], 1);
}

TEST(SonarOptions, WantExactlyOneInputAndOneErrorModel) {
  EXPECT_EQ(mistake_in("{range_std: 2 mm}"), "missing parameter 'input'");
  EXPECT_EQ(mistake_in("{range_std: 2 mm, input: {}}"),
            "a sonar's input needs exactly one of 'values', 'csv' and 'scene'");
  EXPECT_EQ(mistake_in("{input: {values: [{range: 1 m}]}}"),
            "a sonar needs exactly one of 'range_std' and 'range_error'");
  EXPECT_EQ(mistake_in("{range_std: 2 mm, input: {csv: {file: a.csv, unit: deg}}}").substr(0, 6),
            "unit: ");
}

}  // namespace
}  // namespace ilss
