#include "sensors/laser/features/laser_features.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sensors/laser/features/laser_feature_estimates.h"
#include "sensors/laser/segment/breakpoints.h"

namespace ilss {
namespace {

double cosine_between(const LaserLineFit& a, const LaserLineFit& b) {
  return a.cosine * b.cosine + a.sine * b.sine;
}

struct Place {
  double x;
  double y;
};

/// Where two lines meet: n_a · p = rho_a and n_b · p = rho_b.
Place intersection(const LaserLineFit& a, const LaserLineFit& b) {
  const double determinant = a.cosine * b.sine - a.sine * b.cosine;
  return {(a.rho * b.sine - b.rho * a.sine) / determinant,
          (b.rho * a.cosine - a.rho * b.cosine) / determinant};
}

/// How far a place lies beyond a run's nearer end, in its own direction (m).
double beyond(const Place& place, const LaserLineFit& line, const ScanPoint& first,
              const ScanPoint& last) {
  const auto coordinate = [&](const auto& p) { return line.cosine * p.y - line.sine * p.x; };
  const double a = coordinate(first);
  const double b = coordinate(last);
  const double at = coordinate(place);
  return std::max({at - std::max(a, b), std::min(a, b) - at, 0.0});
}

/// How far a place lies to the left of a beam (m).
double left_of(const ScanPoint& beam, const Place& place) {
  return beam.cosine * place.y - beam.sine * place.x;
}

}  // namespace

void LaserFeatures::Options::declare(OptionVisitor& visit) {
  visit("evidence", model.evidence, "chi² that an arc must save over a line", {.minimum = 0});
  visit("least_radius", model.least_radius, "of an arc", {.unit = "m", .minimum = 0});
  visit("largest_radius", model.largest_radius, "of an arc; 0: no arcs",
        {.unit = "m", .minimum = 0});
  visit("largest_misfit", model.largest_misfit,
        "chi² per degree of freedom above which a segment is neither line nor arc", {.minimum = 1});
  visit("virtual_reach", virtual_reach,
        "from a line's end to a virtual corner on its extension; 0: no virtual corners",
        {.unit = "m", .minimum = 0});
  visit("least_corner_angle", least_corner_angle, "between two lines that make a corner",
        {.unit = "rad", .minimum = 0.01, .maximum = 1.5707963267948966});
  visit("incidence", incidence, "as of `breakpoints`: what counts as a jump at an edge",
        {.unit = "rad", .minimum = 0, .maximum = 1.5707963267948966});
  visit("frame", frame, "name of the robot's frame, x forward and z to the right");
}

Interface LaserFeatures::interface(const Options& options) {
  return {.inputs = {{"scan", &descriptor<SegmentedScan>()}},
          .output = &descriptor<RangeFeatures>(),
          .frame = options.frame};
}

/// Whether two neighbours in the scan meet where the one ends and the other begins.
bool LaserFeatures::is_real_corner(const LaserSegment& before, const LaserSegment& after,
                                   const LaserNoise& noise) const {
  constexpr std::size_t most_missing = 3;
  if (before.arc || after.arc || after.run.begin - before.run.end > most_missing ||
      std::abs(cosine_between(before.line, after.line)) > parallel_)
    return false;
  const ScanPoint& last = scan_.points()[before.run.end - 1];
  const ScanPoint& first = scan_.points()[after.run.begin];
  const Place corner = intersection(before.line, after.line);
  // Between the two beams; or else the beam that lies beyond it is as well of the other line.
  constexpr double largest_residual_of_other = 25;  // squared standard deviations
  const double sense = first.bearing < last.bearing ? -1 : 1;
  if (sense * left_of(last, corner) < 0)
    return squared_residual(after.line, last, noise) < largest_residual_of_other;
  if (sense * left_of(first, corner) > 0)
    return squared_residual(before.line, first, noise) < largest_residual_of_other;
  return true;
}

void LaserFeatures::add_virtual_corners(LaserFeatureWriter& writer) const {
  for (std::size_t b = 1; b < segments_.size(); ++b) {
    if (segments_[b].arc) continue;
    for (std::size_t a = 0; a < b; ++a) {
      if (segments_[a].arc || (a + 1 == b && segments_[b].meets_before)) continue;
      const LaserLineFit& line_a = segments_[a].line;
      const LaserLineFit& line_b = segments_[b].line;
      if (std::abs(cosine_between(line_a, line_b)) > parallel_) continue;
      const Place place = intersection(line_a, line_b);
      if (is_within_reach(place.x, place.y, segments_[a]) &&
          is_within_reach(place.x, place.y, segments_[b]))
        writer.add_corner(a, line_a, b, line_b, CornerKind::virtual_corner);
    }
  }
}

bool LaserFeatures::is_within_reach(double x, double y, const LaserSegment& segment) const {
  const ScanPoint& first = scan_.points()[segment.run.begin];
  const ScanPoint& last = scan_.points()[segment.run.end - 1];
  const double distance = beyond({x, y}, segment.line, first, last);
  return distance <= options_.virtual_reach;
}

/// Takes in readings next to a segment that no segment has and that lie on it: at grazing
/// incidence, pieces of one surface are broken off.
void LaserFeatures::extend(LaserSegment& segment, std::size_t begin, std::size_t end,
                           const LaserNoise& noise, const UncertainBiases& biases) const {
  constexpr double largest_own_residual = 9;  // squared standard deviations
  const auto points = scan_.points();
  const auto lies_on_it = [&](std::size_t i) {
    return points[i].range > 0 &&
           squared_residual(segment, points[i], noise) < largest_own_residual;
  };
  ReadingRun run = segment.run;
  while (run.begin > begin && lies_on_it(run.begin - 1)) --run.begin;
  while (run.end < end && lies_on_it(run.end)) ++run.end;
  if (run == segment.run) return;
  if (auto longer = fit_laser_segment(points, run, noise, options_.model, biases))
    segment = *longer;
}

/// Adds the edges at a line's ends: where the next beam, beyond a breakpoint, is farther.
void LaserFeatures::add_edges(std::size_t index, double deviation,
                              LaserFeatureWriter& writer) const {
  const LaserSegment& segment = segments_[index];
  if (segment.arc) return;
  const auto points = scan_.points();
  BreakpointRule rule(options_.incidence, Breakpoints::Options{}.deviations * deviation);
  const auto add_end = [&](std::size_t end, std::size_t neighbour) {
    const ScanPoint& at = points[end];
    const ScanPoint& other = points[neighbour];
    if (other.range > at.range && rule.breaks(at.range, other.range, other.bearing - at.bearing))
      writer.add_edge(index, segment.line, at, other);
  };
  const bool meets_after = index + 1 < segments_.size() && segments_[index + 1].meets_before;
  if (segment.run.begin > 0 && !segment.meets_before)
    add_end(segment.run.begin, segment.run.begin - 1);
  if (segment.run.end < points.size() && !meets_after)
    add_end(segment.run.end - 1, segment.run.end);
}

void LaserFeatures::fit_all(const LaserNoise& noise, const UncertainBiases& biases) {
  segments_.clear();
  const auto runs = scan_.runs();
  std::size_t free_from = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    auto segment = fit_laser_segment(scan_.points(), runs[i], noise, options_.model, biases);
    if (segment) {
      const bool is_last = i + 1 == runs.size();
      extend(*segment, free_from, is_last ? scan_.points().size() : runs[i + 1].begin, noise,
             biases);
      segments_.push_back(*segment);
    }
    free_from = segment ? segment->run.end : runs[i].end;
  }
}

