#include "sensors/laser/segmenter.h"

#include <cmath>

namespace ilss {

void SegmentRule::declare(OptionVisitor& visit) {
  visit("least_readings", least_readings, "of a segment", {.minimum = 2, .maximum = 1000000});
  visit("least_length", least_length, "of a segment, from its first to its last point",
        {.unit = "m", .minimum = 0});
}

bool SegmentRule::accepts(std::span<const ScanPoint> segment) const {
  if (static_cast<std::int64_t>(segment.size()) < least_readings) return false;
  const ScanPoint& first = segment.front();
  const ScanPoint& last = segment.back();
  return std::hypot(last.x - first.x, last.y - first.y) >= least_length;
}

}  // namespace ilss
