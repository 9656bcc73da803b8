// Scans without a sensor: readings of given lines or circles with normal noise in inverse range.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "sensors/range/line_segmentation.h"
#include "sensors/range/range_scan.h"

namespace ilss {

/// The line at distance rho (m) whose normal has direction phi (rad).
inline InverseLine polar_line(double rho, double phi) {
  return {std::cos(phi) / rho, std::sin(phi) / rho};
}

/// What a ray meets: the inverse range (1/m) of a reading whose origin and bearing are set.
using Surface = std::function<double(const RangeReading&)>;

inline Surface on_line(const InverseLine& m) {
  return [m](const RangeReading& r) {
    return (m.x * std::cos(r.bearing) + m.z * std::sin(r.bearing)) /
           (1 - m.x * r.origin_x - m.z * r.origin_z);
  };
}

/// Of a circle's near side.
inline Surface on_circle(double x, double z, double radius) {
  return [=](const RangeReading& r) {
    const double c = std::cos(r.bearing);
    const double s = std::sin(r.bearing);
    const double along = (x - r.origin_x) * c + (z - r.origin_z) * s;
    const double across = (x - r.origin_x) * s - (z - r.origin_z) * c;
    return 1 / (along - std::copysign(std::sqrt(radius * radius - across * across), radius));
  };
}

/// Readings that are yet to be made: their bearings, from `from` to `to` (rad).
struct ScanOf {
  double from = 110 * std::numbers::pi / 180;
  double to = 70 * std::numbers::pi / 180;
  std::size_t readings = 128;
  double deviation = 0.01;
  double origin_x = 0.03;
  double origin_z = 0.05;

  /// Each reading on the surface that `of` says for it, with normal noise.
  std::vector<RangeReading> on(const std::function<const Surface&(std::size_t)>& of,
                               std::mt19937_64& random) const {
    std::normal_distribution<double> normal;
    std::vector<RangeReading> list(readings);
    for (std::size_t i = 0; i < readings; ++i) {
      RangeReading& r = list[i];
      r.time = static_cast<double>(i) / 2500;
      r.origin_x = origin_x;
      r.origin_z = origin_z;
      r.bearing = from + (to - from) * static_cast<double>(i) / static_cast<double>(readings - 1);
      r.deviation = deviation;
      r.inverse_range = of(i)(r) + deviation * normal(random);
    }
    return list;
  }
  std::vector<RangeReading> on(const Surface& surface, std::mt19937_64& random) const {
    return on([&](std::size_t) -> const Surface& { return surface; }, random);
  }
};

/// A module's output that holds these readings as a scan.
inline Output scan_output(const std::vector<RangeReading>& readings) {
  Output scan;
  scan.estimate = Estimate(descriptor<RangeScan>(), "lep");
  const auto room = make_readings(scan, readings.size());
  std::copy(readings.begin(), readings.end(), room.begin());
  return scan;
}

/// The sums of a scan's readings.
inline LineInformationSums sums_of(std::span<const RangeReading> readings) {
  LineInformationSums sums;
  for (const RangeReading& r : readings)
    sums.add(std::cos(r.bearing), std::sin(r.bearing), r.origin_x, r.origin_z, r.inverse_range,
             1 / (r.deviation * r.deviation));
  return sums;
}

}  // namespace ilss
