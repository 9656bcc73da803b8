// Where a laser stands on its robot: stated once, by the module that gives its scans, and carried
// by these to whatever needs it.
#pragma once

#include "sensors/laser/laser_scan.h"

namespace ilss {

/// In the robot's plane, x forward and z to the right; heading from x towards z (m, rad).
struct LaserMount {
  double x = 0;
  double z = 0;
  double heading = 0;
};

/// The mount that a laser_scan or segmented_scan carries.
inline LaserMount mount_of(const Estimate& scan) {
  return {scan.value[first_mount], scan.value[first_mount + 1], scan.value[first_mount + 2]};
}

/// Gives a laser_scan or segmented_scan its mount, and adds the mount's sources to its lineage: the
/// parameters `first_parameter` and the two after it are `mount.x`, `mount.z` and `mount.heading`.
void set_mount(const Estimate& parameters, std::size_t first_parameter, Estimate& scan);

}  // namespace ilss
