#include "sensors/laser/segment/iterative_end_point_fit.h"

#include <algorithm>

namespace ilss {
namespace {

/// The reading of largest `measure` above `least`, looked for from the middle outwards, so that the
/// nearest to the middle wins among equals; 0 if there is none.
template <typename Measure>
std::size_t largest_from_middle(const ReadingRun& run, double least, const Measure& measure) {
  const std::size_t middle = run.begin + run.size() / 2;
  std::size_t largest = 0;
  const auto consider = [&](std::size_t i) {
    const double value = measure(i);
    if (value <= least) return;
    least = value;
    largest = i;
  };
  for (std::size_t i = std::max(middle, run.begin + 1); i + 1 < run.end; ++i) consider(i);
  for (std::size_t i = middle; i-- > run.begin + 1;) consider(i);
  return largest;
}

}  // namespace

void IterativeEndPointFit::Options::declare(OptionVisitor& visit) {
  visit("threshold", threshold, "a point farther from the chord splits the run",
        {.unit = "m", .minimum = 0});
  visit("deviations", deviations, "the threshold is at least so many standard deviations",
        {.minimum = 0});
}

std::size_t farthest_from_chord(std::span<const ScanPoint> points, const ReadingRun& run,
                                double limit) {
  const ScanPoint& first = points[run.begin];
  const double dx = points[run.end - 1].x - first.x;
  const double dy = points[run.end - 1].y - first.y;
  const double length = dx * dx + dy * dy;
  if (length <= limit * limit)
    return largest_from_middle(run, limit * limit, [&](std::size_t i) {
      const double x = points[i].x - first.x;
      const double y = points[i].y - first.y;
      return x * x + y * y;
    });
  return largest_from_middle(run, limit * std::sqrt(length), [&](std::size_t i) {
    return std::abs(dx * (points[i].y - first.y) - dy * (points[i].x - first.x));
  });
}

void IterativeEndPointFit::segment(std::span<const ScanPoint> points, const LaserNoise& noise,
                                   std::vector<ReadingRun>& runs) {
  open_.assign(1, {0, points.size()});
  while (!open_.empty()) {
    const ReadingRun run = open_.back();
    open_.pop_back();
    // Nothing on a straight run is farther away than its ends.
    const double range = std::max(points[run.begin].range, points[run.end - 1].range);
    const double limit =
        std::max(options_.threshold, options_.deviations * noise.deviation_at(range));
    const std::size_t split = farthest_from_chord(points, run, limit);
    if (split == 0) {
      runs.push_back(run);
      continue;
    }
    open_.push_back({split, run.end});
    open_.push_back({run.begin, split});
  }
}

}  // namespace ilss
