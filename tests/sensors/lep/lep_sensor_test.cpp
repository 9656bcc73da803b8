// The simulated LEP sensor: head and vehicle in motion, readings left out, and the detector's
// noise.
#include "sensors/lep/lep_sensor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "framework/estimate/consistency.h"
#include "tests/sensors/lep_rig.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

Scene wall_ahead(double distance) {
  Scene scene;
  scene.walls = {{{distance, -9}, {distance, 9}, 0.8, {}}};
  return scene;
}

/// A sensor that takes one scan after another.
struct RunningSensor {
  explicit RunningSensor(const LepRig& of) : rig(of), sensor(of.options) {}

  std::span<const LepReading> next(std::uint64_t seed = 1) {
    outcome = rig.take(sensor, tick++, seed, output);
    if (!outcome) return {};
    return lep_readings_of(output);
  }
  Outcome<> command(const std::string& name, double value, double time) {
    return sensor.command({name, value, time_at(time)});
  }

  LepRig rig;
  LepSensor sensor;
  Output output;
  Outcome<> outcome;
  std::int64_t tick = 0;
};

LepRig noiseless(Scene scene) {
  LepRig rig(std::move(scene));
  rig.sensor_parameters.value[8] = 0;  // noise current
  return rig;
}

Scene all_around() {
  Scene scene;
  scene.walls = {
      {{1, -1}, {1, 1}, 0.8, {}}, {{1, 1}, {-1, 1}, 0.8, {}}, {{1, -1}, {-1, -1}, 0.8, {}}};
  return scene;
}

TEST(LepSensor, SweepsItsFieldFromLeftToRightAtItsRate) {
  RunningSensor run{LepRig(wall_ahead(1))};
  for (int scan = 0; scan < 2; ++scan) {
    const auto readings = run.next();
    ASSERT_EQ(readings.size(), 256u);
    EXPECT_NEAR(readings.front().scan_angle, -20 * degree, 1e-12);
    EXPECT_NEAR(readings.back().scan_angle, 20 * degree, 1e-12);
    for (std::size_t i = 0; i < readings.size(); ++i)
      EXPECT_NEAR(readings[i].time, (256 * scan + static_cast<double>(i) + 1) / 2500, 1e-12);
  }
}

TEST(LepSensor, SaysTheDetectorCurrentsErrorAndNotTheParameters) {
  LepRig rig(wall_ahead(1));
  rig.sensor_parameters.lineage.add({7, 0, persistent_tick}, 0, 1e-3);
  RunningSensor run{rig};
  for (const LepReading& r : run.next())
    EXPECT_NEAR(r.deviation, 0.005 * 36.2e-12 / r.current, 1e-15);
  EXPECT_EQ(run.output.estimate.lineage.size(), 0u) << "the parameters are the world's truth";
  EXPECT_EQ(payload_of<LepScan>(run.output.estimate).beam_width, 0.003);
}

TEST(LepSensor, TurnsItsHeadWhileItScans) {
  RunningSensor run{LepRig(all_around())};
  ASSERT_TRUE(run.command("rotate_to", 90 * degree, 0));
  std::vector<double> heads;
  for (int scan = 0; scan < 6; ++scan)
    for (const LepReading& r : run.next()) {
      EXPECT_NEAR(r.head, std::min(180 * degree * r.time, 90 * degree), 1e-12);
      heads.push_back(r.head);
    }
  ASSERT_GT(heads.size(), 1000u);
  EXPECT_LT(heads.front(), 0.1 * degree);
  EXPECT_NEAR(heads.back(), 90 * degree, 1e-12);
}

// Between two ticks, and while the head turns already.
TEST(LepSensor, FollowsACommandAtItsTime) {
  RunningSensor run{LepRig(all_around())};
  ASSERT_TRUE(run.command("rotate_at", 90 * degree, 0));
  run.next();
  ASSERT_TRUE(run.command("rotate_at", -45 * degree, 0.15));
  const auto readings = run.next();
  ASSERT_GT(readings.size(), 200u);
  for (const LepReading& r : readings) {
    const double angle =
        r.time < 0.15 ? 90 * degree * r.time : 90 * degree * 0.15 - 45 * degree * (r.time - 0.15);
    EXPECT_NEAR(r.head, angle, 1e-12) << r.time;
  }
}

TEST(LepSensor, StopsItsHeadAtTheStops) {
  RunningSensor run{LepRig(all_around())};
  ASSERT_TRUE(run.command("rotate_at", -180 * degree, 0));
  std::span<const LepReading> readings;
  for (int scan = 0; scan < 7; ++scan) readings = run.next();
  ASSERT_FALSE(readings.empty());
  EXPECT_NEAR(readings.back().head, -90 * degree, 1e-12);
}