/// Says how near the segments came to being lines.
Fault LaserFeatures::nothing_fits(const LaserNoise& noise) const {
  double least = INFINITY;
  for (const ReadingRun& run : scan_.runs())
    if (const auto line = fit_laser_line(scan_.points_of(run), noise); line && run.size() > 2)
      least = std::min(least, line->chi_squared / static_cast<double>(run.size() - 2));
  return {
      FaultKind::no_detection,
      fmt::format("none of {} segments is a line or an arc: chi² of a line is {:.3g} a degree of "
                  "freedom or more, largest_misfit is {:g}",
                  scan_.runs().size(), least, options_.model.largest_misfit)};
}

Outcome<> LaserFeatures::evaluate(const Evaluation& evaluation, Output& output) {
  const Estimate& scan = evaluation.input(0);
  const LaserNoise noise = noise_of(scan);
  if (!(noise.range_variance > 0))
    return Fault{FaultKind::no_error_known, "the laser's ranges need a range_std or a quantum"};
  if (auto read = scan_.read(*evaluation.inputs[0]); !read) return read;
  fit_all(noise, uncertain_biases(scan));
  if (segments_.empty()) return nothing_fits(noise);
  LaserFeatureWriter writer(evaluation, noise, output);
  for (std::size_t i = 1; i < segments_.size(); ++i)
    segments_[i].meets_before = is_real_corner(segments_[i - 1], segments_[i], noise);
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    writer.add(i, segments_[i], scan_.points());
    if (segments_[i].meets_before)
      writer.add_corner(i - 1, segments_[i - 1].line, i, segments_[i].line,
                        CornerKind::real_corner);
    add_edges(i, noise.range_deviation(), writer);
  }
  if (options_.virtual_reach > 0) add_virtual_corners(writer);
  writer.finish();
  return {};
}

}  // namespace ilss
