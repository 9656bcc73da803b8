// Readings of a laser that looks at a single line or circle, with the noise that fits assume.
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "sensors/laser/scan_points.h"

namespace ilss {

inline constexpr double degree = std::numbers::pi / 180;

/// What a simulated laser is like.
struct LaserDevice {
  double range_std = 0.005;
  double bearing_std = 0.1 * degree;
  double quantum = 0;
  double offset = 0;  ///< of all ranges
  LaserNoise noise() const {
    return {range_std * range_std + quantum * quantum / 12, bearing_std * bearing_std};
  }
};

/// Readings at `count` bearings from `first` on; `range_at(cosine, sine)` is the truth.
template <typename Range>
std::vector<ScanPoint> simulate_readings(const LaserDevice& device, double first, double step,
                                         int count, const Range& range_at, std::mt19937_64& draw) {
  std::normal_distribution<double> normal;
  std::vector<ScanPoint> points;
  for (int i = 0; i < count; ++i) {
    const double bearing = first + i * step;
    const double looks = bearing + device.bearing_std * normal(draw);
    double range = range_at(std::cos(looks), std::sin(looks)) + device.offset +
                   device.range_std * normal(draw);
    if (device.quantum > 0) range = device.quantum * std::round(range / device.quantum);
    const double c = std::cos(bearing);
    const double s = std::sin(bearing);
    points.push_back({bearing, c, s, range, range * c, range * s});
  }
  return points;
}

}  // namespace ilss
