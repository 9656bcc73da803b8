#include "sensors/laser/split_and_merge.h"

#include <algorithm>
#include <cmath>

#include "sensors/laser/boundary_placement.h"
#include "sensors/laser/iterative_end_point_fit.h"

namespace ilss {

void SplitAndMerge::Options::declare(OptionVisitor& visit) {
  visit("threshold", threshold, "a point farther from the run's line splits it",
        {.unit = "m", .minimum = 0});
  visit("deviations", deviations, "the threshold is at least so many standard deviations",
        {.minimum = 0});
}

bool SplitAndMerge::fits(std::span<const ScanPoint> points, const ReadingRun& run) const {
  const LeastSquaresLine line = fits_.line(run);
  const double limit =
      std::max(options_.threshold, options_.deviations * std::sqrt(line.variance));
  double farthest = 0;
  for (std::size_t i = run.begin; i < run.end; ++i)
    farthest = std::max(farthest, std::abs(line.distance(points[i])));
  return farthest <= limit;
}

void SplitAndMerge::merge(std::span<const ScanPoint> points, const ReadingRun& run,
                          std::vector<ReadingRun>& runs, std::size_t first) const {
  runs.push_back(run);
  while (runs.size() >= first + 2) {
    const ReadingRun& last = runs.back();
    const ReadingRun both{runs[runs.size() - 2].begin, last.end};
    if (!fits(points, both)) return;
    runs.pop_back();
    runs.back() = both;
  }
}

void SplitAndMerge::segment(std::span<const ScanPoint> points, const LaserNoise& noise,
                            std::vector<ReadingRun>& runs) {
  fits_.update(points, noise);
  const std::size_t first = runs.size();
  open_.assign(1, {0, points.size()});
  while (!open_.empty()) {
    const ReadingRun run = open_.back();
    open_.pop_back();
    const std::size_t split =
        run.size() < 3 || fits(points, run) ? 0 : farthest_from_chord(points, run, 0);
    if (split == 0) {
      merge(points, run, runs, first);
      continue;
    }
    open_.push_back({split, run.end});
    open_.push_back({run.begin, split});
  }
  const auto cost = [&](const ReadingRun& run) { return fits_.line(run).square; };
  for (std::size_t k = first; k + 1 < runs.size(); ++k) {
    if (runs[k].size() < 2 || runs[k + 1].size() < 2) continue;
    runs[k].end = runs[k + 1].begin =
        placed_boundary(runs[k], runs[k + 1], boundary_reach, cost, cost);
  }
}

}  // namespace ilss
