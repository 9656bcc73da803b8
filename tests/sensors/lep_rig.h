// A LEP sensor before a scene of known lines: scans as the modules give them, and the truth.
#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "sensors/lep/lep_ranging.h"
#include "sensors/lep/lep_sensor.h"
#include "sensors/range/line_fit.h"
#include "sensors/range/range_scan.h"

namespace ilss {

inline constexpr double degree = std::numbers::pi / 180;

/// A wall of a scene as the LEP's frame sees it.
inline InverseLine line_of(const ScenePose& base, const Wall& wall) {
  const ScenePoint from = to_frame(base, wall.from);
  const ScenePoint to = to_frame(base, wall.to);
  // The LEP's x is to the right, its z forward; m · p = 1 at both ends.
  const double determinant = from.z * to.x - to.z * from.x;
  return {(to.x - from.x) / determinant, (from.z - to.z) / determinant};
}

/// Two walls that meet in an edge `apex` metres in front of the head's axis at an interior angle:
/// convex ones recede from the edge, concave ones come nearer. First the left one.
inline Scene edge_scene(double apex, double interior_angle, bool convex = true) {
  const double half = interior_angle / 2;
  const double forward = (convex ? 1 : -1) * 2 * std::cos(half);
  const double side = 2 * std::sin(half);
  Scene scene;
  scene.walls = {{{apex, 0}, {apex + forward, -side}, 0.8, {}},
                 {{apex, 0}, {apex + forward, side}, 0.8, {}}};
  return scene;
}

/// Sensor and ranging with the shipped geometry and the head's axis at the world's origin.
struct LepRig {
  LepSensor::Options options;
  Estimate sensor_parameters = Estimate(descriptor<LepSensor::Parameters>());
  Estimate ranging_parameters = Estimate(descriptor<LepRanging::Parameters>());
  double head_rate = 0;  ///< rad/s, through the whole scan

  explicit LepRig(Scene scene) {
    options.scene.content = std::move(scene);
    set_mount(0.03, 0.05);
  }

  void set_mount(double x, double z) {
    sensor_parameters.value[4] = ranging_parameters.value[4] = x;
    sensor_parameters.value[5] = ranging_parameters.value[5] = z;
  }

  Output ranges(const Output& scan) const {
    Output output;
    output.estimate = Estimate(descriptor<RangeScan>(), "lep");
    LepRanging ranging;
    const Output* input = &scan;
    const Evaluation evaluation{.tick = 0, .parameters = ranging_parameters, .inputs = {&input, 1}};
    if (!ranging.evaluate(evaluation, output)) output.samples = {};
    return output;
  }

  /// A tick of a sensor: the last reading is taken at the tick's time.
  Outcome<> take(LepSensor& sensor, std::int64_t tick, std::uint64_t seed, Output& output) const {
    const double period = static_cast<double>(options.readings) / options.reading_rate;
    output.estimate = Estimate(descriptor<LepScan>(), "lep");
    const Evaluation evaluation{.tick = tick,
                                .time = time_at(period * static_cast<double>(tick + 1)),
                                .seed = derive_seed(seed, static_cast<std::uint64_t>(tick)),
                                .parameters = sensor_parameters,
                                .inputs = {},
                                .run_seed = seed};
    return sensor.evaluate(evaluation, output);
  }

  /// The image positions of one scan; no samples where there is no reading.
  Output images(std::uint64_t seed) const {
    LepSensor sensor(options);
    if (head_rate != 0) (void)sensor.command({"rotate_at", head_rate});
    Output output;
    if (!take(sensor, 0, seed, output)) output.samples = {};
    return output;
  }

  Output scan(std::uint64_t seed) const { return ranges(images(seed)); }
};

/// A line fit's NEES against the true line (2 dimensions).
inline double nees(const LineFit& fit, const InverseLine& truth) {
  const Eigen::Vector2d error(fit.line.x - truth.x, fit.line.z - truth.z);
  return error.dot(fit.covariance.llt().solve(error));
}

}  // namespace ilss
