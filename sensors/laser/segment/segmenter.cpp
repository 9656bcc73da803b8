#include "sensors/laser/segment/segmenter.h"

#include <cmath>

namespace ilss {

void SegmentRule::declare(OptionVisitor& visit) {
  visit("least_readings", least_readings, "of a segment", {.minimum = 2, .maximum = 1000000});
  visit("least_length", least_length,
        "of a segment: the longest of the distances between its first, middle and last points",
        {.unit = "m", .minimum = 0});
}

bool SegmentRule::accepts(std::span<const ScanPoint> segment) const {
  if (static_cast<std::int64_t>(segment.size()) < least_readings) return false;
  const auto is_long = [&](const ScanPoint& a, const ScanPoint& b) {
    const double x = b.x - a.x;
    const double y = b.y - a.y;
    return std::sqrt(x * x + y * y) >= least_length;
  };
  // A curve may come back to where it began.
  const ScanPoint& middle = segment[segment.size() / 2];
  return is_long(segment.front(), segment.back()) || is_long(segment.front(), middle) ||
         is_long(middle, segment.back());
}

}  // namespace ilss
