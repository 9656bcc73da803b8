// A simulated laser range finder: what its beams meet in a scene, and what it tells of that.
#pragma once

#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "framework/estimate/random.h"
#include "sensors/laser/laser_scan.h"
#include "sensors/scene/ray_caster.h"

namespace ilss {

/// How a laser scans: equal steps of bearing from the right to the left, the same to either side.
struct LaserSweep {
  std::size_t beams = 360;
  double field_of_view = 359 * std::numbers::pi / 360;  ///< from first to last beam (rad)
  double max_range = 30;                                ///< m
  double beam_width = 0;  ///< rad; a beam that straddles an edge gives a mixture
  double speed = 0;       ///< of the robot during the sweep, forward (m/s)
  double turn_rate = 0;   ///< of the robot, to the right (rad/s)
  double duration = 0;    ///< from first to last beam (s)

  /// A beam's bearing, counter-clockwise from forward (rad).
  double bearing(std::size_t beam) const;
};

/// What is wrong with each reading by itself.
struct LaserErrors {
  double range_std = 0;    ///< m
  double bearing_std = 0;  ///< rad; a beam goes elsewhere than where it says
  double quantum = 0;      ///< m
};

/// Where the robot is in the scene at the sweep's end, and where the laser is on it.
struct LaserStand {
  ScenePose robot = {};
  ScenePose mount = {};
};

/// What a beam meets without any error: where on the surface (world axes), and from which pose.
struct TracedBeam {
  std::optional<RayHit> hit;
  ScenePoint point;
};

/// Traces every beam of a sweep without error.
void trace_beams(const RayCaster& scene, const LaserSweep& sweep, const LaserStand& stand,
                 std::vector<TracedBeam>& beams);

/// Draws a scan: each beam goes to its bearing and an error, its range has an error and is told in
/// whole quanta; a range beyond max_range, or of 0 by its error, is no return. A beam with a width
/// is several rays, and where these meet unlike surfaces, its range is the mean of those that come
/// back. `scan` has `sweep.beams` rows. As many random numbers are drawn whatever the beams meet,
/// so scans of unlike errors of one seed have the same errors but for their sizes. Where `surfaces`
/// is not empty, it has as many places, for which surface each beam has its range from: an index
/// as RayHit's, `no_surface` for no return and a mixture.
void simulate_scan(const RayCaster& scene, const LaserSweep& sweep, const LaserStand& stand,
                   const LaserErrors& errors, std::uint64_t seed, std::span<LaserBeam> scan,
                   std::span<std::size_t> surfaces = {});
inline constexpr std::size_t no_surface = static_cast<std::size_t>(-1);

/// The same for a laser that stands at `laser`, in a vector of its own.
std::vector<LaserBeam> simulate_scan(const Scene& scene, const ScenePose& laser,
                                     const LaserSweep& sweep, const LaserErrors& errors,
                                     std::uint64_t seed);

}  // namespace ilss
