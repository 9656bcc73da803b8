// What the LEP range sensor measures, before it is turned into ranges.
#pragma once

#include <span>

#include "framework/estimate/payload.h"
#include "framework/module/sample_rows.h"

namespace ilss {

/// One reading of the LEP sensor: where the laser pointed and where its image fell.
struct LepReading {
  double time = 0;            ///< s
  double head = 0;            ///< angle of the head when it was taken, to the left (rad)
  double scan_angle = 0;      ///< of the laser, from the projection frame's z axis towards x (rad)
  double image_position = 0;  ///< on the photodiode (m)
  double deviation = 0;       ///< sd of the image position (m)
  double current = 0;         ///< the detector current I_0 (A)
  /// Where the vehicle stood and looked when it was taken, seen from where it was at the scan's
  /// last reading: x to the right and z forward (m), heading to the left (rad).
  double vehicle_x = 0;
  double vehicle_z = 0;
  double vehicle_heading = 0;
};

/// A scan of image positions; readings without an image are left out.
template <typename T>
struct LepScan {
  T noise_correlation, beam_width;

  static constexpr std::string_view name = "lep_scan";
  static constexpr std::string_view documentation =
      "image positions of a LEP range sensor; each row of the samples is time (s), head angle "
      "(rad), scan angle (rad), image position and its sd (m), detector current (A), and the "
      "vehicle's x, z (m) and heading (rad) seen from where it was at the last reading";
  static constexpr auto fields =
      Fields{{"noise_correlation", "1", "of one reading's noise and the next one's; exact", 0},
             {"beam_width", "m", "of the laser; exact", 0}};
  static SamplesDescriptor samples() { return {"SI", {"reading", "quantity"}}; }
};

/// The readings of a scan's output.
inline std::span<const LepReading> lep_readings_of(const Output& scan) {
  return rows_of<LepReading>(scan);
}

/// Room for `count` readings in a scan's output, to be written by the caller.
inline std::span<LepReading> make_lep_readings(Output& scan, std::size_t count) {
  return make_rows<LepReading>(scan, count);
}

}  // namespace ilss
