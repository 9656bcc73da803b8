// What a simulated laser scans, tick by tick: a given scene, or rooms that are generated.
#pragma once

#include <memory>
#include <optional>

#include "framework/module/module_type.h"
#include "sensors/laser/simulate/generated_room.h"
#include "sensors/laser/simulate/laser_simulation.h"

namespace ilss {

/// What `laser_scene` and its truth, `laser_scene_features`, are told alike.
struct LaserWorldOptions {
  std::optional<FileOf<Scene>> scene;
  std::int64_t scans_per_map = 5;
  std::int64_t beams = 360;
  double field_of_view = LaserSweep{}.field_of_view;
  double max_range = LaserSweep{}.max_range;
  double quantum = 0;
  double beam_width = 0;
  double speed = 0;
  double turn_rate = 0;
  double sweep_time = 0;
  void declare(OptionVisitor& visit);
  LaserSweep sweep() const;
};

/// Their quantities.
template <typename T>
struct LaserWorldParameters {
  T range_std, bearing_std, robot_x, robot_z, robot_heading, mount_x, mount_z, mount_heading;
  static constexpr std::string_view name = "laser_scene_parameters";
  static constexpr auto fields =
      Fields{{"range_std", "m", "sd of a range's noise", 0.005},
             {"bearing_std", "rad", "sd of a beam's direction", 0.0017453292519943296},
             {"robot.x", "m", "where the robot starts in the scene's file", 0},
             {"robot.z", "m", "where the robot starts in the scene's file", 0},
             {"robot.heading", "rad", "where it looks at first, positive to the right", 0,
              Geometry::circular},
             {"mount.x", "m", "the laser's place, forward of the robot's origin", 0},
             {"mount.z", "m", "the laser's place, to the right", 0},
             {"mount.heading", "rad", "where the laser looks, positive to the right", 0,
              Geometry::circular}};
};

/// The world that a laser scans. With a scene's file the robot stands where the parameters say, or
/// drives from there. Without one, a room is generated for every `scans_per_map` ticks and a
/// standpoint in it for each; both follow from the run's seed, the module's name, the tick and
/// the laser's field of view, beams, range and mount, so that a scan and its truth, modules of one
/// name, see the same world, whichever tick is asked for first.
class LaserWorld {
 public:
  explicit LaserWorld(const LaserWorldOptions& options);

  /// Enters a tick's world: how the laser stands in it. Faults: out_of_range where range_std or
  /// bearing_std is negative or not finite; degenerate where a room has no standpoint.
  Outcome<LaserStand> enter(const Evaluation& evaluation);
  /// The tick's scan, with the noise that follows from its seed, or without any; `surfaces` as
  /// simulate_scan's.
  void scan(const Evaluation& evaluation, const LaserStand& stand, bool noisy,
            std::span<LaserBeam> scan, std::span<std::size_t> surfaces = {}) const;
  /// Sets the components of a laser_scan or segmented_scan: what a scan says of its own errors, and
  /// the mount with its sources.
  void describe(const Evaluation& evaluation, Estimate& scan) const;
  const Scene& scene() const { return *scene_; }
  const RayCaster& caster() const { return *caster_; }
  const LaserSweep& sweep() const { return sweep_; }

 private:
  void set_scene(Scene scene);

  LaserWorldOptions options_;
  LaserSweep sweep_;
  std::optional<Scene> scene_;
  std::optional<RayCaster> caster_;
  std::optional<std::uint64_t> room_;  ///< the seed of the generated room that it is
};

}  // namespace ilss