TEST(LepSensor, RefusesWhatItsDriveCannotDo) {
  RunningSensor run{LepRig(all_around())};
  ASSERT_TRUE(run.command("rotate_to", 9 * degree, 0));
  for (const auto& [name, value] :
       {std::pair("rotate_to", 90.1 * degree), std::pair("rotate_to", -90.1 * degree),
        std::pair("rotate_at", 180.1 * degree), std::pair("rotate_at", -180.1 * degree),
        std::pair("rotate_to", std::nan("")), std::pair("rotate_at", std::nan("")),
        std::pair("jump", 0.0)})
    EXPECT_EQ(fault_of(run.command(name, value, 0)), "refused") << name << " " << value;
  EXPECT_EQ(fault_of(run.sensor.command({"rotate_to", std::string("left"), {}})), "refused");
  EXPECT_EQ(fault_of(run.command("rotate_to", 90.1 * degree, 0)), "refused");
  const auto readings = run.next();
  EXPECT_NEAR(readings.back().head, 9 * degree, 1e-12) << "a refused command changes nothing";
}

TEST(LepSensor, IsBackAtItsStartAfterAReset) {
  RunningSensor run{LepRig(all_around())};
  const std::vector<std::byte> before = (run.next(), run.output.samples.bytes);
  ASSERT_TRUE(run.command("rotate_to", 36 * degree, 0.1));
  run.next();
  run.sensor.reset();
  run.tick = 0;
  run.next();
  EXPECT_EQ(run.output.samples.bytes, before);
}

TEST(LepSensor, LeavesOutSaturatedReadings) {
  LepRig rig(wall_ahead(1));
  rig.options.saturation_current = 21.5e-9;  // 0.8 * 25.8 nA / range²; 0.95 m from the origin
  RunningSensor run{rig};
  const auto readings = run.next();
  ASSERT_FALSE(readings.empty());
  EXPECT_LT(readings.size(), 256u);
  for (const LepReading& r : readings) {
    EXPECT_LE(r.current, 21.5e-9);
    EXPECT_GT(std::abs(r.scan_angle), 10 * degree) << "the wall is nearest in the middle";
  }
  rig.options.saturation_current = 10e-9;
  RunningSensor blind{rig};
  blind.next();
  EXPECT_EQ(fault_of(blind.outcome), "no_detection");
}

TEST(LepSensor, LeavesOutImagesBesideThePhotodiode) {
  // 0.25 m from the scan's origin the image lies beyond the detector; it does not at 0.4 m.
  LepRig rig = noiseless(wall_ahead(0.3));
  rig.options.saturation_current = 1;
  RunningSensor near{rig};
  for (const LepReading& r : near.next()) {
    EXPECT_LE(std::abs(r.image_position), 0.005);
    EXPECT_NE(r.scan_angle, 0);
  }
  EXPECT_LT(lep_readings_of(near.output).size(), 256u);
  RunningSensor in_field{noiseless(wall_ahead(0.45))};
  EXPECT_EQ(in_field.next().size(), 256u);
}

TEST(LepSensor, LeavesOutWhatTheSceneHides) {
  Scene scene = wall_ahead(1);
  scene.walls.push_back({{0.6, -9}, {0.6, 0}, 0.8, {}});  // a step: the lens is to the right
  RunningSensor right_open{noiseless(scene)};
  EXPECT_EQ(right_open.next().size(), 256u) << "the lens looks past the nearer wall's end";
  scene.walls.back() = {{0.6, 0}, {0.6, 9}, 0.8, {}};
  RunningSensor right_closed{noiseless(scene)};
  const auto readings = right_closed.next();
  ASSERT_GT(readings.size(), 200u);
  ASSERT_LT(readings.size(), 250u);
  std::size_t gaps = 0;
  for (std::size_t i = 1; i < readings.size(); ++i)
    gaps += readings[i].scan_angle - readings[i - 1].scan_angle > 0.004 ? 1 : 0;
  EXPECT_EQ(gaps, 1u) << "one missing part";
}

TEST(LepSensor, DetectsNothingInAnEmptyDirection) {
  LepRig rig(wall_ahead(-1));
  RunningSensor run{rig};
  run.next();
  EXPECT_EQ(fault_of(run.outcome), "no_detection");
}

/// The noise of each reading in its own standard deviations, scan after scan.
std::vector<std::vector<double>> noise_of_scans(const LepRig& rig, int scans, std::uint64_t seed) {
  LepRig still = rig;
  still.sensor_parameters.value[8] = 0;
  RunningSensor noisy{rig};
  RunningSensor exact{still};
  std::vector<std::vector<double>> noise;
  for (int scan = 0; scan < scans; ++scan) {
    const auto expected = exact.next();
    const auto measured = noisy.next(seed);
    EXPECT_EQ(measured.size(), expected.size());
    noise.emplace_back();
    for (std::size_t i = 0; i < measured.size(); ++i)
      noise.back().push_back((measured[i].image_position - expected[i].image_position) /
                             measured[i].deviation);
  }
  return noise;
}

