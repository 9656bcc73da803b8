#include "sensors/laser/segment/split_and_merge_fuzzy.h"

#include <algorithm>
#include <cmath>

#include "sensors/laser/segment/iterative_end_point_fit.h"

namespace ilss {
namespace {

/// Adds up weighted points for the line through them.
class WeightedLine {
 public:
  explicit WeightedLine(const ScanPoint& origin) : origin_x_(origin.x), origin_y_(origin.y) {}

  void add(const ScanPoint& point, double weight) {
    const double x = point.x - origin_x_;
    const double y = point.y - origin_y_;
    weight_ += weight;
    x_ += weight * x;
    y_ += weight * y;
    xx_ += weight * x * x;
    xy_ += weight * x * y;
    yy_ += weight * y * y;
  }

  LeastSquaresLine line() const {
    return line_of_scatter(origin_x_ + x_ / weight_, origin_y_ + y_ / weight_,
                           xx_ - x_ * x_ / weight_, xy_ - x_ * y_ / weight_,
                           yy_ - y_ * y_ / weight_);
  }

 private:
  double origin_x_, origin_y_;
  double weight_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0, yy_ = 0;
};

}  // namespace

void SplitAndMergeFuzzy::Options::declare(OptionVisitor& visit) {
  visit("dispersion", dispersion, "root mean square distance above which a line is split",
        {.unit = "m", .minimum = 0});
  visit("deviations", deviations,
        "by how many standard deviations the mean square must be above the noise's",
        {.minimum = 0});
  visit("iterations", iterations, "of the fuzzy clustering", {.minimum = 0, .maximum = 1000});
}

double SplitAndMergeFuzzy::excess(const ReadingRun& run) const {
  if (run.size() < 3) return 0;
  const LeastSquaresLine line = fits_.line(run);
  const auto freedom = static_cast<double>(run.size() - 2);
  const double explained = line.variance * (1 + options_.deviations * std::sqrt(2 / freedom));
  const double limit = std::max(options_.dispersion * options_.dispersion, explained);
  const double mean_square = line.square / freedom;
  return limit > 0 ? mean_square / limit : mean_square > 0 ? INFINITY : 0;
}

std::size_t SplitAndMergeFuzzy::fuzzy_split(std::span<const ScanPoint> points,
                                            const ReadingRun& run, std::size_t start) {
  LeastSquaresLine before = fits_.line({run.begin, start});
  LeastSquaresLine after = fits_.line({start, run.end});
  const double floor = std::max(1e-12, fits_.line(run).variance);
  membership_.resize(run.size());
  for (std::int64_t iteration = 0;; ++iteration) {
    WeightedLine first(points[run.begin]);
    WeightedLine second(points[run.begin]);
    for (std::size_t i = run.begin; i < run.end; ++i) {
      const double to_before = before.distance(points[i]);
      const double to_after = after.distance(points[i]);
      const double square_before = to_before * to_before + floor;
      const double square_after = to_after * to_after + floor;
      const double u = square_after / (square_before + square_after);
      membership_[i - run.begin] = u;
      first.add(points[i], u * u);
      second.add(points[i], (1 - u) * (1 - u));
    }
    if (iteration >= options_.iterations) break;
    before = first.line();
    after = second.line();
  }
  // The memberships that a split before reading i leaves right, less those of a split at the start.
  double gain = 0;
  double most = 0;
  std::size_t best = start;
  for (std::size_t i = run.begin; i + 1 < run.end; ++i) {
    gain += 2 * membership_[i - run.begin] - 1;
    if (gain <= most) continue;
    most = gain;
    best = i + 1;
  }
  return best;
}

void SplitAndMergeFuzzy::merge(std::vector<ReadingRun>& runs, std::size_t first) const {
  for (std::size_t k = first; k < runs.size();) {
    const double with_last = k > first ? excess({runs[k - 1].begin, runs[k].end}) : INFINITY;
    const double with_next =
        k + 1 < runs.size() ? excess({runs[k].begin, runs[k + 1].end}) : INFINITY;
    if (std::min(with_last, with_next) > 1) {
      ++k;
      continue;
    }
    const std::size_t from = with_last < with_next ? k - 1 : k;
    runs[from].end = runs[from + 1].end;
    runs.erase(runs.begin() + static_cast<std::ptrdiff_t>(from) + 1);
    k = from > first ? from - 1 : from;  // the fused line may suit the one before it
  }
}

void SplitAndMergeFuzzy::segment(std::span<const ScanPoint> points, const LaserNoise& noise,
                                 std::vector<ReadingRun>& runs) {
  fits_.update(points, noise);
  const std::size_t first = runs.size();
  open_.assign(1, {0, points.size()});
  while (!open_.empty()) {
    const ReadingRun run = open_.back();
    open_.pop_back();
    const std::size_t guess = excess(run) <= 1 ? 0 : farthest_from_chord(points, run, 0);
    if (guess == 0) {
      runs.push_back(run);
      continue;
    }
    const std::size_t split = fuzzy_split(points, run, guess);
    open_.push_back({split, run.end});
    open_.push_back({run.begin, split});
  }
  merge(runs, first);
  place_boundaries(fits_, std::span(runs).subspan(first));
}

}  // namespace ilss
