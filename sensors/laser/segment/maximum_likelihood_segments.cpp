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

/// The cost of a piece as the better of line and arc, and what chi² longer ones have at least:
/// theirs may be an arc where this one's is not yet told.
double MaximumLikelihoodSegments::least_chi_squared(std::size_t begin, std::size_t end,
                                                    double& cost) const {
  const CurveMoments moments = sums_.of(begin, end);
  const double line = moments.line_chi_squared();
  cost = line + options_.line_cost;
  if (!(options_.largest_radius > 0)) return line;
  constexpr std::size_t least_of_arc = 6;
  if (line <= options_.arc_cost - options_.line_cost || end - begin < least_of_arc) return 0;
  const CircleCost circle = moments.circle();
  if (circle.radius >= options_.least_radius && circle.radius <= options_.largest_radius)
    cost = std::min(cost, circle.chi_squared + options_.arc_cost);
  return std::min(line, circle.chi_squared);
}

void MaximumLikelihoodSegments::solve(std::size_t readings) {
  const auto stride = static_cast<std::size_t>(options_.stride);
  ends_.assign(1, 0);
  while (ends_.back() < readings) ends_.push_back(std::min(ends_.back() + stride, readings));
  solutions_.assign(1, {0, 0, false});
  beginnings_.assign(1, 0);
  constexpr std::size_t least_of_segment = 3;
  for (std::size_t at = 1; at < ends_.size(); ++at) {
    const std::size_t end = ends_[at];
    const auto left_over = static_cast<double>(end - ends_[at - 1]);
    Solution best{solutions_[at - 1].cost + left_over * options_.outlier_cost, at - 1, false};
    std::size_t kept = 0;
    for (const std::size_t from : beginnings_) {
      const std::size_t begin = ends_[from];
      double least = 0;
      if (end - begin >= least_of_segment) {
        double cost = 0;
        least = least_chi_squared(begin, end, cost);
        const double total = solutions_[from].cost + cost;
        if (total < best.cost) best = {total, from, true};
      }
      // What is already worse than the best, without the cost of a segment, stays so.
      if (solutions_[from].cost + least <= best.cost) beginnings_[kept++] = from;
    }
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

/// What a run costs by its exact fit; infinite where it has none.
double MaximumLikelihoodSegments::exact_cost(std::span<const ScanPoint> points,
                                             const LaserNoise& noise, const ReadingRun& run) const {
  const auto fit = fit_laser_segment(points, run, noise, model(), {});
  if (!fit) return INFINITY;
  return fit->arc ? fit->arc->chi_squared + options_.arc_cost
                  : fit->line.chi_squared + options_.line_cost;
}

/// Joins neighbours that are cheaper as one: the sums by which they were parted are not quite
/// exact.
void MaximumLikelihoodSegments::join(std::span<const ScanPoint> points, const LaserNoise& noise,
                                     std::size_t first, std::vector<ReadingRun>& runs) const {
  for (std::size_t i = first; i + 1 < runs.size();) {
    const ReadingRun both{runs[i].begin, runs[i + 1].end};
    const std::size_t between = runs[i + 1].begin - runs[i].end;
    const double apart = exact_cost(points, noise, runs[i]) +
                         exact_cost(points, noise, runs[i + 1]) +
                         static_cast<double>(between) * options_.outlier_cost;
    if (between <= most_between && exact_cost(points, noise, both) < apart) {
      runs[i] = both;
      runs.erase(runs.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    } else {
      ++i;
    }
  }
}

void MaximumLikelihoodSegments::move_ends(std::span<const ScanPoint> points,
                                          const LaserNoise& noise,
                                          std::span<ReadingRun> runs) const {
  constexpr int rounds = 2;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i + 1 < runs.size(); ++i) {
      ReadingRun& a = runs[i];
      ReadingRun& b = runs[i + 1];
      if (b.begin - a.end > most_between || a.size() < 4 || b.size() < 4) continue;
      const auto fit_a = fit_laser_segment(points, a, noise, model(), {});
      const auto fit_b = fit_laser_segment(points, b, noise, model(), {});
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
  const std::size_t before = runs.size();
  for (std::size_t at = ends_.size() - 1; at > 0; at = solutions_[at].begin)
    if (solutions_[at].is_segment) runs.push_back({ends_[solutions_[at].begin], ends_[at]});
  std::reverse(runs.begin() + static_cast<std::ptrdiff_t>(before), runs.end());
  move_ends(points, noise, std::span(runs).subspan(before));
  join(points, noise, before, runs);
}

}  // namespace ilss
