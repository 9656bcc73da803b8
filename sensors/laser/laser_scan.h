// A scan of a laser range finder as it comes from the device: ranges at equal steps of bearing.
#pragma once

#include <span>

#include "framework/estimate/payload.h"
#include "framework/module/sample_rows.h"

namespace ilss {

/// One beam. A range of 0 is no return: nothing came back, or nothing that the device believes.
struct LaserBeam {
  double bearing = 0;
  double range = 0;

  static constexpr auto columns = Columns{
      column(&LaserBeam::bearing, "bearing", "rad", "counter-clockwise from the forward axis"),
      column(&LaserBeam::range, "range", "m", "0: no return")};
};

/// A scan in the laser's own frame (REP 103: x forward, y to the left), one row of the samples a
/// beam, in the order of the sweep. The components are what later modules need of the device: its
/// noise, what its ranges have in common, and where it stands on its robot. A range r is wrong by
/// the sum of bias_k (r / bias_range)^k, beside its noise; the biases are 0 and known with some
/// error, which does not average out, nor does the mount's. The mount is in the robot's plane: x
/// forward and z to the right of its origin, heading from x towards z, as a sonar's.
template <typename T>
struct LaserScan {
  T range_std, bearing_std, quantum, max_range;
  T bias_0{}, bias_1{}, bias_2{}, bias_3{}, bias_4{}, bias_5{}, bias_6{}, bias_range{1.0};
  T mount_x{}, mount_z{}, mount_heading{};

  static constexpr std::string_view name = "laser_scan";
  static constexpr std::string_view documentation = "ranges of a laser range finder";
  static constexpr auto fields =
      Fields{{"range_std", "m", "sd of a range's noise; exact"},
             {"bearing_std", "rad", "sd of a beam's bearing; exact", 0},
             {"quantum", "m", "step in which ranges are told; exact", 0},
             {"max_range", "m", "beyond which there is no return; exact"},
             {"bias_0", "m", "of all ranges: an offset", 0},
             {"bias_1", "m", "by the range: a scale", 0},
             {"bias_2", "m", "by its square", 0},
             {"bias_3", "m", "and so on", 0},
             {"bias_4", "m", "", 0},
             {"bias_5", "m", "", 0},
             {"bias_6", "m", "", 0},
             {"bias_range", "m", "at which each bias is what it says; exact", 1},
             {"mount_x", "m", "the laser's place, forward of the robot's origin", 0},
             {"mount_z", "m", "the laser's place, to the right", 0},
             {"mount_heading", "rad", "where the laser looks, positive to the right", 0,
              Geometry::circular}};
  static SamplesDescriptor samples() { return samples_of_rows<LaserBeam>("beam"); }
};

/// How many coefficients the systematic error of a range has.
inline constexpr std::size_t range_biases = 7;
/// The first of them among a laser_scan's components, and the range that they refer to.
inline constexpr std::size_t first_bias = index_of<LaserScan>("bias_0");
inline constexpr std::size_t bias_range = index_of<LaserScan>("bias_range");
/// The mount's three, x, z and heading, among them.
inline constexpr std::size_t first_mount = index_of<LaserScan>("mount_x");
inline constexpr std::size_t mount_size = 3;

/// The beams of a scan's output.
inline std::span<const LaserBeam> beams_of(const Output& scan) { return rows_of<LaserBeam>(scan); }

/// Room for `count` beams in a scan's output, to be written by the caller.
inline std::span<LaserBeam> make_beams(Output& scan, std::size_t count) {
  return make_rows<LaserBeam>(scan, count);
}

}  // namespace ilss
