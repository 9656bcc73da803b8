#include "sensors/laser/segment/iterative_end_point_fit.h"

#include <algorithm>
#include <cmath>

#include "sensors/laser/internal/pairs.h"

namespace ilss {
namespace {

/// The reading of largest `measure` above `least`; among equals the nearest to the middle, the
/// later one first; 0 if there is none. `measure` takes two readings.
template <typename Measure>
std::size_t largest_from_middle(std::span<const ScanPoint> points, const ReadingRun& run,
                                double least, const Measure& measure) {
  // The value first, without a branch that depends on it; then where it is.
  double most = least;
  double most_of_next = least;
  std::size_t i = run.begin + 1;
  for (; i + 2 < run.end; i += 2) {
    const Pair values = measure(points[i], points[i + 1]);
    most = values[0] > most ? values[0] : most;
    most_of_next = values[1] > most_of_next ? values[1] : most_of_next;
  }
  if (i + 1 < run.end) most = std::max(most, measure(points[i], points[i])[0]);
  most = std::max(most, most_of_next);
  if (!(most > least)) return 0;
  const auto is_it = [&](std::size_t k) { return measure(points[k], points[k])[0] >= most; };
  const std::size_t middle = run.begin + run.size() / 2;
  for (i = std::max(middle, run.begin + 1); i + 1 < run.end; ++i)
    if (is_it(i)) return i;
  for (i = middle - 1; i > run.begin + 1 && !is_it(i);) --i;
  return i;
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
  const auto x_of = [&](const ScanPoint& p, const ScanPoint& q) {
    return Pair{p.x, q.x} - first.x;
  };
  const auto y_of = [&](const ScanPoint& p, const ScanPoint& q) {
    return Pair{p.y, q.y} - first.y;
  };
  if (length <= limit * limit)
    return largest_from_middle(points, run, limit * limit, [&](const auto& p, const auto& q) {
      const Pair x = x_of(p, q);
      const Pair y = y_of(p, q);
      return x * x + y * y;
    });
  return largest_from_middle(
      points, run, limit * std::sqrt(length),
      [&](const auto& p, const auto& q) { return magnitude(dx * y_of(p, q) - dy * x_of(p, q)); });
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
