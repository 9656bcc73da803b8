#include "sensors/laser/segment/maximum_likelihood_segments.h"

#include <algorithm>
#include <cmath>

#include "sensors/laser/features/laser_segment.h"

namespace ilss {
void MaximumLikelihoodSegments::Options::declare(OptionVisitor& visit) {
  visit("line_cost", line_cost, "chi² that a line must save", {.minimum = 1});
  visit("arc_cost", arc_cost, "chi² that an arc must save", {.minimum = 1});
  visit("outlier_cost", outlier_cost, "chi² that a reading may cost before it is left over",
        {.minimum = 1});
  visit("least_radius", least_radius, "of an arc", {.unit = "m", .minimum = 0});
  visit("largest_radius", largest_radius, "of an arc; 0: no arcs", {.unit = "m", .minimum = 0});
  visit("stride", stride, "readings from one place where a segment may end to the next",
        {.minimum = 1, .maximum = 100});
}

/// Takes the piece from a solution to `at` as the last one where that is the best yet. Whether a
/// piece that begins there may still be the best of a longer one: what is already worse than the
/// best, without the cost of a segment, stays so.
bool MaximumLikelihoodSegments::consider(std::size_t from, std::size_t at, Solution& best) const {
  const double before = solutions_[from].cost;
  const std::size_t readings = ends_[at] - ends_[from];
  constexpr std::size_t least_of_segment = 3;
  if (readings < least_of_segment) return before <= best.cost;
  const auto take = [&](double cost) {
    if (before + cost < best.cost) best = {before + cost, from, true};
  };
  const double line = sums_.of(ends_[from], ends_[at]).line_chi_squared();
  take(line + options_.line_cost);
  if (!(options_.largest_radius > 0)) return before + line <= best.cost;
  // A longer one may be an arc where this one's is not yet told.
  constexpr std::size_t least_of_arc = 6;
  if (line <= options_.arc_cost - options_.line_cost || readings < least_of_arc)
    return before <= best.cost;
  // The circle is needed as far as it can be the best piece, or the line alone is too bad.
  const double left = best.cost - before;
  const bool is_good_as_line = before + line <= best.cost;
  const double enough = is_good_as_line ? left - options_.arc_cost : left;
  if (is_good_as_line && enough <= 0) return true;
  const CircleCost circle = sums_.of(ends_[from], ends_[at]).circle(enough);
  if (circle.radius >= options_.least_radius && circle.radius <= options_.largest_radius)
    take(circle.chi_squared + options_.arc_cost);
  return before + std::min(line, circle.chi_squared) <= best.cost;
}

void MaximumLikelihoodSegments::solve(std::size_t readings) {
  const auto stride = static_cast<std::size_t>(options_.stride);
  ends_.assign(1, 0);
  while (ends_.back() < readings) ends_.push_back(std::min(ends_.back() + stride, readings));
  solutions_.assign(1, {0, 0, false});
  beginnings_.assign(1, 0);
  for (std::size_t at = 1; at < ends_.size(); ++at) {
    const auto left_over = static_cast<double>(ends_[at] - ends_[at - 1]);
    Solution best{solutions_[at - 1].cost + left_over * options_.outlier_cost, at - 1, false};
    std::size_t kept = 0;
    for (const std::size_t from : beginnings_)
      if (consider(from, at, best)) beginnings_[kept++] = from;
    beginnings_.resize(kept);
    solutions_.push_back(best);
    beginnings_.push_back(at);
  }
}

/// Neighbours between which so few readings are left over may change hands or be one.
constexpr std::size_t most_between = 3;

LaserModelRule MaximumLikelihoodSegments::model() const {
  return {.evidence = options_.arc_cost - options_.line_cost,
          .least_radius = options_.least_radius,
          .largest_radius = options_.largest_radius,
          .largest_misfit = INFINITY};
}

MaximumLikelihoodSegments::FittedRun MaximumLikelihoodSegments::fit(
    std::span<const ScanPoint> points, const LaserNoise& noise, const ReadingRun& run) const {
  return {run, fit_laser_segment(points, run, noise, model(), {})};
}

/// The exact fit of run i, anew where the run has changed.
const std::optional<LaserSegment>& MaximumLikelihoodSegments::fit_of(
    std::span<const ScanPoint> points, const LaserNoise& noise, std::span<const ReadingRun> runs,
    std::size_t i) {
  if (!(fits_[i].run == runs[i])) fits_[i] = fit(points, noise, runs[i]);
  return fits_[i].fit;
}

/// What a run costs by its exact fit; infinite where it has none.
double MaximumLikelihoodSegments::exact_cost(const std::optional<LaserSegment>& fit) const {
  if (!fit) return INFINITY;
  return fit->arc ? fit->arc->chi_squared + options_.arc_cost
                  : fit->line.chi_squared + options_.line_cost;
}

/// Joins neighbours that are cheaper as one: the sums by which they were parted are not quite
/// exact.
void MaximumLikelihoodSegments::join(std::span<const ScanPoint> points, const LaserNoise& noise,
                                     std::vector<ReadingRun>& runs) {
  for (std::size_t i = 0; i + 1 < runs.size();) {
    const std::size_t between = runs[i + 1].begin - runs[i].end;
    if (between > most_between) {
      ++i;
      continue;
    }
    const double apart = exact_cost(fit_of(points, noise, runs, i)) +
                         exact_cost(fit_of(points, noise, runs, i + 1)) +
                         static_cast<double>(between) * options_.outlier_cost;
    const ReadingRun whole{runs[i].begin, runs[i + 1].end};
    const ArcLimits limits{options_.least_radius, options_.largest_radius,
                           apart - options_.arc_cost};
    const FittedRun both = exceeds_as_line_and_arc(points.subspan(whole.begin, whole.size()), noise,
                                                   apart - options_.line_cost, limits)
                               ? FittedRun{whole, {}}
                               : fit(points, noise, whole);
    if (exact_cost(both.fit) < apart) {
      const auto next = static_cast<std::ptrdiff_t>(i) + 1;
      runs[i] = both.run;
      runs.erase(runs.begin() + next);
      fits_[i] = both;
      fits_.erase(fits_.begin() + next);
    } else {
      ++i;
    }
  }
}

void MaximumLikelihoodSegments::move_ends(std::span<const ScanPoint> points,
                                          const LaserNoise& noise, std::span<ReadingRun> runs) {
  constexpr int rounds = 2;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i + 1 < runs.size(); ++i) {
      ReadingRun& a = runs[i];
      ReadingRun& b = runs[i + 1];
      if (b.begin - a.end > most_between || a.size() < 4 || b.size() < 4) continue;
      const auto& fit_a = fit_of(points, noise, runs, i);
      const auto& fit_b = fit_of(points, noise, runs, i + 1);
      if (!fit_a || !fit_b) continue;
      // Up to half of either may change hands.
      const std::size_t first = a.end - std::min<std::size_t>(a.size() / 2, 20);
      const std::size_t last = b.begin + std::min<std::size_t>(b.size() / 2, 20);
      double cost = 0;
      double least = 0;
      std::size_t best = first;
      for (std::size_t k = first; k < last; ++k) {
        cost += std::min(squared_residual(*fit_a, points[k], noise), options_.outlier_cost) -
                std::min(squared_residual(*fit_b, points[k], noise), options_.outlier_cost);
        if (cost >= least) continue;
        least = cost;
        best = k + 1;
      }
      a.end = best;
      b.begin = best;
    }
  }
}

void MaximumLikelihoodSegments::segment(std::span<const ScanPoint> points, const LaserNoise& stated,
                                        std::vector<ReadingRun>& runs) {
  LaserNoise noise = stated;
  constexpr double least_deviation = 1e-4;  // m: exact readings would weigh without bound
  noise.range_variance = std::max(noise.range_variance, least_deviation * least_deviation);
  sums_.set(points, noise);
  solve(points.size());
  found_.clear();
  for (std::size_t at = ends_.size() - 1; at > 0; at = solutions_[at].begin)
    if (solutions_[at].is_segment) found_.push_back({ends_[solutions_[at].begin], ends_[at]});
  std::reverse(found_.begin(), found_.end());
  fits_.assign(found_.size(), {});
  move_ends(points, noise, found_);
  join(points, noise, found_);
  runs.insert(runs.end(), found_.begin(), found_.end());
}

}  // namespace ilss
