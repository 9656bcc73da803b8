#include "sensors/range/line_memory.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

/// The weighted mean of two independent fits of one line.
LineFit mean(const LineFit& a, const LineFit& b) {
  const Eigen::Matrix2d information_a = a.covariance.inverse();
  const Eigen::Matrix2d information_b = b.covariance.inverse();
  LineFit result;
  result.covariance = (information_a + information_b).inverse();
  const Eigen::Vector2d line =
      result.covariance * (information_a * Eigen::Vector2d(a.line.x, a.line.z) +
                           information_b * Eigen::Vector2d(b.line.x, b.line.z));
  result.line = {line.x(), line.y()};
  result.by_scan = result.covariance * (information_a * a.by_scan + information_b * b.by_scan);
  result.chi_squared = a.chi_squared + b.chi_squared;
  result.readings = a.readings + b.readings;
  return result;
}

/// A reading's place along a line, from the foot of the perpendicular (m).
double along(const RangeReading& reading, const InverseLine& m) {
  const double norm = std::hypot(m.x, m.z);
  const double x = reading.origin_x + std::cos(reading.bearing) / reading.inverse_range;
  const double z = reading.origin_z + std::sin(reading.bearing) / reading.inverse_range;
  return (m.x * z - m.z * x) / norm;
}

}  // namespace

bool LineMemory::same(const Line& known, const Line& seen) const {
  constexpr double bound = 13.816;  // chi², 2 degrees of freedom, 99.9 %
  const Eigen::Vector2d difference(seen.fit.line.x - known.fit.line.x,
                                   seen.fit.line.z - known.fit.line.z);
  const Eigen::Matrix2d covariance = seen.fit.covariance + known.fit.covariance;
  return difference.dot(covariance.inverse() * difference) < bound &&
         seen.begin < known.end + max_gap_ && known.begin < seen.end + max_gap_;
}

void LineMemory::join(std::span<FittedSegment> segments, std::span<const RangeReading> readings) {
  if (scans_ <= 1) return;
  seen_.clear();
  for (FittedSegment& segment : segments) {
    if (segment.arc) continue;
    const double first = along(readings[segment.first], segment.fit.line);
    const double last = along(readings[segment.last], segment.fit.line);
    Line line{segment.fit, 1, std::min(first, last), std::max(first, last)};
    const auto known =
        std::find_if(lines_.begin(), lines_.end(), [&](const Line& l) { return same(l, line); });
    if (known != lines_.end()) {
      if (known->scans < scans_) {
        line.fit = mean(known->fit, line.fit);
        line.scans = known->scans + 1;
      }
      lines_.erase(known);
    }
    segment.fit = line.fit;
    seen_.push_back(line);
  }
  lines_.swap(seen_);
}

}  // namespace ilss
