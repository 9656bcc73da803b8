// The length along a scan's contour, which noise makes longer than the surface is.
#pragma once

#include <span>
#include <vector>

#include "sensors/laser/scan_points.h"

namespace ilss {

/// The length of a cluster's contour up to each reading. From reading to reading noise adds more
/// than surfaces have, so the contour is walked in steps of at least `ruler` deviations of a
/// reading's place; in a step the length grows evenly. A step of length l is longer by about
/// sigma² / l than without noise; `excess` adds that up.
class ContourLength {
 public:
  explicit ContourLength(double ruler) : ruler_(ruler) {}
  void update(std::span<const ScanPoint> points, const LaserNoise& noise);

  std::span<const double> lengths() const { return lengths_; }  ///< m, from the first reading
  std::span<const double> excess() const { return excess_; }    ///< m, of them the noise's share

 private:
  double ruler_;
  std::vector<double> lengths_, excess_;
};

}  // namespace ilss
