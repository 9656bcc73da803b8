#include "sensors/laser/segment/segmenter.h"

#include <algorithm>
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
  const auto distance = [](const ScanPoint& a, const ScanPoint& b) {
    return std::hypot(b.x - a.x, b.y - a.y);
  };
  // A curve may come back to where it began.
  const ScanPoint& middle = segment[segment.size() / 2];
  return std::max({distance(segment.front(), segment.back()), distance(segment.front(), middle),
                   distance(middle, segment.back())}) >= least_length;
}

}  // namespace ilss
