// The detector: positions from currents, and the error that goes with them.
#include "sensors/lep/lep_detector.h"

#include <gtest/gtest.h>

#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

Tick tick_of(const Output& currents, double noise_deviation = 0) {
  Tick tick;
  tick.parameters = Estimate(descriptor<LepDetector::Parameters>());
  if (noise_deviation > 0)
    tick.parameters.lineage.add({50, 0, persistent_tick}, 1, noise_deviation);
  tick.inputs = {&currents};
  return tick;
}

std::string fault_at(double current_1, double current_2) {
  LepDetector detector;
  const Output currents = output_of<DetectorCurrents>({current_1, current_2});
  return fault_of(run(detector, tick_of(currents)).outcome);
}

TEST(LepDetector, FindsThePositionByEquation1) {
  LepDetector detector;
  const Output currents = output_of<DetectorCurrents>({30e-9, 18e-9});
  const ModuleRun result = run(detector, tick_of(currents));
  ASSERT_TRUE(result.outcome);
  EXPECT_DOUBLE_EQ(result.output.estimate.value[0], 12.0 / 48 * 5e-3);
  EXPECT_DOUBLE_EQ(result.output.estimate.value[1], 48e-9);
}

TEST(LepDetector, StatesTheDeviationOfEquation2WithTheNoiseCurrentsOwn) {
  LepDetector detector;
  const Output currents = output_of<DetectorCurrents>({30e-9, 18e-9});
  const double known =
      run(detector, tick_of(currents)).output.estimate.lineage.standard_deviation(0);
  EXPECT_DOUBLE_EQ(known, 5e-3 * lep_noise_current / 48e-9);
  const ModuleRun doubtful = run(detector, tick_of(currents, 0.75 * lep_noise_current));
  EXPECT_NEAR(doubtful.output.estimate.lineage.standard_deviation(0), 1.25 * known, 1e-12 * known);
}

TEST(LepDetector, DrawsItsErrorAnewEachTick) {
  LepDetector detector;
  const Output currents = output_of<DetectorCurrents>({30e-9, 18e-9});
  Tick tick = tick_of(currents);
  const ModuleRun first = run(detector, tick);
  tick.tick = 1;
  const ModuleRun second = run(detector, tick);
  EXPECT_EQ(cross_covariance(first.output.estimate.lineage, second.output.estimate.lineage)(0, 0),
            0);
}

TEST(LepDetector, PassesOnErrorsOfCurrentsAndLength) {
  LepDetector detector;
  const Output currents = output_of<DetectorCurrents>({30e-9, 18e-9}, {1e-10, 2e-10});
  Tick tick = tick_of(currents);
  tick.parameters.value[1] = 0;  // no noise of its own
  tick.parameters.lineage.add({60, 0, persistent_tick}, 0, 1e-5);
  const ModuleRun result = run(detector, tick);
  const Eigen::MatrixXd covariance = result.output.estimate.lineage.covariance();
  const auto position = [](double length, double i1, double i2) {
    return length / 2 * (i1 - i2) / (i1 + i2);
  };
  const double by_1 = (position(0.01, 30.001e-9, 18e-9) - position(0.01, 29.999e-9, 18e-9)) / 2e-12;
  const double by_2 = (position(0.01, 30e-9, 18.001e-9) - position(0.01, 30e-9, 17.999e-9)) / 2e-12;
  const double by_length = position(1, 30e-9, 18e-9);
  const double variance =
      std::pow(by_1 * 1e-10, 2) + std::pow(by_2 * 2e-10, 2) + std::pow(by_length * 1e-5, 2);
  EXPECT_NEAR(covariance(0, 0) / variance, 1, 1e-6);
  EXPECT_NEAR(covariance(1, 1), 5e-20, 1e-26);
  EXPECT_NEAR(covariance(0, 1) / (by_1 * 1e-20 + by_2 * 4e-20), 1, 1e-6);
}

TEST(LepDetector, RefusesCurrentsThatAreNoImage) {
  EXPECT_EQ(fault_at(0, 0), "out_of_range");
  EXPECT_EQ(fault_at(-2e-9, 1e-9), "out_of_range");
  EXPECT_EQ(fault_at(5e-9, -1e-9), "out_of_range");
  EXPECT_EQ(fault_at(std::nan(""), 1e-9), "out_of_range");
  EXPECT_EQ(fault_at(5e-9, 0), "output");  // the very end of the detector
}

TEST(LepDetector, ExpectsTheErrorOfACurrentThatIsGiven) {
  LepDetector detector;
  const Output currents = output_of<DetectorCurrents>({30e-9, 18e-9});
  const Tick tick = tick_of(currents);
  Output expected;
  Output point = output_of<ImagePosition>({1e-3, 10e-9});
  ASSERT_TRUE(detector.expect(tick.evaluation(), &point, expected));
  EXPECT_DOUBLE_EQ(expected.estimate.lineage.standard_deviation(0),
                   5e-3 * lep_noise_current / 10e-9);
  point.estimate.value[1] = std::nan("");
  EXPECT_EQ(fault_of(detector.expect(tick.evaluation(), &point, expected)), "no_error_known");
}

}  // namespace
}  // namespace ilss
