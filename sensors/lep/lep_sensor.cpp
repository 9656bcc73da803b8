#include "sensors/lep/lep_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "framework/estimate/angle.h"
#include "framework/estimate/random.h"

namespace ilss {
namespace {

/// `pose` seen from `base`: x to the right, z forward, heading to the left.
struct RelativePose {
  double x, z, heading;
  RelativePose(const ScenePose& base, const ScenePose& pose) {
    const ScenePoint seen = to_frame(base, {pose.x, pose.z});
    x = seen.z;
    z = seen.x;
    heading = wrap_angle(base.heading - pose.heading);
  }
};

}  // namespace

std::vector<CommandDeclaration> LepSensor::commands() {
  return {quantity_command("rotate_to", "rad", "turns the head to an angle, positive to the left"),
          quantity_command("rotate_at", "rad/s", "turns the head at a rate, positive to the left")};
}

void LepSensor::Options::declare(OptionVisitor& visit) {
  visit("scene", scene, "the scene's file", {.required = true});
  visit("readings", readings, "how many readings a tick gives", {.minimum = 1, .maximum = 100000});
  visit("scan_readings", scan_readings, "readings from one side of the field to the other",
        {.minimum = 2, .maximum = 100000});
  visit("field_of_view", field_of_view, "from the first to the last reading of a scan",
        {.unit = "rad", .minimum = 0.01, .maximum = 120 * radians_per_degree});
  visit("reading_rate", reading_rate, "readings a second", {.unit = "1/s", .minimum = 1});
  visit("beam_width", beam.width, "of the laser, between its outermost rays",
        {.unit = "m", .minimum = 0, .maximum = 0.1});
  visit("beam_rays", beam.rays, "parallel rays that stand for the beam",
        {.minimum = 1, .maximum = 1000});
  visit("current_at_1m", beam.current_at_1m,
        "detector current of a surface of reflectivity 1 at 1 m", {.unit = "A", .minimum = 0});
  visit("bandwidth", bandwidth, "of the detector; without it, readings are independent",
        {.unit = "1/s", .minimum = 1});
  visit("saturation_current", saturation_current, "above it there is no reading",
        {.unit = "A", .minimum = 0});
  visit("head_angle", head_angle, "of the head at the start, positive to the left",
        {.unit = "rad", .minimum = -90 * radians_per_degree, .maximum = 90 * radians_per_degree});
  visit("head_step", drive.step, "what the head's angle is a multiple of after rotate_to",
        {.unit = "rad", .minimum = 1e-6});
  visit("speed", speed, "of the vehicle, forward", {.unit = "m/s"});
  visit("turn_rate", turn_rate, "of the vehicle, to the right", {.unit = "rad/s"});
  visit("frame", frame, "name of the frame of the head's axis, x to the right and z forward");
}

Interface LepSensor::interface(const Options& options) {
  return {.inputs = {},
          .output = &descriptor<LepScan>(),
          .frame = options.frame,
          .draws_readings = true};
}

LepSensor::LepSensor(const Options& options)
    : options_(options), head_(options.drive, options.head_angle) {
  // One pole at the bandwidth, sampled at the reading rate.
  if (!options_.bandwidth) return;
  const double decay = 2 * std::numbers::pi * *options_.bandwidth / options_.reading_rate;
  constexpr double nothing_left = 39;  // exp(-39) is below the last bit
  correlation_ = std::exp(-decay);
  remembered_ = static_cast<std::int64_t>(std::ceil(nothing_left / decay));
}

void LepSensor::reset() { head_ = HeadMotion(options_.drive, options_.head_angle); }

Outcome<> LepSensor::command(const Command& command) {
  const double* value = std::get_if<double>(&command.value);
  if (value == nullptr)
    return Fault{FaultKind::refused, "expected a quantity as value of " + command.name};
  if (command.name == "rotate_to") {
    if (!(std::abs(*value) <= options_.drive.stop))
      return Fault{
          FaultKind::refused,
          fmt::format("{:.6g} deg is beyond the head's stops at ±{:.6g} deg",
                      *value / radians_per_degree, options_.drive.stop / radians_per_degree)};
    head_.turn_to(*value, seconds(command.time));
    return {};
  }
  if (command.name == "rotate_at") {
    if (!(std::abs(*value) <= options_.drive.fastest))
      return Fault{
          FaultKind::refused,
          fmt::format("{:.6g} deg/s is faster than the drive's {:.6g} deg/s",
                      *value / radians_per_degree, options_.drive.fastest / radians_per_degree)};
    head_.turn_at(*value, seconds(command.time));
    return {};
  }
  return Module::command(command);
}

ScenePose LepSensor::vehicle(const Parameters<double>& parameters, double time) const {
  return drive({parameters.robot_x, parameters.robot_z, parameters.robot_heading}, options_.speed,
               options_.turn_rate, time);
}

std::int64_t LepSensor::place_in_scan(std::int64_t reading) const {
  return (reading % options_.scan_readings + options_.scan_readings) % options_.scan_readings;
}

template <typename DrawNoise>
Outcome<> LepSensor::scan(const Evaluation& evaluation, std::int64_t last, double end,
                          DrawNoise draw_noise, Output& output) {
  const auto p = payload_of<Parameters>(evaluation.parameters);
  if (!(p.focal_length > 0 && p.baseline > 0 && std::cos(p.vergence) > 1e-6 &&
        p.detector_length > 0 && p.noise_current >= 0))
    return Fault{FaultKind::out_of_range,
                 "focal_length, baseline and detector_length must be above 0, noise_current not "
                 "below it, vergence within ±90 deg"};
  LepBeamCaster caster({p.focal_length, p.baseline, p.vergence, p.lens_distance}, options_.beam);
  const Scene& scene = options_.scene.content;
  const double half_length = p.detector_length / 2;
  const double step = options_.field_of_view / static_cast<double>(options_.scan_readings - 1);
  // The low pass delays what changes steadily by this many readings.
  const double delay = correlation_ / (1 - correlation_);
  const double innovation = std::sqrt(1 - correlation_ * correlation_);
  const ScenePose standpoint = vehicle(p, end);
  const std::span<LepReading> readings =
      make_lep_readings(output, static_cast<std::size_t>(options_.readings));
  std::size_t count = 0;
  // What the low pass still holds of the readings before is made anew, so that a tick does not
  // depend on which was asked before it.
  const std::int64_t first = last - options_.readings + 1;
  const std::int64_t before = first - remembered_;
  double noise = draw_noise(before);
  for (std::int64_t i = before + 1; i < first; ++i)
    noise = correlation_ * noise + innovation * draw_noise(i);
  Signal memory;
  const std::int64_t first_in_scan = first - place_in_scan(first);
  for (std::int64_t i = std::max(before, first_in_scan); i <= last; ++i) {
    const std::int64_t in_scan = place_in_scan(i);
    const double time = end - static_cast<double>(last - i) / options_.reading_rate;
    const double scan_angle = -options_.field_of_view / 2 + step * static_cast<double>(in_scan);
    const double head = head_.angle(time);
    const ScenePose base = vehicle(p, time);
    const RelativePose moved(standpoint, base);
    const ScenePose head_pose{base.x, base.z, base.heading - head};
    const ScenePose projection = compose_poses(head_pose, {p.origin_z, p.origin_x, 0});
    const LepImage image =
        caster.cast(scene, projection, scan_angle + p.projected_vergence + delay * step);
    Signal signal{image.current, image.current * image.image_position};
    if (in_scan != 0) {
      signal.current += correlation_ * (memory.current - signal.current);
      signal.moment += correlation_ * (memory.moment - signal.moment);
    }
    memory = signal;
    if (i < first) continue;
    if (i > before) noise = correlation_ * noise + innovation * draw_noise(i);
    if (image.current <= 0 || signal.current > options_.saturation_current) continue;
    const double deviation = half_length * p.noise_current / signal.current;
    const double position = signal.moment / signal.current + deviation * noise;
    if (std::abs(position) > half_length) continue;
    readings[count++] = {time,           head,    scan_angle, position,     deviation,
                         signal.current, moved.x, moved.z,    moved.heading};
  }
  make_lep_readings(output, count);
  if (count == 0)
    return Fault{FaultKind::no_detection, "none of the tick's readings found a surface"};
  output.acquired = {time_at(readings.front().time), time_at(readings.back().time)};
  assign<LepScan>(output.estimate, {correlation_, options_.beam.width});
  return {};
}

Outcome<> LepSensor::evaluate(const Evaluation& evaluation, Output& output) {
  const std::int64_t last = (evaluation.tick + 1) * options_.readings - 1;
  const std::uint64_t seed = derive_seed(evaluation.run_seed, "reading");
  const auto draw_noise = [&](std::int64_t reading) {
    RandomBits random(derive_seed(seed, static_cast<std::uint64_t>(reading)));
    return draw_normal(random);
  };
  const double time = seconds(evaluation.time);
  Outcome<> outcome = scan(evaluation, last, time, draw_noise, output);
  head_.forget_before(time - static_cast<double>(remembered_) / options_.reading_rate);
  return outcome;
}

Outcome<> LepSensor::expect(const Evaluation& evaluation, const Output* operating_point,
                            Output& output) {
  if (operating_point != nullptr)
    return Fault{FaultKind::no_error_known,
                 "a scan cannot be given as an operating point; it follows from the scene"};
  return scan(
      evaluation, options_.readings - 1, seconds(evaluation.time), [](std::int64_t) { return 0.0; },
      output);
}

}  // namespace ilss
