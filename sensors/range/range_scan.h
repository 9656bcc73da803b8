// Readings of a range sensor that looks in one direction after another, such as a scanner's.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "framework/estimate/payload.h"
#include "framework/module/sample_rows.h"

namespace ilss {

/// How many errors of their own all readings of a scan may share.
inline constexpr std::size_t shared_range_errors = 5;

/// One reading: what the sensor saw along one ray. The ray starts at (origin_x, origin_z) and runs
/// at `bearing`, from the frame's x axis towards its z axis; what it met is at distance 1 /
/// inverse_range. The inverse is what is nearly linear in what range sensors measure and exactly
/// linear in a line's parameters (a straight line seen in direction e from the origin has inverse
/// range a · e), so noise that is normal there stays honest.
struct RangeReading {
  double time = 0;           ///< s
  double head = 0;           ///< angle of the sensor's head when it was taken, x towards z (rad)
  double origin_x = 0;       ///< m, in the scan's frame
  double origin_z = 0;       ///< m
  double bearing = 0;        ///< rad
  double inverse_range = 0;  ///< 1/m, positive
  double deviation = 0;      ///< sd of the inverse range's own noise (1/m), positive
  /// By the scan's `error_1` ... `error_5` (1/m each).
  std::array<double, shared_range_errors> sensitivity = {};
};

/// A scan: its readings are the samples, one row each, in the order in which they were taken. The
/// components are what the readings share; what is not known of it does not average out. The scan's
/// frame stands still while the scan is taken and does not turn with the head.
template <typename T>
struct RangeScan {
  T mount_x, mount_z, mount_heading, error_1, error_2, error_3, error_4, error_5, noise_correlation,
      beam_width;

  static constexpr std::string_view name = "range_scan";
  static constexpr std::string_view documentation =
      "ranges along rays; each row of the samples is time (s), head angle (rad), the ray's origin "
      "x and z (m), its bearing from x towards z (rad), the inverse range and the sd of its noise "
      "(1/m), and its sensitivity to the five shared errors (1/m)";
  static constexpr auto fields = Fields{
      {"mount_x", "m", "where the rays start, seen from the head's axis at head angle 0", 0},
      {"mount_z", "m", "the same along z", 0},
      {"mount_heading", "rad", "how far the rays are turned in the head, x towards z", 0, true},
      {"error_1", "1", "a systematic error of the ranges; its value is 0", 0},
      {"error_2", "1", "another", 0},
      {"error_3", "1", "another", 0},
      {"error_4", "1", "another", 0},
      {"error_5", "1", "another", 0},
      {"noise_correlation", "1", "of one reading's noise and the next one's; exact", 0},
      {"beam_width", "m", "within which a reading may hold light of two surfaces; exact", 0}};
  static SamplesDescriptor samples() { return {"SI", {"reading", "quantity"}}; }
};

/// The readings of a scan's output.
inline std::span<const RangeReading> readings_of(const Output& scan) {
  return rows_of<RangeReading>(scan);
}

/// Room for `count` readings in a scan's output, to be written by the caller.
inline std::span<RangeReading> make_readings(Output& scan, std::size_t count) {
  return make_rows<RangeReading>(scan, count);
}

}  // namespace ilss
