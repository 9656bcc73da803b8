#include "sensors/laser/segment/contour_length.h"

#include "sensors/laser/segment/regions_of_support.h"

namespace ilss {

void ContourLength::update(std::span<const ScanPoint> points, const LaserNoise& noise) {
  lengths_.assign(points.size(), 0);
  excess_.assign(points.size(), 0);
  std::size_t last = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double x = points[i].x - points[last].x;
    const double y = points[i].y - points[last].y;
    const double square = x * x + y * y;
    const double variance = place_variance(points[i], noise);
    if (square < ruler_ * ruler_ * variance && i + 1 < points.size()) continue;
    const double length = std::sqrt(square);
    // The last step may be short; then its noise is no more than itself.
    const double excess = length > 0 ? std::min(length, variance / length) : 0;
    const auto readings = static_cast<double>(i - last);
    for (std::size_t k = last + 1; k <= i; ++k) {
      const double share = static_cast<double>(k - last) / readings;
      lengths_[k] = lengths_[last] + share * length;
      excess_[k] = excess_[last] + share * excess;
    }
    last = i;
  }
}

}  // namespace ilss
