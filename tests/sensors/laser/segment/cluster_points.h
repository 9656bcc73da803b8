// Points of a cluster as a segmentation algorithm gets them, for tests.
#pragma once

#include <random>

#include "tests/sensors/laser/segment/segmenter_run.h"

namespace ilss {

/// The points of beams, with noise of the ranges.
inline std::vector<ScanPoint> points_of(std::vector<LaserBeam> beams, double range_std = 0,
                                        std::uint64_t seed = 1) {
  std::mt19937_64 draw(seed);
  std::normal_distribution<double> normal;
  for (LaserBeam& beam : beams) beam.range += range_std * normal(draw);
  ScanPoints buffer;
  const auto points = buffer.update(std::span<const LaserBeam>(beams));
  return {points.begin(), points.end()};
}

/// A corner of two walls, 2 m to the front and 2 m to the left; the first reading of the second.
inline constexpr std::size_t corner_reading = 150;
inline std::vector<LaserBeam> corner_beams() {
  constexpr double pi = std::numbers::pi;
  constexpr double step = 0.5 * pi / 180;
  const double first = pi / 4 - step * (static_cast<double>(corner_reading) - 0.5);
  return beams_to(first, first + 279 * step, 280, [](double bearing) {
    return range_to_line(bearing, 2, bearing < pi / 4 ? 0 : pi / 2);
  });
}

/// A pillar's front: a circle of a radius, its centre at a distance.
inline std::vector<LaserBeam> pillar_beams(double radius, double distance, std::size_t count) {
  const double half = 0.95 * std::asin(radius / distance);
  return beams_to(-half, half, count, [&](double bearing) {
    const double across = distance * std::sin(bearing);
    return distance * std::cos(bearing) - std::sqrt(radius * radius - across * across);
  });
}

}  // namespace ilss
