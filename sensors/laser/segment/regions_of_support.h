// How far to either side of a reading the contour tells of its curvature, and what it tells.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "framework/module/parameters.h"
#include "sensors/laser/scan_points.h"

namespace ilss {

/// Bounds of a reading's region of support, on either side.
struct SupportRule {
  std::int64_t least_readings = 3;
  std::int64_t most_readings = 1000;
  double longest = 1;  ///< m, from the reading to the region's end
  void declare(OptionVisitor& visit);
};

/// A cluster's regions of support: for each reading the readings where it ends, both ways.
class RegionsOfSupport {
 public:
  explicit RegionsOfSupport(const SupportRule& rule) : rule_(rule) {}

  /// `supports(from, to)` says whether the contour between two readings has no corner. The end of a
  /// reading's region is looked for from that of the reading before, so that a cluster of n
  /// readings costs some 4 n questions, however long the regions are.
  template <typename Supports>
  void update(std::span<const ScanPoint> points, const Supports& supports);

  std::span<const std::size_t> forward() const { return forward_; }
  std::span<const std::size_t> backward() const { return backward_; }

 private:
  bool is_short(const ScanPoint& from, const ScanPoint& to) const {
    const double x = to.x - from.x;
    const double y = to.y - from.y;
    return x * x + y * y <= rule_.longest * rule_.longest;
  }

  SupportRule rule_;
  std::vector<std::size_t> forward_, backward_;
};

/// The variance of a reading's place in any direction (m²), the larger of the two.
inline double place_variance(const ScanPoint& point, const LaserNoise& noise) {
  return std::max(noise.range_variance, point.range * point.range * noise.bearing_variance);
}

/// A reading's local vectors, from where its support begins and to where it ends.
struct LocalVectors {
  double product = 0;    ///< m², of their lengths; 0 where one has none
  double cross = 0;      ///< m²
  double dot = 0;        ///< m²
  double deviation = 0;  ///< rad, of the angle between them, per metre of the places' noise
};
LocalVectors local_vectors(const ScanPoint& before, const ScanPoint& point, const ScanPoint& after);

template <typename Supports>
void RegionsOfSupport::update(std::span<const ScanPoint> points, const Supports& supports) {
  const std::size_t count = points.size();
  const auto least = static_cast<std::size_t>(rule_.least_readings);
  const auto most = std::max(least, static_cast<std::size_t>(rule_.most_readings));
  const auto holds = [&](std::size_t from, std::size_t to) {
    return is_short(points[from], points[to]) && supports(from, to);
  };
  forward_.resize(count);
  backward_.resize(count);
  std::size_t end = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t lowest = std::min(i + least, count - 1);
    const std::size_t highest = std::min(i + most, count - 1);
    end = std::max(end, lowest);
    while (end < highest && holds(i, end + 1)) ++end;
    while (end > lowest && !holds(i, end)) --end;
    forward_[i] = end;
  }
  std::size_t begin = count - 1;
  for (std::size_t i = count; i-- > 0;) {
    const std::size_t highest = i - std::min(i, least);
    const std::size_t lowest = i - std::min(i, most);
    begin = std::min(begin, highest);
    while (begin > lowest && holds(begin - 1, i)) --begin;
    while (begin < highest && !holds(begin, i)) ++begin;
    backward_[i] = begin;
  }
}

}  // namespace ilss
