// What the LEP range sensor measures, before it is turned into ranges.
#pragma once

#include <span>

#include "framework/estimate/payload.h"
#include "framework/module/sample_rows.h"

namespace ilss {

/// One reading of the LEP sensor: where the laser pointed and where its image fell.
struct LepReading {
  double time = 0;
  double head = 0;
  double scan_angle = 0;
  double image_position = 0;
  double deviation = 0;
  double current = 0;
  double vehicle_x = 0;
  double vehicle_z = 0;
  double vehicle_heading = 0;

  static constexpr auto columns = Columns{
      column(&LepReading::time, "time", "s", "when it was taken"),
      column(&LepReading::head, "head", "rad", "angle of the head then, to the left"),
      column(&LepReading::scan_angle, "scan_angle", "rad",
             "of the laser, from the projection frame's z axis towards x"),
      column(&LepReading::image_position, "image_position", "m", "on the photodiode"),
      column(&LepReading::deviation, "deviation", "m", "sd of the image position"),
      column(&LepReading::current, "current", "A", "the detector current I_0"),
      column(&LepReading::vehicle_x, "vehicle_x", "m",
             "where the vehicle stood then, to the right of where it was at the last reading"),
      column(&LepReading::vehicle_z, "vehicle_z", "m", "the same, forward"),
      column(&LepReading::vehicle_heading, "vehicle_heading", "rad", "the same, to the left")};
};

/// A scan of image positions; readings without an image are left out.
template <typename T>
struct LepScan {
  T noise_correlation, beam_width;

  static constexpr std::string_view name = "lep_scan";
  static constexpr std::string_view documentation = "image positions of a LEP range sensor";
  static constexpr auto fields =
      Fields{{"noise_correlation", "1", "of one reading's noise and the next one's; exact", 0},
             {"beam_width", "m", "of the laser; exact", 0}};
  static SamplesDescriptor samples() { return samples_of_rows<LepReading>("reading"); }
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