double variance_of(const std::vector<std::vector<double>>& noise, std::size_t lag = 0) {
  double sum = 0;
  double count = 0;
  for (const std::vector<double>& scan : noise)
    for (std::size_t i = lag; i < scan.size(); ++i) {
      sum += scan[i] * scan[i - lag];
      count += 1;
    }
  return sum / count;
}

TEST(LepSensor, IsAsNoisyAsItSays) {
  const std::uint64_t seed = 61;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  const auto noise = noise_of_scans(LepRig(edge_scene(1.2, 120 * degree)), 80, seed);
  constexpr double count = 80 * 256;
  EXPECT_TRUE(chi_square_interval(count, 0.99).contains(variance_of(noise) * count))
      << variance_of(noise);
  for (const std::size_t lag : {1, 2, 7})
    EXPECT_NEAR(variance_of(noise, lag), 0, 2.6 / std::sqrt(count)) << "lag " << lag;
}

// One pole at 1 kHz, sampled at 2.5 kHz: exp(-2 pi 1000 / 2500) = 0.081.
TEST(LepSensor, CorrelatesNeighboursByItsBandwidthAndSaysSo) {
  const std::uint64_t seed = 62;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  LepRig rig(edge_scene(1.2, 120 * degree));
  rig.options.bandwidth = 1000;
  const auto noise = noise_of_scans(rig, 200, seed);
  constexpr double count = 200 * 256;
  const double correlation = std::exp(-0.8 * std::numbers::pi);
  EXPECT_NEAR(variance_of(noise), 1, 2.6 * std::sqrt(2 / count));
  EXPECT_NEAR(variance_of(noise, 1), correlation, 2.6 / std::sqrt(count));
  EXPECT_NEAR(variance_of(noise, 2), correlation * correlation, 2.6 / std::sqrt(count));
  const Output scan = rig.images(1);
  EXPECT_NEAR(payload_of<LepScan>(scan.estimate).noise_correlation, 0.081, 5e-4);
}

TEST(LepSensor, BandwidthHardlyShiftsSteadyImages) {
  LepRig rig = noiseless(edge_scene(1.2, 120 * degree));
  const Output sharp = rig.images(1);
  rig.options.bandwidth = 1000;
  const Output slow = rig.images(1);
  const auto a = lep_readings_of(sharp);
  const auto b = lep_readings_of(slow);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 1; i < a.size(); ++i)
    EXPECT_NEAR((b[i].image_position - a[i].image_position) / a[i].current * 16e-9, 0, 2e-6) << i;
}

TEST(LepSensor, GivesTheSameScanForTheSameSeed) {
  LepRig rig(edge_scene(1, 120 * degree));
  EXPECT_EQ(rig.images(3).samples.bytes, rig.images(3).samples.bytes);
  EXPECT_NE(rig.images(3).samples.bytes, rig.images(4).samples.bytes);
}

TEST(LepSensor, DoesNotDependOnWhichTickIsAskedFirst) {
  for (const std::int64_t readings : {256, 100, 1}) {
    LepRig rig(edge_scene(1, 120 * degree));
    rig.options.bandwidth = 300;
    rig.options.readings = readings;
    rig.options.turn_rate = 0.3;
    RunningSensor in_order{rig};
    std::vector<std::vector<std::byte>> ticks;
    for (int tick = 0; tick < 9; ++tick) {
      in_order.next();
      ticks.push_back(in_order.output.samples.bytes);
    }
    RunningSensor other{rig};
    for (const std::int64_t tick : {7, 3, 8, 3, 0}) {
      other.tick = tick;
      other.next();
      EXPECT_EQ(other.output.samples.bytes, ticks[static_cast<std::size_t>(tick)])
          << "tick " << tick << " of " << readings << " readings";
    }
  }
}

TEST(LepSensor, NoiseGoesOnFromTickToTick) {
  // Of single readings as of those of one scan.
  LepRig rig(edge_scene(1.2, 120 * degree));
  rig.options.bandwidth = 1000;
  rig.options.readings = 1;
  double sum = 0;
  constexpr int count = 20000;
  const auto noise = noise_of_scans(rig, count, 63);
  for (int i = 1; i < count; ++i)
    sum += noise[static_cast<std::size_t>(i)].at(0) * noise[static_cast<std::size_t>(i) - 1].at(0);
  EXPECT_NEAR(sum / count, std::exp(-0.8 * std::numbers::pi), 2.6 / std::sqrt(count));
}

