// Ranges from image positions: geometry, derivatives, faults, and the errors of the paper's table.
#include "sensors/lep/lep_triangulation.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "framework/estimate/consistency.h"
#include "tests/sensors/lep/pears_table2.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;
using Triangulation = FunctionModule<LepTriangulation>;

Triangulation make_module() { return Triangulation(LepTriangulation({})); }

Tick tick_of(const Output& image, double scan_angle) {
  Tick tick;
  tick.parameters = Estimate(descriptor<LepTriangulation::Parameters>());
  tick.parameters.value[4] = scan_angle;
  tick.inputs = {&image};
  return tick;
}

double position_of(double scan_angle, double z) {
  return LepRay<double>(LepGeometry<double>(), scan_angle).image_position(std::cos(scan_angle) / z);
}

/// What detector and triangulation state of a reading of z (m) ahead at a detector current (A).
Output point_ahead(double z, double current, double noise_current) {
  const double share = position_of(0, z) / (lep_detector_length / 2);
  const Output currents =
      output_of<DetectorCurrents>({current / 2 * (1 + share), current / 2 * (1 - share)});
  Tick tick;
  tick.parameters = Estimate(descriptor<LepDetector::Parameters>());
  tick.parameters.value[1] = noise_current;
  tick.inputs = {&currents};
  LepDetector detector;
  const ModuleRun image = run(detector, tick);
  Triangulation triangulation = make_module();
  return run(triangulation, tick_of(image.output, 0)).output;
}

TEST(LepTriangulation, FindsThePointThatGivesTheImage) {
  Triangulation module = make_module();
  for (const double theta : {-20 * degree, 0.0, 11 * degree, 20 * degree})
    for (const double z : {0.4, 0.69, 1.3, 2.5}) {
      const Output image = output_of<ImagePosition>({position_of(theta, z), 0});
      const ModuleRun result = run(module, tick_of(image, theta));
      ASSERT_TRUE(result.outcome);
      EXPECT_NEAR(result.output.estimate.value[0], z / std::cos(theta), 1e-12);
      EXPECT_NEAR(result.output.estimate.value[1], z * std::tan(theta), 1e-12);
      EXPECT_NEAR(result.output.estimate.value[2], z, 1e-12);
    }
}

TEST(LepTriangulation, DerivativesAgreeWithDifferences) {
  const Triangulation module = make_module();
  Triangulation evaluated = make_module();
  for (const double theta : {-18 * degree, 0.0, 15 * degree})
    for (const double z : {0.45, 0.69, 2.3}) {
      Output image = output_of<ImagePosition>({position_of(theta, z), 0});
      Tick tick = tick_of(image, theta);
      const auto exact = module.differentiate(tick.evaluation());
      ASSERT_TRUE(exact);
      for (std::size_t column = 0; column < 6; ++column) {
        double& variable = column < 5 ? tick.parameters.value[column] : image.estimate.value[0];
        const double before = variable;
        constexpr double step = 1e-7;
        variable = before + step;
        const ModuleRun above = run(evaluated, tick);
        variable = before - step;
        const ModuleRun below = run(evaluated, tick);
        variable = before;
        for (std::size_t row = 0; row < 3; ++row) {
          const double slope =
              (above.output.estimate.value[row] - below.output.estimate.value[row]) / (2 * step);
          EXPECT_NEAR(exact->derivative(row, column), slope, 1e-5 * (1 + std::abs(slope)))
              << "component " << row << " by argument " << column;
        }
      }
    }
}

TEST(LepTriangulation, AnErrorOfTheImageMovesThePointAlongItsRay) {
  Triangulation module = make_module();
  const double theta = 15 * degree;
  const Output image = output_of<ImagePosition>({position_of(theta, 1.5), 0}, {5e-6});
  const Lineage& lineage = run(module, tick_of(image, theta)).output.estimate.lineage;
  ASSERT_EQ(lineage.size(), 1u);
  const auto column = lineage.column(0);
  EXPECT_NEAR(column[1] / column[0], std::sin(theta), 1e-12);
  EXPECT_NEAR(column[2] / column[0], std::cos(theta), 1e-12);
}

TEST(LepTriangulation, RefusesImagesThatNoPointGives) {
  Triangulation module = make_module();
  const LepRay<double> ray(LepGeometry<double>(), 0.0);
  const auto fault_at = [&](double position) {
    const Output image = output_of<ImagePosition>({position, 0});
    return fault_of(run(module, tick_of(image, 0)).outcome);
  };
  const double at_infinity = -ray.focal_tangent;
  EXPECT_EQ(fault_at(at_infinity + 1e-9), "output");
  EXPECT_EQ(fault_at(at_infinity), "out_of_range");
  EXPECT_EQ(fault_at(at_infinity - 1e-6), "out_of_range");
  const double at_zero_range = -ray.focal_length * ray.b / ray.a;
  EXPECT_EQ(fault_at(at_zero_range + 1e-6), "out_of_range");
  EXPECT_EQ(fault_at(std::nan("")), "out_of_range");
}

TEST(LepTriangulation, RefusesImpossibleSensors) {
  Triangulation module = make_module();
  const Output image = output_of<ImagePosition>({0, 0});
  const auto fault_with = [&](std::size_t parameter, double value) {
    Tick tick = tick_of(image, 0);
    tick.parameters.value[parameter] = value;
    return fault_of(run(module, tick).outcome);
  };
  EXPECT_EQ(fault_with(0, 0), "out_of_range");
  EXPECT_EQ(fault_with(0, -0.05), "out_of_range");
  EXPECT_EQ(fault_with(2, 91 * degree), "out_of_range");
  EXPECT_EQ(fault_with(4, -95 * degree), "out_of_range");
  EXPECT_EQ(fault_with(4, std::nan("")), "out_of_range");
}

TEST(LepTriangulation, PredictsTheRangeErrorsOfThePapersTable) {
  const auto noise = fit_noise_current(pears_noise(), lep_detector_length);
  ASSERT_TRUE(noise);
  double ratios = 0;
  for (const PearsRow& row : pears_table2()) {
    const Output point = point_ahead(row.range, row.noise.current, noise->noise_current);
    const double ratio = point.estimate.lineage.standard_deviation(0) / row.range_deviation;
    EXPECT_NEAR(ratio, 1, 0.25) << row.range << " m";
    ratios += ratio / 8;
  }
  EXPECT_NEAR(ratios, 1, 0.05);
}

TEST(LepTriangulation, AThousandReadingsScatterAsPredicted) {
  const std::uint32_t seed = 3;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  constexpr int readings = 1000;
  for (const PearsRow& row : pears_table2()) {
    const Output predicted = point_ahead(row.range, row.noise.current, lep_noise_current);
    std::normal_distribution<double> noise(
        0, image_position_deviation(lep_detector_length, lep_noise_current, row.noise.current));
    Triangulation module = make_module();
    double squares = 0;
    for (int i = 0; i < readings; ++i) {
      const Output image = output_of<ImagePosition>({position_of(0, row.range) + noise(random), 0});
      const ModuleRun result = run(module, tick_of(image, 0));
      ASSERT_TRUE(result.outcome);
      squares += std::pow(result.output.estimate.value[0] - row.range, 2);
    }
    const Interval bounds = chi_square_interval(readings, 0.999);
    EXPECT_TRUE(bounds.contains(squares / predicted.estimate.lineage.variance(0)))
        << row.range << " m: " << squares / predicted.estimate.lineage.variance(0);
  }
}

}  // namespace
}  // namespace ilss
