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
  double time = 0;
  double head = 0;
  double origin_x = 0;
  double origin_z = 0;
  double bearing = 0;
  double inverse_range = 0;
  double deviation = 0;
  std::array<double, shared_range_errors> sensitivity = {};

  static constexpr auto columns = Columns{
      column(&RangeReading::time, "time", "s", "when it was taken"),
      column(&RangeReading::head, "head", "rad", "angle of the sensor's head then, x towards z"),
      column(&RangeReading::origin_x, "origin_x", "m", "where the ray starts"),
      column(&RangeReading::origin_z, "origin_z", "m", "the same"),
      column(&RangeReading::bearing, "bearing", "rad", "of the ray, from x towards z"),
      column(&RangeReading::inverse_range, "inverse_range", "1/m", "positive"),
      column(&RangeReading::deviation, "deviation", "1/m",
             "sd of the inverse range's own noise, positive"),
      column(&RangeReading::sensitivity, "sensitivity", "1/m",
             "of the inverse range, by error_1 to error_5")};
};

/// How the readings' own noise behaves.
struct RangeNoise {
  double correlation = 0;  ///< of one reading's noise and the next one's
  /// Normal in range and not in inverse range: then a reading's sd of the inverse range holds at
  /// the range that was measured, and changes with the square of the true one. A fit that took its
  /// weights from what was measured would prefer the readings that came out too far.
  bool in_range = false;

  RangeNoise(double noise_correlation = 0,  // NOLINT(google-explicit-constructor)
             bool is_in_range = false)
      : correlation(noise_correlation), in_range(is_in_range) {}
  /// Of variances, for what neighbouring readings say alike.
  double factor() const { return (1 + correlation) / (1 - correlation); }
};

/// How far a reading is from what is expected of it (1/m), and with which weight that counts (m²).
struct RangeResidual {
  double value;
  double weight;
  double by_reading;  ///< of the value, by the reading's inverse range

  RangeResidual(const RangeReading& reading, double expected, const RangeNoise& noise) {
    const double ratio = expected / reading.inverse_range;
    // To first order in the noise the same; in range it is the range's error times expected².
    by_reading = noise.in_range ? ratio * ratio : 1;
    value = noise.in_range ? expected * (1 - ratio) : reading.inverse_range - expected;
    const double deviation = reading.deviation * by_reading;
    weight = 1 / (deviation * deviation);
  }
};

/// A scan: its readings are the samples, one row each, in the order in which they were taken. The
/// components are what the readings share; what is not known of it does not average out. The scan's
/// frame stands still while the scan is taken and does not turn with the head.
template <typename T>
struct RangeScan {
  T mount_x, mount_z, mount_heading, error_1, error_2, error_3, error_4, error_5, noise_correlation,
      beam_width, noise_in_range;

  static constexpr std::string_view name = "range_scan";
  static constexpr std::string_view documentation = "ranges along rays";
  static constexpr auto fields =
      Fields{{"mount_x", "m", "where the rays start, seen from the head's axis at head angle 0", 0},
             {"mount_z", "m", "the same along z", 0},
             {"mount_heading", "rad", "how far the rays are turned in the head, x towards z", 0,
              Geometry::circular},
             {"error_1", "1", "a systematic error of the ranges; its value is 0", 0},
             {"error_2", "1", "another", 0},
             {"error_3", "1", "another", 0},
             {"error_4", "1", "another", 0},
             {"error_5", "1", "another", 0},
             {"noise_correlation", "1", "of one reading's noise and the next one's; exact", 0},
             {"beam_width", "m", "within which a reading may hold light of two surfaces; exact", 0},
             {"noise_in_range", "1",
              "1 where the noise is normal in range, 0 where it is in inverse range; exact", 0}};
  static SamplesDescriptor samples() { return samples_of_rows<RangeReading>("reading"); }
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