TEST(LepSensor, SingleReadingsAreThoseOfAScan) {
  for (const bool slow : {false, true}) {
    LepRig whole = noiseless(edge_scene(0.8, 120 * degree));
    whole.options.turn_rate = 0.3;
    if (slow) whole.options.bandwidth = 1000;
    LepRig single = whole;
    single.options.readings = 1;
    RunningSensor scans{whole};
    RunningSensor readings{single};
    ASSERT_TRUE(scans.command("rotate_at", 45 * degree, 0));
    ASSERT_TRUE(readings.command("rotate_at", 45 * degree, 0));
    for (int scan = 0; scan < 2; ++scan)
      for (const LepReading& of_scan : scans.next()) {
        const auto alone = readings.next();
        ASSERT_EQ(alone.size(), 1u);
        EXPECT_NEAR(alone[0].time, of_scan.time, 1e-12);
        EXPECT_NEAR(alone[0].head, of_scan.head, 1e-12);
        EXPECT_EQ(alone[0].scan_angle, of_scan.scan_angle);
        EXPECT_NEAR(alone[0].image_position, of_scan.image_position, 1e-12);
        EXPECT_NEAR(alone[0].current / of_scan.current, 1, 1e-9);
        EXPECT_EQ(alone[0].vehicle_x, 0) << "seen from where the vehicle is at its last reading";
      }
  }
}

/// How far the ranged readings of a scan are from a wall as it is seen at the scan's end (m).
double largest_distance(const LepRig& rig, RunningSensor& run, const Wall& wall) {
  const double end = static_cast<double>(run.tick + 1) * 256 / 2500;
  run.next();
  const auto truth = payload_of<LepSensor::Parameters>(rig.sensor_parameters);
  const InverseLine m = line_of(run.sensor.vehicle(truth, end), wall);
  double largest = run.outcome ? 0 : INFINITY;
  const Output scan = rig.ranges(run.output);
  for (const RangeReading& r : readings_of(scan)) {
    const double x = r.origin_x + std::cos(r.bearing) / r.inverse_range;
    const double z = r.origin_z + std::sin(r.bearing) / r.inverse_range;
    largest = std::max(largest, std::abs(m.x * x + m.z * z - 1) / std::hypot(m.x, m.z));
  }
  return largest;
}

TEST(LepSensor, MovingVehicleAndHeadSeeAStandingWallWhereItIsAtTheScansEnd) {
  for (const double turn_rate : {0.0, 0.8, -1.2})
    for (const double speed : {0.0, 0.5, -0.3}) {
      const Wall wall{{1.3, -9}, {1.6, 9}, 0.8, {}};
      Scene scene;
      scene.walls = {wall};
      LepRig rig = noiseless(scene);
      rig.options.beam.rays = 1;
      rig.options.speed = speed;
      rig.options.turn_rate = turn_rate;
      rig.sensor_parameters.value[6] = rig.ranging_parameters.value[6] = 3 * degree;
      rig.sensor_parameters.value[9] = 0.1;
      rig.sensor_parameters.value[10] = -0.2;
      rig.sensor_parameters.value[11] = 0.15;
      RunningSensor run{rig};
      ASSERT_TRUE(run.command("rotate_at", 20 * degree, 0.05));
      for (int scan = 0; scan < 3; ++scan)
        EXPECT_LT(largest_distance(rig, run, wall), 1e-9)
            << "turn rate " << turn_rate << ", speed " << speed << ", scan " << scan;
    }
}

TEST(LepSensor, VehicleRunsAlongACircle) {
  LepSensor::Options options;
  options.speed = 0.5;
  options.turn_rate = 0.25;
  const LepSensor sensor(options);
  LepSensor::Parameters<double> parameters{};
  const ScenePose quarter = sensor.vehicle(parameters, 2 * std::numbers::pi);
  EXPECT_NEAR(quarter.x, 2, 1e-12);
  EXPECT_NEAR(quarter.z, 2, 1e-12);
  EXPECT_NEAR(quarter.heading, 90 * degree, 1e-12);
}

TEST(LepSensor, ExpectsAScanWithoutNoiseButWithItsError) {
  LepRig rig(edge_scene(1, 120 * degree));
  LepSensor sensor(rig.options);
  Output expected;
  expected.estimate = Estimate(descriptor<LepScan>(), "lep");
  const Evaluation evaluation{
      .time = time_at(0.1024), .parameters = rig.sensor_parameters, .inputs = {}};
  ASSERT_TRUE(sensor.expect(evaluation, nullptr, expected));
  LepRig still = noiseless(edge_scene(1, 120 * degree));
  const Output exact = still.images(1);
  const auto a = lep_readings_of(expected);
  const auto b = lep_readings_of(exact);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].image_position, b[i].image_position);
    EXPECT_GT(a[i].deviation, 0);
  }
  EXPECT_EQ(fault_of(sensor.expect(evaluation, &exact, expected)), "no_error_known");
}

}  // namespace
}  // namespace ilss
