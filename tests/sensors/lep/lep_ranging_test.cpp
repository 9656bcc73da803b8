// From image positions to ranges: derivatives, what passes of the calibration, and faults.
#include "sensors/lep/lep_ranging.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "framework/estimate/differentiate.h"
#include "tests/sensors/lep_rig.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

Estimate calibration() { return Estimate(descriptor<LepRanging::Parameters>()); }

ModuleRun range(const Output& images, const Estimate& parameters) {
  Tick tick;
  tick.parameters = parameters;
  tick.inputs = {&images};
  LepRanging ranging;
  ModuleRun result;
  result.output.estimate = Estimate(descriptor<RangeScan>(), "lep");
  result.outcome = ranging.evaluate(tick.evaluation(), result.output);
  return result;
}

Output images_of(const std::vector<LepReading>& readings) {
  Output output;
  output.estimate = Estimate(descriptor<LepScan>(), "lep");
  const auto room = make_lep_readings(output, readings.size());
  std::copy(readings.begin(), readings.end(), room.begin());
  return output;
}

// "Each Jacobian is held against autodiff", over the whole field and around the calibration.
TEST(LepRanging, DerivativesAreThoseOfTheGeometryByAutomaticDifferentiation) {
  constexpr unsigned seed = 71;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int run = 0; run < 2000; ++run) {
    Estimate parameters = calibration();
    for (std::size_t i = 0; i < 4; ++i) parameters.value[i] *= uniform(0.9, 1.1);
    const auto& v = parameters.value;
    const double theta = uniform(-20, 20) * degree;
    const double p =
        LepRay<double>({v[0], v[1], v[2], v[3]}, theta).image_position(1 / uniform(0.4, 2.5));
    const auto result =
        range(images_of({{.scan_angle = theta, .image_position = p, .deviation = 1}}), parameters);
    ASSERT_TRUE(result.outcome);
    using T = Dual<6>;
    const LepGeometry<T> geometry{T(v[0], 0), T(v[1], 1), T(v[2], 2), T(v[3], 3)};
    const T u = LepRay<T>(geometry, T(theta, 5)).inverse_range(T(p, 4));
    const RangeReading& reading = readings_of(result.output)[0];
    const auto expect = [&](double value, double truth, const char* of) {
      ASSERT_NEAR(value, truth, 1e-10 * std::max(1.0, std::abs(truth))) << of << ", run " << run;
    };
    expect(reading.inverse_range, u.a, "u");
    expect(reading.deviation, u.v[4], "du/dp");
    expect(reading.sensitivity[0], u.v[0] * v[0], "relative f");
    expect(reading.sensitivity[1], u.v[1] * v[1], "relative d");
    expect(reading.sensitivity[2], u.v[2], "gamma");
    expect(reading.sensitivity[3], u.v[3] * v[3], "relative s");
    expect(reading.sensitivity[4], u.v[5], "projected vergence");
  }
}

TEST(LepRanging, PutsEachReadingOnItsRayInTheHeadsFrame) {
  Estimate parameters = calibration();
  parameters.value[4] = 0.03;
  parameters.value[5] = 0.05;
  parameters.value[6] = 2 * degree;
  const double p = LepRay<double>({}, (10 + 2) * degree).image_position(1 / 1.5);
  const auto result = range(images_of({{.time = 0.7,
                                        .head = 25 * degree,
                                        .scan_angle = 10 * degree,
                                        .image_position = p,
                                        .deviation = 1e-6,
                                        .vehicle_x = 0.2,
                                        .vehicle_z = -0.1,
                                        .vehicle_heading = 5 * degree}}),
                            parameters);
  ASSERT_TRUE(result.outcome);
  const RangeReading& r = readings_of(result.output)[0];
  EXPECT_EQ(r.time, 0.7);
  EXPECT_NEAR(r.head, 30 * degree, 1e-12);
  // x is to the right: turned to the left, the mount's forward part moves to the left.
  EXPECT_NEAR(r.origin_x, 0.2 + std::cos(30 * degree) * 0.03 - 0.05 * std::sin(30 * degree), 1e-12);
  EXPECT_NEAR(r.origin_z, -0.1 + 0.03 * std::sin(30 * degree) + 0.05 * std::cos(30 * degree),
              1e-12);
  EXPECT_NEAR(r.bearing, (90 - (10 + 2) + 30) * degree, 1e-12);
  EXPECT_NEAR(1 / r.inverse_range, 1.5, 1e-12);
}

