// A cluster's contour smoothed at a scale, and how it bends there.
#pragma once

#include <span>
#include <vector>

#include "sensors/laser/segment/contour_length.h"

namespace ilss {

/// A cluster's contour at even steps of its length, ready to be smoothed with a Gaussian of any
/// standard deviation, the scale. Where readings are denser than the steps, they are averaged. At
/// its ends the contour goes on as its reflection in the end point: a line stays a line.
class SmoothedContour {
 public:
  /// `step` in m; longer where readings are more than 100 steps apart.
  explicit SmoothedContour(double step) : finest_step_(step), step_(step), length_(ruler) {}

  void update(std::span<const ScanPoint> points, const LaserNoise& noise);

  std::size_t size() const { return samples_.size(); }
  double step() const { return step_; }  ///< m, from sample to sample
  /// The first reading that is not before a sample.
  std::size_t reading(std::size_t sample) const { return samples_[sample].reading; }

  /// Smooths at a scale (m) from now on.
  void set_scale(double scale);
  /// The signed curvature at a sample (1/m),
  ///   (x' y'' - x'' y') / (x'² + y'²)^(3/2),
  /// from the contour's convolution with the derivatives of the Gaussian.
  double curvature(std::size_t sample) const;
  /// The noise's standard deviation of it (1/m).
  double curvature_deviation(std::size_t sample) const;

 private:
  struct Sample {
    double x, y;
    double variance;  ///< m³: of a reading's place, times the length that it stands for
    std::size_t reading;
  };
  struct Knot {
    double length, x, y;
  };
  void average(std::span<const ScanPoint> points);
  void interpolate(std::span<const ScanPoint> points, const LaserNoise& noise);
  Sample at(std::ptrdiff_t sample) const;

  static constexpr double ruler = 4;  // deviations of a reading
  double finest_step_;
  double step_;
  double scale_ = 0;
  ContourLength length_;
  std::vector<Knot> knots_;
  std::vector<Sample> samples_;
  std::vector<double> first_,
      second_;  ///< the Gaussian's derivatives at 1, 2, ... steps; at 0 first
};

}  // namespace ilss
