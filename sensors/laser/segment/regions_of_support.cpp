#include "sensors/laser/segment/regions_of_support.h"

namespace ilss {

void SupportRule::declare(OptionVisitor& visit) {
  visit("least_readings", least_readings, "on either side", {.minimum = 1, .maximum = 1000000});
  visit("most_readings", most_readings, "on either side", {.minimum = 1, .maximum = 1000000});
  visit("longest", longest, "on either side, from the reading to the last one of its support",
        {.unit = "m", .minimum = 0});
}

LocalVectors local_vectors(const ScanPoint& before, const ScanPoint& point,
                           const ScanPoint& after) {
  const double bx = point.x - before.x;
  const double by = point.y - before.y;
  const double fx = after.x - point.x;
  const double fy = after.y - point.y;
  const double bb = bx * bx + by * by;
  const double ff = fx * fx + fy * fy;
  if (!(bb > 0) || !(ff > 0)) return {};
  const double product = std::sqrt(bb * ff);
  // The angle is (across_1 - across) / |b| + (across_2 - across) / |f|, of three noisy places.
  return {product, bx * fy - by * fx, bx * fx + by * fy,
          std::sqrt(2 * (1 / bb + 1 / ff + 1 / product))};
}

}  // namespace ilss
