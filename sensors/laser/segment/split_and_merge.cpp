#include "sensors/laser/segment/split_and_merge.h"

#include <algorithm>
#include <cmath>

#include "sensors/laser/segment/iterative_end_point_fit.h"

namespace ilss {

void SplitAndMerge::Options::declare(OptionVisitor& visit) {
  visit("threshold", threshold, "a point farther from the run's line splits it",
        {.unit = "m", .minimum = 0});
  visit("deviations", deviations, "the threshold is at least so many standard deviations",
        {.minimum = 0});
}

bool SplitAndMerge::fits(std::span<const ScanPoint> points, const ReadingRun& run) const {
  const LeastSquaresLine line = fits_.line(run);
  const double limit = std::max(options_.threshold, options_.deviations * std::sqrt(line.variance));
  double farthest = 0;
  for (std::size_t i = run.begin; i < run.end; ++i)
    farthest = std::max(farthest, std::abs(line.distance(points[i])));
  return farthest <= limit;
}

void SplitAndMerge::append_merged(std::span<const ScanPoint> points, const ReadingRun& run) {
  merged_.push_back(run);
  while (merged_.size() > 1) {
    const ReadingRun both{merged_[merged_.size() - 2].begin, run.end};
    if (!fits(points, both)) return;
    merged_.pop_back();
    merged_.back() = both;
  }
}

void SplitAndMerge::split(std::span<const ScanPoint> points) {
  merged_.clear();
  open_.assign(1, {0, points.size()});
  while (!open_.empty()) {
    const ReadingRun run = open_.back();
    open_.pop_back();
    const std::size_t split =
        run.size() < 3 || fits(points, run) ? 0 : farthest_from_chord(points, run, 0);
    if (split == 0) {
      append_merged(points, run);
      continue;
    }
    open_.push_back({split, run.end});
    open_.push_back({run.begin, split});
  }
}

void SplitAndMerge::segment(std::span<const ScanPoint> points, const LaserNoise& noise,
                            std::vector<ReadingRun>& runs) {
  fits_.update(points, noise);
  split(points);
  place_boundaries(fits_, merged_);
  // What a boundary has left may now belong to its neighbour.
  std::swap(open_, merged_);
  merged_.clear();
  for (const ReadingRun& run : open_) append_merged(points, run);
  if (merged_.size() < open_.size()) place_boundaries(fits_, merged_);
  runs.insert(runs.end(), merged_.begin(), merged_.end());
}

}  // namespace ilss
