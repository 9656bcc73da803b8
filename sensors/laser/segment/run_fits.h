// Least-squares lines through any run of a scan's points, each in constant time.
#pragma once

#include <span>
#include <vector>

#include "sensors/laser/scan_points.h"
#include "sensors/range/reading_run.h"

namespace ilss {

/// The line of least squared distances to some points: those p with normal · (p - centre) = 0.
struct LeastSquaresLine {
  double centre_x = 0;  ///< m, the points' mean
  double centre_y = 0;
  double normal_x = 0;  ///< of length 1
  double normal_y = 1;
  double square = 0;    ///< m², sum of the points' squared distances
  double variance = 0;  ///< m², the mean variance of a point's distance that the noise explains

  double distance(const ScanPoint& point) const {
    return normal_x * (point.x - centre_x) + normal_y * (point.y - centre_y);
  }
};

/// The line through points of a mean and a scatter matrix, the sum of (p - mean) (p - mean)ᵀ; its
/// variance is left 0.
LeastSquaresLine line_of_scatter(double mean_x, double mean_y, double xx, double xy, double yy);

/// Running sums over a cluster's points, and over the covariances of their places,
///   sigma_r² u uᵀ + r² sigma_phi² v vᵀ, u along the beam and v across.
class RunFits {
 public:
  void update(std::span<const ScanPoint> points, const LaserNoise& noise);

  /// The line through a run of at least one point.
  LeastSquaresLine line(const ReadingRun& run) const;

 private:
  struct Sums {
    double x, y, xx, xy, yy, noise_xx, noise_xy, noise_yy;
  };
  std::vector<Sums> sums_;  ///< of the points before each; places from the first point
  double origin_x_ = 0;
  double origin_y_ = 0;
};

/// Moves each boundary between neighbouring runs to where the squared distances to the lines of the
/// two sides are least.
void place_boundaries(const RunFits& fits, std::span<ReadingRun> runs);

}  // namespace ilss
