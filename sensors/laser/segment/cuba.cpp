#include "sensors/laser/segment/cuba.h"

#include <cmath>

namespace ilss {

void Cuba::Options::declare(OptionVisitor& visit) {
  visit("excess", excess, "U_k: by how much a support's contour may be longer than its chord",
        {.unit = "m", .minimum = 0});
  visit("ruler", ruler,
        "the contour's length is measured in steps of so many standard deviations of a reading",
        {.minimum = 0});
  visit("support", support, "how long the vectors may be");
  visit("corners", corners, "what a corner must be");
}

bool Cuba::supports(std::size_t from, std::size_t to) const {
  const double chord = std::hypot(points_[to].x - points_[from].x, points_[to].y - points_[from].y);
  const double length = lengths_.lengths()[to] - lengths_.lengths()[from];
  const double noise = lengths_.excess()[to] - lengths_.excess()[from];
  return length - chord <= options_.excess + 2 * noise;
}

void Cuba::segment(std::span<const ScanPoint> points, const LaserNoise& noise,
                   std::vector<ReadingRun>& runs) {
  points_ = points;
  lengths_.update(points, noise);
  regions_.update(points, [this](std::size_t from, std::size_t to) { return supports(from, to); });
  turn_.assign(points.size(), 0);
  deviation_.assign(points.size(), 0);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const LocalVectors vectors =
        local_vectors(points[regions_.backward()[i]], points[i], points[regions_.forward()[i]]);
    turn_[i] = std::atan2(vectors.cross, vectors.dot);
    deviation_[i] = vectors.deviation * std::sqrt(place_variance(points[i], noise));
  }
  segments_.segment(points, noise, turn_, deviation_, runs);
}

}  // namespace ilss
