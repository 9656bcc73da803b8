// A scan's readings as points of the laser's plane, with what is needed again and again.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "sensors/laser/segment/segmented_scan.h"

namespace ilss {

/// A reading with its place in the laser's frame (REP 103).
struct ScanPoint {
  double bearing = NAN;  ///< rad, counter-clockwise from forward
  double cosine = 1;     ///< of the bearing
  double sine = 0;
  double range = 0;  ///< m; 0: no return
  double x = 0;      ///< m, forward
  double y = 0;      ///< m, to the left
};

/// The noise of a scan's readings, each independent of the others.
struct LaserNoise {
  double range_variance = 0;    ///< m², the quantum's q²/12 included
  double bearing_variance = 0;  ///< rad²

  double range_deviation() const { return std::sqrt(range_variance); }
  /// Of a reading's place in any direction, at a range (m): the larger of the two (m).
  double deviation_at(double range) const {
    return std::sqrt(std::max(range_variance, range * range * bearing_variance));
  }
};

/// Which of the ranges' systematic coefficients are uncertain, and so are to be followed through a
/// fit: the first `count` powers of range / reference.
struct UncertainBiases {
  std::size_t count = 0;
  double reference = 1;  ///< m
};

/// Those of a laser_scan or segmented_scan: up to the last one that has an error.
inline UncertainBiases uncertain_biases(const Estimate& scan) {
  if (scan.lineage.empty()) return {};
  std::size_t count = range_biases;
  while (count > 0 && scan.lineage.variance(first_bias + count - 1) == 0) --count;
  return {count, scan.value[bias_range]};
}

/// The noise that a laser_scan or segmented_scan states. `q²/12`: a uniform error within a step.
inline LaserNoise noise_of(const Estimate& scan) {
  const double range_std = scan.value[index_of<LaserScan>("range_std")];
  const double bearing_std = scan.value[index_of<LaserScan>("bearing_std")];
  const double quantum = scan.value[index_of<LaserScan>("quantum")];
  return {range_std * range_std + quantum * quantum / 12, bearing_std * bearing_std};
}

/// A scan's points. Beams that point where they did in the scan before cost no sine and cosine.
class ScanPoints {
 public:
  void resize(std::size_t beams) { points_.resize(beams); }
  std::span<const ScanPoint> points() const { return points_; }
  /// Whether beam i pointed there in the scan before.
  bool knows(std::size_t i, double bearing) const { return points_[i].bearing == bearing; }
  void set(std::size_t i, double bearing, double range) {
    ScanPoint& point = points_[i];
    if (point.bearing != bearing) {
      point.bearing = bearing;
      point.cosine = std::cos(bearing);
      point.sine = std::sin(bearing);
    }
    point.range = range;
    point.x = range * point.cosine;
    point.y = range * point.sine;
  }

  template <typename Beam>
  std::span<const ScanPoint> update(std::span<const Beam> beams) {
    resize(beams.size());
    for (std::size_t i = 0; i < beams.size(); ++i) set(i, beams[i].bearing, beams[i].range);
    return points_;
  }

 private:
  std::vector<ScanPoint> points_;
};

}  // namespace ilss
