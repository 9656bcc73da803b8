#include "sensors/laser/simulate/laser_world.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "sensors/laser/laser_mount.h"

namespace ilss {
namespace {

/// Where the mount begins among the parameters.
constexpr std::size_t mount_parameter = 5;

}  // namespace

void LaserWorldOptions::declare(OptionVisitor& visit) {
  visit("scene", scene, "the scene's file; without one, rooms are generated");
  visit("scans_per_map", scans_per_map, "ticks in each generated room",
        {.minimum = 1, .maximum = 1e9});
  visit("beams", beams, "of a scan", {.minimum = 2, .maximum = 1e6});
  visit("field_of_view", field_of_view, "from first to last beam, the same to either side",
        {.unit = "rad", .minimum = 1e-6, .maximum = 2 * std::numbers::pi});
  visit("max_range", max_range, "a surface farther away gives no return",
        {.unit = "m", .minimum = 1e-3});
  visit("quantum", quantum, "step in which ranges are told", {.unit = "m", .minimum = 0});
  visit("beam_width", beam_width,
        "of each beam; one that straddles an edge gives a mixture of ranges",
        {.unit = "rad", .minimum = 0, .maximum = 0.2});
  visit("speed", speed, "of the robot, forward", {.unit = "m/s"});
  visit("turn_rate", turn_rate, "of the robot, to the right", {.unit = "rad/s"});
  visit("sweep_time", sweep_time, "from first to last beam, which is sent at the tick's time",
        {.unit = "s", .minimum = 0});
}

LaserSweep LaserWorldOptions::sweep() const {
  return {.beams = static_cast<std::size_t>(beams),
          .field_of_view = field_of_view,
          .max_range = max_range,
          .beam_width = beam_width,
          .speed = speed,
          .turn_rate = turn_rate,
          .duration = sweep_time};
}

LaserWorld::LaserWorld(const LaserWorldOptions& options)
    : options_(options), sweep_(options.sweep()) {
  if (options_.scene) set_scene(options_.scene->content);
}

void LaserWorld::set_scene(Scene scene) {
  scene_ = std::move(scene);
  caster_.emplace(*scene_);
}

Outcome<LaserStand> LaserWorld::enter(const Evaluation& evaluation) {
  const auto p = payload_of<LaserWorldParameters>(evaluation.parameters);
  for (const double deviation : {p.range_std, p.bearing_std})
    if (!(deviation >= 0 && std::isfinite(deviation)))
      return Fault{FaultKind::out_of_range,
                   fmt::format("range_std and bearing_std must not be below 0, got {}", deviation)};
  const ScenePose mount{p.mount_x, p.mount_z, p.mount_heading};
  if (options_.scene) {
    const ScenePose start{p.robot_x, p.robot_z, p.robot_heading};
    return LaserStand{drive(start, options_.speed, options_.turn_rate, seconds(evaluation.time)),
                      mount};
  }
  const std::int64_t first_in_map =
      evaluation.tick / options_.scans_per_map * options_.scans_per_map;
  if (const std::uint64_t room = derive_seed(evaluation.seed_at(first_in_map), "room");
      room != room_) {
    set_scene(generate_room(room));
    room_ = room;
  }
  const auto robot =
      draw_standpoint(*scene_, *caster_, sweep_, mount, derive_seed(evaluation.seed, "standpoint"));
  if (!robot)
    return Fault{FaultKind::degenerate,
                 "no place in the generated room shows pieces of countable size only"};
  return LaserStand{*robot, mount};
}

void LaserWorld::scan(const Evaluation& evaluation, const LaserStand& stand, bool noisy,
                      std::span<LaserBeam> scan, std::span<std::size_t> surfaces) const {
  const auto p = payload_of<LaserWorldParameters>(evaluation.parameters);
  const LaserErrors errors =
      noisy ? LaserErrors{p.range_std, p.bearing_std, options_.quantum} : LaserErrors{};
  simulate_scan(*caster_, sweep_, stand, errors, derive_seed(evaluation.seed, "noise"), scan,
                surfaces);
}

void LaserWorld::describe(const Evaluation& evaluation, Estimate& scan) const {
  const auto p = payload_of<LaserWorldParameters>(evaluation.parameters);
  assign<LaserScan>(scan, {.range_std = p.range_std,
                           .bearing_std = p.bearing_std,
                           .quantum = options_.quantum,
                           .max_range = options_.max_range});
  set_mount(evaluation.parameters, mount_parameter, scan);
}

}  // namespace ilss
