#include "sensors/laser/segment/curvature_segments.h"

#include <algorithm>
#include <cmath>

#include "sensors/laser/segment/boundary_placement.h"

namespace ilss {
namespace {

double square_distance(const ScanPoint& a, const ScanPoint& b) {
  return (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y);
}

/// The weighted squared distances from the mean.
double scatter(const CurveMoments& moments) {
  return moments.xx + moments.yy - (moments.x * moments.x + moments.y * moments.y) / moments.w;
}

}  // namespace

void CornerRule::declare(OptionVisitor& visit) {
  visit("angle", angle, "a corner turns by at least this", {.unit = "rad", .minimum = 0});
  visit("deviations", deviations, "and by so many standard deviations of what the noise turns",
        {.minimum = 0});
  visit("separation", separation, "corners are at least so far apart", {.unit = "m", .minimum = 0});
  visit("roughness", roughness, "of surfaces, beside the noise: standard deviation",
        {.unit = "m", .minimum = 0});
  visit("evidence", evidence,
        "by how much two segments must explain the readings better than one: twice the logarithm "
        "of the likelihoods' ratio",
        {.minimum = 0});
}

void CurvatureSegments::find_peaks(std::span<const ScanPoint> points, std::span<const double> turn,
                                   std::span<const double> deviation) {
  corners_.clear();
  const double separation = rule_.separation * rule_.separation;
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const double value = std::abs(turn[i]);
    if (value < rule_.angle || value < rule_.deviations * deviation[i]) continue;
    if (value < std::abs(turn[i - 1]) || value <= std::abs(turn[i + 1])) continue;
    const bool is_near =
        !corners_.empty() && square_distance(points[corners_.back()], points[i]) < separation;
    if (!is_near)
      corners_.push_back(i);
    else if (value > std::abs(turn[corners_.back()]))
      corners_.back() = i;
  }
}

bool CurvatureSegments::shows_curvature(const ReadingRun& run, const CurveMoments& moments) const {
  // The fourth moments of a short run are differences of those of the whole cluster: beyond this,
  // nothing of them is left.
  constexpr double precision = 1e-11;
  const double square = scatter(moments);
  return run.size() >= 4 && square * square > precision * moments.w * fourth_moment_;
}

double CurvatureSegments::cost(const ReadingRun& run) const {
  const CurveMoments moments = sums_.of(run.begin, run.end);
  const auto readings = static_cast<double>(run.size());
  const double parameter = std::log(readings);
  const double chi_squared = moments.line_chi_squared();
  // Of a run no longer than the noise, any line is good that runs along the beams.
  constexpr double clear = 10;  // variances
  if (scatter(moments) < clear * readings) return std::max(chi_squared, readings) + 2 * parameter;
  const double line = chi_squared + 2 * parameter;
  // No circle is better than a line that leaves less than another parameter would cost.
  if (line < 3 * parameter || !shows_curvature(run, moments)) return line;
  return std::min(line, moments.circle().chi_squared + 3 * parameter);
}

double CurvatureSegments::gain(const ReadingRun& before, const ReadingRun& after) const {
  return cost({before.begin, after.end}) - cost(before) - cost(after);
}

void CurvatureSegments::update_gains() {
  for (std::size_t k = 0; k < segments_.size(); ++k)
    if (std::isnan(gains_[k]))
      gains_[k] = k + 1 < segments_.size() ? gain(segments_[k], segments_[k + 1]) : INFINITY;
}

bool CurvatureSegments::merges(std::size_t k) const {
  return gains_[k] <= rule_.evidence && (k == 0 || gains_[k] <= gains_[k - 1]) &&
         gains_[k] < gains_[k + 1];
}

void CurvatureSegments::merge() {
  gains_.assign(segments_.size(), NAN);
  // In each round all pairs merge that gain less from being apart than their neighbours do.
  for (std::size_t before = segments_.size() + 1; segments_.size() < before;) {
    update_gains();
    before = segments_.size();
    std::size_t kept = 0;
    for (std::size_t k = 0; k < before; ++k, ++kept) {
      const bool is_first_of_two = merges(k);
      segments_[kept] = segments_[k];
      gains_[kept] = gains_[k];
      if (!is_first_of_two) continue;
      segments_[kept].end = segments_[++k].end;
      gains_[kept] = NAN;
      if (kept > 0) gains_[kept - 1] = NAN;
    }
    segments_.resize(kept);
    gains_.resize(kept);
  }
}

void CurvatureSegments::place_corners() {
  const auto line = [&](const ReadingRun& run) {
    return sums_.of(run.begin, run.end).line_chi_squared();
  };
  const auto arc = [&](const ReadingRun& run) {
    const CurveMoments moments = sums_.of(run.begin, run.end);
    return shows_curvature(run, moments) ? moments.circle().chi_squared : line(run);
  };
  const auto is_arc = [&](const ReadingRun& run) {
    return line(run) - arc(run) > std::log(static_cast<double>(run.size()));
  };
  for (std::size_t k = 0; k + 1 < segments_.size(); ++k) {
    ReadingRun& before = segments_[k];
    ReadingRun& after = segments_[k + 1];
    if (before.size() < 2 || after.size() < 2) continue;
    const bool arcs[2] = {is_arc(before), is_arc(after)};
    const auto cost = [&](bool of_arc) {
      return [&, of_arc](const ReadingRun& run) { return of_arc ? arc(run) : line(run); };
    };
    before.end = after.begin =
        placed_boundary(before, after, boundary_reach, cost(arcs[0]), cost(arcs[1]));
  }
}

void CurvatureSegments::segment(std::span<const ScanPoint> points, const LaserNoise& noise,
                                std::span<const double> turn, std::span<const double> deviation,
                                std::vector<ReadingRun>& runs) {
  find_peaks(points, turn, deviation);
  segment(points, noise, corners_, runs);
}

void CurvatureSegments::segment(std::span<const ScanPoint> points, const LaserNoise& noise,
                                std::span<const std::size_t> corners,
                                std::vector<ReadingRun>& runs) {
  if (corners.empty()) {
    runs.push_back({0, points.size()});
    return;
  }
  sums_.set(points,
            {noise.range_variance + rule_.roughness * rule_.roughness, noise.bearing_variance});
  fourth_moment_ = sums_.of(0, points.size()).qq;
  segments_.clear();
  std::size_t begin = 0;
  for (const std::size_t corner : corners) {
    segments_.push_back({begin, corner});
    begin = corner;
  }
  segments_.push_back({begin, points.size()});
  merge();
  place_corners();
  runs.insert(runs.end(), segments_.begin(), segments_.end());
}

}  // namespace ilss
