#include "sensors/laser/segment/smoothed_contour.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sensors/laser/segment/regions_of_support.h"

namespace ilss {
namespace {

/// Beyond so many scales a Gaussian is as good as 0.
constexpr double kernel_reach = 3;
/// From reading to reading, on average: bounds the samples of a cluster.
constexpr double most_steps = 100;

}  // namespace

void SmoothedContour::average(std::span<const ScanPoint> points) {
  const std::span<const double> lengths = length_.lengths();
  knots_.clear();
  for (std::size_t i = 0; i < points.size();) {
    const double end = lengths[i] + step_;
    Knot sum{};
    const std::size_t begin = i;
    for (; i < points.size() && (i == begin || lengths[i] < end); ++i) {
      sum.length += lengths[i];
      sum.x += points[i].x;
      sum.y += points[i].y;
    }
    const auto count = static_cast<double>(i - begin);
    knots_.push_back({sum.length / count, sum.x / count, sum.y / count});
  }
}

void SmoothedContour::interpolate(std::span<const ScanPoint> points, const LaserNoise& noise) {
  const std::span<const double> lengths = length_.lengths();
  const auto count = 1 + static_cast<std::size_t>(lengths.back() / step_);
  samples_.resize(count);
  std::size_t knot = 0;
  std::size_t reading = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double length = step_ * static_cast<double>(k);
    while (knot + 2 < knots_.size() && knots_[knot + 1].length < length) ++knot;
    while (reading + 1 < points.size() && lengths[reading] < length) ++reading;
    const Knot& a = knots_[knot];
    const Knot& b = knots_[std::min(knot + 1, knots_.size() - 1)];
    const double share = b.length > a.length ? (length - a.length) / (b.length - a.length) : 0;
    const std::size_t left = std::max<std::size_t>(reading, 1) - 1;
    const double spacing = lengths[std::min(left + 1, points.size() - 1)] - lengths[left];
    samples_[k] = {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y),
                   spacing * place_variance(points[reading], noise), reading};
  }
}

void SmoothedContour::update(std::span<const ScanPoint> points, const LaserNoise& noise) {
  length_.update(points, noise);
  samples_.clear();
  if (!std::isfinite(length_.lengths().back())) return;  // nothing to smooth
  step_ = std::max(finest_step_,
                   length_.lengths().back() / (most_steps * static_cast<double>(points.size())));
  average(points);
  interpolate(points, noise);
}

void SmoothedContour::set_scale(double scale) {
  scale_ = scale;
  const auto reach = static_cast<std::size_t>(std::ceil(kernel_reach * scale / step_));
  first_.resize(reach + 1);
  second_.resize(reach + 1);
  double slope = 0;
  double sum = 0;
  double bend = 0;
  for (std::size_t k = 0; k <= reach; ++k) {
    const double length = static_cast<double>(k) * step_;
    const double u = length / scale;
    const double value = std::exp(-u * u / 2);
    first_[k] = value * u;
    second_[k] = value * (u * u - 1);
    slope += 2 * first_[k] * length;
    sum += (k == 0 ? 1 : 2) * second_[k];
    bend += second_[k] * length * length;
  }
  // Sampled and cut off, they still tell a line's slope and a parabola's bend.
  second_[0] -= sum;
  for (double& value : first_) value /= slope;
  for (double& value : second_) value /= bend;
}

SmoothedContour::Sample SmoothedContour::at(std::ptrdiff_t sample) const {
  const auto last = static_cast<std::ptrdiff_t>(samples_.size()) - 1;
  if (sample >= 0 && sample <= last) return samples_[static_cast<std::size_t>(sample)];
  const Sample& end = sample < 0 ? samples_.front() : samples_.back();
  const std::ptrdiff_t mirrored =
      std::clamp<std::ptrdiff_t>(sample < 0 ? -sample : 2 * last - sample, 0, last);
  const Sample& other = samples_[static_cast<std::size_t>(mirrored)];
  return {2 * end.x - other.x, 2 * end.y - other.y, end.variance, end.reading};
}

double SmoothedContour::curvature(std::size_t sample) const {
  const auto reach = static_cast<std::ptrdiff_t>(first_.size()) - 1;
  const auto centre = static_cast<std::ptrdiff_t>(sample);
  double x1 = 0;
  double y1 = 0;
  double x2 = second_[0] * samples_[sample].x;
  double y2 = second_[0] * samples_[sample].y;
  const auto add = [&](std::size_t k, const Sample& before, const Sample& after) {
    x1 += first_[k] * (after.x - before.x);
    y1 += first_[k] * (after.y - before.y);
    x2 += second_[k] * (after.x + before.x);
    y2 += second_[k] * (after.y + before.y);
  };
  const bool is_inside =
      centre >= reach && sample + static_cast<std::size_t>(reach) < samples_.size();
  for (std::ptrdiff_t k = 1; k <= reach; ++k) {
    const auto index = static_cast<std::size_t>(k);
    if (is_inside)
      add(index, samples_[sample - index], samples_[sample + index]);
    else
      add(index, at(centre - k), at(centre + k));
  }
  const double square = x1 * x1 + y1 * y1;
  return square > 0 ? (x1 * y2 - x2 * y1) / (square * std::sqrt(square)) : 0;
}

double SmoothedContour::curvature_deviation(std::size_t sample) const {
  // The integral of the Gaussian's squared second derivative is 3 / (8 sqrt(pi) scale^5).
  const double power = 3 / (8 * std::sqrt(std::numbers::pi) * std::pow(scale_, 5));
  return std::sqrt(samples_[sample].variance * power);
}

}  // namespace ilss
