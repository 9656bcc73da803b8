#include "sensors/laser/segment/curvature_scale_space.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace ilss {
namespace {

/// The turn of a corner by its curvature at a scale, for a scale of 1.
const double turn_of_curvature = std::sqrt(2 * std::numbers::pi);

}  // namespace

void CurvatureScaleSpace::Options::declare(OptionVisitor& visit) {
  visit("coarse", coarse, "scale at which corners are found", {.unit = "m", .minimum = 0.001});
  visit("fine", fine, "scale at which corners are placed", {.unit = "m", .minimum = 0.001});
  visit("corners", corners, "what a corner must be");
  visit.require(fine <= coarse, "fine must not be more than coarse");
}

void CurvatureScaleSpace::find_extrema() {
  contour_.set_scale(options_.coarse);
  curvature_.resize(contour_.size());
  for (std::size_t k = 0; k < contour_.size(); ++k) curvature_[k] = contour_.curvature(k);
  extrema_.clear();
  const double factor = turn_of_curvature * options_.coarse;
  for (std::size_t k = 1; k + 1 < contour_.size(); ++k) {
    const double value = std::abs(curvature_[k]);
    if (value < std::abs(curvature_[k - 1]) || value <= std::abs(curvature_[k + 1])) continue;
    if (value * factor < options_.corners.angle ||
        value < options_.corners.deviations * contour_.curvature_deviation(k))
      continue;
    const bool is_near =
        !extrema_.empty() &&
        static_cast<double>(k - extrema_.back()) * contour_.step() < options_.corners.separation;
    if (!is_near)
      extrema_.push_back(k);
    else if (value > std::abs(curvature_[extrema_.back()]))
      extrema_.back() = k;
  }
}

std::size_t CurvatureScaleSpace::followed(std::size_t sample, double scale) const {
  const auto reach = static_cast<std::size_t>(std::ceil(scale / contour_.step()));
  const double sign = std::copysign(1.0, curvature_[sample]);
  double most = -std::numeric_limits<double>::infinity();
  std::size_t best = sample;
  const std::size_t first = sample - std::min(sample, reach);
  const std::size_t last = std::min(sample + reach, contour_.size() - 1);
  for (std::size_t k = first; k <= last; ++k) {
    const double value = sign * contour_.curvature(k);
    if (value <= most) continue;
    most = value;
    best = k;
  }
  return best;
}

void CurvatureScaleSpace::segment(std::span<const ScanPoint> points, const LaserNoise& noise,
                                  std::vector<ReadingRun>& runs) {
  contour_.update(points, noise);
  find_extrema();
  for (double scale = options_.coarse; scale > options_.fine && !extrema_.empty();) {
    scale = std::max(options_.fine, scale / std::numbers::sqrt2);
    contour_.set_scale(scale);
    for (std::size_t& extremum : extrema_) extremum = followed(extremum, scale);
  }
  for (std::size_t& extremum : extrema_) extremum = contour_.reading(extremum);
  // Two may have come together, or to an end of the cluster.
  std::sort(extrema_.begin(), extrema_.end());
  std::erase_if(extrema_, [&](std::size_t i) { return i == 0 || i + 1 >= points.size(); });
  extrema_.erase(std::unique(extrema_.begin(), extrema_.end()), extrema_.end());
  segments_.segment(points, noise, std::span<const std::size_t>(extrema_), runs);
}

}  // namespace ilss
