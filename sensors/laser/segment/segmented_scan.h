// A laser scan taken apart: which beams belong together.
#pragma once

#include "sensors/laser/laser_scan.h"

namespace ilss {

/// A beam of a segmented scan. Segments are numbered from 1 in the order of the sweep, each is a
/// run of beams one after another; 0 belongs to none: no return, an isolated reading, or what a
/// segmenter left over.
struct SegmentedBeam {
  double bearing = 0;
  double range = 0;
  double segment = 0;

  static constexpr auto columns = Columns{
      column(&SegmentedBeam::bearing, "bearing", "rad", "counter-clockwise from the forward axis"),
      column(&SegmentedBeam::range, "range", "m", "0: no return"),
      column(&SegmentedBeam::segment, "segment", "1", "that it belongs to, from 1; 0: none")};
};

/// A laser_scan whose beams say to which segment they belong: what a breakpoint detector makes of a
/// scan, and a segmenter of that. In the laser's frame; the components are the scan's.
template <typename T>
struct SegmentedScan {
  T range_std, bearing_std, quantum, max_range;
  T bias_0{}, bias_1{}, bias_2{}, bias_3{}, bias_4{}, bias_5{}, bias_6{}, bias_range{1.0};
  T mount_x{}, mount_z{}, mount_heading{};

  static constexpr std::string_view name = "segmented_scan";
  static constexpr std::string_view documentation = "a laser_scan taken apart";
  static constexpr auto fields = LaserScan<T>::fields;
  static SamplesDescriptor samples() { return samples_of_rows<SegmentedBeam>("beam"); }
};

/// The beams of a segmented scan's output.
inline std::span<const SegmentedBeam> segmented_beams_of(const Output& scan) {
  return rows_of<SegmentedBeam>(scan);
}

}  // namespace ilss
