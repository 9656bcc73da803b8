#include "sensors/laser/iterative_end_point_fit.h"

namespace ilss {

void IterativeEndPointFit::Options::declare(OptionVisitor& visit) {
  visit("threshold", threshold, "a point farther from the chord splits the run",
        {.unit = "m", .minimum = 0});
}

void IterativeEndPointFit::segment(std::span<const ScanPoint> points, const LaserNoise&,
                                   std::vector<ReadingRun>& runs) {
  open_.assign(1, {0, points.size()});
  while (!open_.empty()) {
    const ReadingRun run = open_.back();
    open_.pop_back();
    const ScanPoint& first = points[run.begin];
    const ScanPoint& last = points[run.end - 1];
    const double dx = last.x - first.x;
    const double dy = last.y - first.y;
    double most = options_.threshold * options_.threshold * (dx * dx + dy * dy);
    std::size_t split = 0;
    for (std::size_t i = run.begin + 1; i + 1 < run.end; ++i) {
      const double across = dx * (points[i].y - first.y) - dy * (points[i].x - first.x);
      if (across * across <= most) continue;
      most = across * across;
      split = i;
    }
    if (split == 0) {
      runs.push_back(run);
      continue;
    }
    open_.push_back({split, run.end});
    open_.push_back({run.begin, split});
  }
}

}  // namespace ilss
