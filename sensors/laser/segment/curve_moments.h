// Sums over a scan's points that tell at once how well a line or a circle fits any run of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "sensors/laser/scan_points.h"

namespace ilss {

/// How well a circle fits: chi² of the points about it, and its radius (m; infinite for a line).
struct CircleCost {
  double chi_squared;
  double radius;
};

/// Weighted sums of powers of points' coordinates, with q = x² + y².
struct CurveMoments {
  double w = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, xq = 0, yq = 0, qq = 0;

  CurveMoments operator-(const CurveMoments& other) const {
    return {w - other.w,   x - other.x,   y - other.y,   xx - other.xx, xy - other.xy,
            yy - other.yy, xq - other.xq, yq - other.yq, qq - other.qq};
  }
  /// Chi² about the best line: the smaller eigenvalue of the scatter.
  double line_chi_squared() const {
    const double share = 1 / w;
    const double mx = x * share;
    const double my = y * share;
    const double half = (xx - mx * x + yy - my * y) / 2;
    const double difference = (xx - mx * x - yy + my * y) / 2;
    const double mixed = xy - mx * y;
    return std::max(0.0, half - std::sqrt(difference * difference + mixed * mixed));
  }
  /// Chi² about the best circle or line, by Taubin's algebraic distance (Taubin 1991; the
  /// characteristic polynomial as in Chernov 2010, sec. 5.10). Where it is above `enough`, that may
  /// be all it tells: a chi² above `enough`, not above the circle's, and an infinite radius.
  CircleCost circle(double enough = INFINITY) const;
};

/// Running sums over points: the moments of any run in constant time. A point's weight is one over
/// the variance across the surface, whose direction is taken from its neighbours.
class CurveMomentSums {
 public:
  void set(std::span<const ScanPoint> points, const LaserNoise& noise);
  CurveMoments of(std::size_t begin, std::size_t end) const { return sums_[end] - sums_[begin]; }

 private:
  std::vector<CurveMoments> sums_;
};

}  // namespace ilss