TEST(LepRanging, PassesTheNoisesCorrelationAndTheBeamsWidth) {
  Output images = images_of({{.deviation = 1e-6}});
  images.estimate.value = {0.08, 0.004};
  const auto scan = payload_of<RangeScan>(range(images, calibration()).output.estimate);
  EXPECT_EQ(scan.noise_correlation, 0.08);
  EXPECT_EQ(scan.beam_width, 0.004);
}

// A reading's error by a constant, through the shared errors, is what a changed constant changes.
TEST(LepRanging, CalibrationsErrorsPassIntoEveryReading) {
  Estimate parameters = calibration();
  parameters.value[4] = 0.03;
  parameters.value[5] = 0.05;
  const Source source{9, 0, persistent_tick};
  for (std::size_t i = 0; i < 7; ++i) {
    Estimate uncertain = parameters;
    const double std = 1e-6;
    uncertain.lineage.add(source, i, std);
    Output images = images_of({{.head = 0.3,
                                .scan_angle = 0.2,
                                .image_position = 0.001,
                                .deviation = 1e-6,
                                .vehicle_heading = 0.1}});
    const auto result = range(images, uncertain);
    ASSERT_TRUE(result.outcome);
    const Lineage& lineage = result.output.estimate.lineage;
    ASSERT_EQ(lineage.size(), 1u);
    EXPECT_EQ(lineage.sources()[0], source);
    Estimate changed = parameters;
    changed.value[i] += std;
    const auto shifted = range(images, changed);
    const RangeReading& r = readings_of(result.output)[0];
    const RangeReading& s = readings_of(shifted.output)[0];
    double change = 0;
    for (std::size_t k = 0; k < shared_range_errors; ++k)
      change += r.sensitivity[k] * lineage.column(0)[3 + k];
    EXPECT_NEAR(s.inverse_range - r.inverse_range, change, 1e-4 * std::abs(change) + 1e-14)
        << "parameter " << i;
    const double mx = lineage.column(0)[0];
    const double mz = lineage.column(0)[1];
    EXPECT_NEAR(s.origin_x - r.origin_x, std::cos(0.4) * mx - std::sin(0.4) * mz, 1e-12);
    EXPECT_NEAR(s.origin_z - r.origin_z, std::sin(0.4) * mx + std::cos(0.4) * mz, 1e-12);
    EXPECT_NEAR(s.bearing - r.bearing, lineage.column(0)[2], 1e-12);
  }
}

TEST(LepRanging, LeavesOutImagesThatNoRangeGives) {
  const double far_image = -0.05 * std::tan(LepGeometry<double>{}.vergence);
  const auto result = range(images_of({{.image_position = far_image - 1e-4, .deviation = 1e-6},
                                       {.time = 2, .image_position = 0.001, .deviation = 1e-6},
                                       {.image_position = 0.2, .deviation = 1e-6}}),
                            calibration());
  ASSERT_TRUE(result.outcome);
  ASSERT_EQ(readings_of(result.output).size(), 1u);
  EXPECT_EQ(readings_of(result.output)[0].time, 2);
  EXPECT_EQ(fault_of(range(images_of({{.image_position = far_image - 1e-4, .deviation = 1e-6}}),
                           calibration())
                         .outcome),
            "out_of_range");
}

TEST(LepRanging, RefusesACalibrationThatIsNoGeometry) {
  const Output images = images_of({{.image_position = 0.001, .deviation = 1e-6}});
  for (const auto& [parameter, value] :
       {std::pair(0, 0.0), std::pair(0, -0.05), std::pair(1, 0.0), std::pair(1, -0.1),
        std::pair(2, 91 * degree), std::pair(0, std::nan("")), std::pair(2, std::nan(""))}) {
    Estimate parameters = calibration();
    parameters.value[static_cast<std::size_t>(parameter)] = value;
    EXPECT_EQ(fault_of(range(images, parameters).outcome), "out_of_range")
        << parameter << " " << value;
  }
  Estimate in_a_point = calibration();
  in_a_point.value[3] = 0;
  EXPECT_TRUE(range(images, in_a_point).outcome) << "a lens in its centre of turning is one";
}

}  // namespace
}  // namespace ilss
