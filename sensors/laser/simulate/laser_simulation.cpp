#include "sensors/laser/simulate/laser_simulation.h"

#include <cmath>

#include "framework/estimate/random.h"

namespace ilss {
namespace {

/// How many rays stand for a beam with a width.
constexpr int rays_of_beam = 9;

constexpr RayHit no_hit{0, no_surface};

/// The laser's pose while it sends each beam.
class SweepPoses {
 public:
  SweepPoses(const LaserSweep& sweep, const LaserStand& stand)
      : sweep_(sweep), stand_(stand), last_(compose_poses(stand.robot, stand.mount)) {}

  ScenePose at(std::size_t beam) const {
    if (sweep_.duration == 0 || beam + 1 == sweep_.beams) return last_;
    const double share = static_cast<double>(beam) / static_cast<double>(sweep_.beams - 1);
    const double time = -(1 - share) * sweep_.duration;
    return compose_poses(drive(stand_.robot, sweep_.speed, sweep_.turn_rate, time), stand_.mount);
  }

 private:
  const LaserSweep& sweep_;
  const LaserStand& stand_;
  ScenePose last_;
};

/// A ray of the laser: the scene's angles count to the right, a laser's bearings to the left.
std::optional<RayHit> cast(const RayCaster& scene, const ScenePose& laser, double bearing,
                           double max_range) {
  const double angle = laser.heading - bearing;
  return scene.cast({laser.x, laser.z}, std::cos(angle), std::sin(angle), max_range);
}

/// What a beam with a width gives. A range of 0: no return.
RayHit beam_hit(const RayCaster& scene, const ScenePose& laser, double bearing,
                const LaserSweep& sweep) {
  const std::optional<RayHit> centre = cast(scene, laser, bearing, sweep.max_range);
  if (sweep.beam_width == 0) return centre.value_or(no_hit);
  double sum = 0;
  int returned = 0;
  bool mixed = false;
  for (int i = 0; i < rays_of_beam; ++i) {
    const double offset = sweep.beam_width * (static_cast<double>(i) / (rays_of_beam - 1) - 0.5);
    const std::optional<RayHit> hit = cast(scene, laser, bearing + offset, sweep.max_range);
    mixed |= hit.has_value() != centre.has_value() ||
             (hit.has_value() && hit->surface != centre->surface);
    if (!hit) continue;
    sum += hit->range;
    ++returned;
  }
  if (mixed) return {sum / returned, no_surface};
  return centre.value_or(no_hit);
}

}  // namespace

double LaserSweep::bearing(std::size_t beam) const {
  if (beams < 2) return 0;
  return field_of_view * (static_cast<double>(beam) / static_cast<double>(beams - 1) - 0.5);
}

void trace_beams(const RayCaster& scene, const LaserSweep& sweep, const LaserStand& stand,
                 std::vector<TracedBeam>& beams) {
  const SweepPoses poses(sweep, stand);
  beams.resize(sweep.beams);
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const ScenePose laser = poses.at(i);
    const double angle = laser.heading - sweep.bearing(i);
    const double cosine = std::cos(angle);
    const double sine = std::sin(angle);
    const auto hit = scene.cast({laser.x, laser.z}, cosine, sine, sweep.max_range);
    const double range = hit ? hit->range : 0;
    beams[i] = {hit, {laser.x + range * cosine, laser.z + range * sine}};
  }
}

void simulate_scan(const RayCaster& scene, const LaserSweep& sweep, const LaserStand& stand,
                   const LaserErrors& errors, std::uint64_t seed, std::span<LaserBeam> scan,
                   std::span<std::size_t> surfaces) {
  RandomBits random(seed);
  const SweepPoses poses(sweep, stand);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double bearing = sweep.bearing(i);
    const double bearing_error = errors.bearing_std * draw_normal(random);
    const double range_error = errors.range_std * draw_normal(random);
    const RayHit hit = beam_hit(scene, poses.at(i), bearing + bearing_error, sweep);
    double range = hit.range;
    if (range > 0) {
      range += range_error;
      if (errors.quantum > 0) range = std::round(range / errors.quantum) * errors.quantum;
    }
    const bool returned = range > 0 && range <= sweep.max_range;
    scan[i] = {bearing, returned ? range : 0};
    if (!surfaces.empty()) surfaces[i] = returned ? hit.surface : no_surface;
  }
}

std::vector<LaserBeam> simulate_scan(const Scene& scene, const ScenePose& laser,
                                     const LaserSweep& sweep, const LaserErrors& errors,
                                     std::uint64_t seed) {
  std::vector<LaserBeam> scan(sweep.beams);
  simulate_scan(RayCaster(scene), sweep, LaserStand{.robot = laser}, errors, seed, scan);
  return scan;
}

}  // namespace ilss
