#include "sensors/laser/features/laser_segment.h"

#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

bool is_believable(const LaserArcFit& arc, const LaserModelRule& rule) {
  const double radius = std::abs(arc.radius);
  return radius >= rule.least_radius && radius <= rule.largest_radius &&
         arc.covariance(2, 2) < radius * radius / 4;
}

/// The chi² up to which so many readings are a line or an arc of so many parameters.
double most_chi_squared(std::size_t readings, std::size_t parameters, const LaserModelRule& rule) {
  if (readings <= parameters) return INFINITY;
  return rule.largest_misfit * static_cast<double>(readings - parameters);
}

bool fits(double chi_squared, std::size_t readings, std::size_t parameters,
          const LaserModelRule& rule) {
  return chi_squared <= most_chi_squared(readings, parameters, rule);
}

/// What an arc must keep to if it is to be chosen over the line, if there is one.
ArcLimits limits_of(const std::optional<LaserLineFit>& line, std::size_t readings,
                    const LaserModelRule& rule) {
  double most = most_chi_squared(readings, 3, rule);
  if (line) most = std::min(most, line->chi_squared - rule.evidence);
  return {rule.least_radius, rule.largest_radius, most};
}

/// Whether a run that a line was fitted to may be an arc instead: it is bent, and about as much or
/// so much that a parabola's curvature says nothing.
bool may_be_arc(const LaserLineFit& line, const LaserModelRule& rule) {
  constexpr double margin = 2;  // a parabola's curvature is not quite a circle's
  return line.bend > rule.evidence && (line.bend_radius < margin * rule.largest_radius ||
                                       !fits(line.chi_squared, line.readings, 2, rule));
}

}  // namespace

std::optional<LaserSegment> fit_laser_segment(std::span<const ScanPoint> scan,
                                              const ReadingRun& run, const LaserNoise& noise,
                                              const LaserModelRule& rule,
                                              const UncertainBiases& biases) {
  const auto points = scan.subspan(run.begin, run.size());
  auto line = fit_laser_line(points, noise, biases);
  if (rule.largest_radius > 0 && (!line || may_be_arc(*line, rule))) {
    const auto arc = fit_laser_arc(points, noise, biases, limits_of(line, points.size(), rule));
    if (arc && is_believable(*arc, rule) &&
        (!line || line->chi_squared - arc->chi_squared > rule.evidence) &&
        fits(arc->chi_squared, points.size(), 3, rule))
      return LaserSegment{run, {}, arc};
  }
  constexpr double largest_direction_std = 0.15;  // rad: beyond, first order does not hold
  if (!line || !fits(line->chi_squared, points.size(), 2, rule) ||
      line->covariance(1, 1) > largest_direction_std * largest_direction_std)
    return std::nullopt;
  if (line->bend > rule.evidence) line->covariance += line->bend_covariance;
  return LaserSegment{run, *line, {}};
}

double squared_residual(const LaserSegment& segment, const ScanPoint& p, const LaserNoise& noise) {
  return segment.arc ? squared_residual(*segment.arc, p, noise)
                     : squared_residual(segment.line, p, noise);
}

}  // namespace ilss
