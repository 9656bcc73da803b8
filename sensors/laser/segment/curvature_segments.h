// From the curvature along a cluster to its segments: what the curvature-based segmenters share.
#pragma once

#include <span>
#include <vector>

#include "framework/module/parameters.h"
#include "sensors/laser/segment/curve_moments.h"
#include "sensors/range/reading_run.h"

namespace ilss {

/// What a corner must be, whatever the curvature was found with.
struct CornerRule {
  double angle = 0.2;        ///< rad
  double deviations = 2.5;   ///< of the angle's noise
  double separation = 0.1;   ///< m
  double roughness = 0.003;  ///< m
  double evidence = 30;
  void declare(OptionVisitor& visit);
};

/// Splits a cluster into segments of homogeneous curvature (Núñez et al. 2006, as in Núñez et al.
/// 2009, sec. 2.3 and 3.1): peaks of the curvature are corners, between them it is flat, about 0 on
/// a line and above on a curve. A curve's noise has peaks, too, so two neighbours stay apart only
/// if one line or one circle explains both worse than one each: chi², by noise and `roughness`,
/// plus ln n for each parameter must be more than `evidence` larger for both as one. At last each
/// corner moves to where the lines or circles beside it fit best.
class CurvatureSegments {
 public:
  explicit CurvatureSegments(const CornerRule& rule) : rule_(rule) {}

  /// Appends the segments of a cluster. `turn`: by how much the contour turns at each reading (rad,
  /// signed, seen over the method's own region of support), `deviation`: its noise.
  void segment(std::span<const ScanPoint> points, const LaserNoise& noise,
               std::span<const double> turn, std::span<const double> deviation,
               std::vector<ReadingRun>& runs);
  /// The same from corners found already: readings in order, each the first behind its corner.
  void segment(std::span<const ScanPoint> points, const LaserNoise& noise,
               std::span<const std::size_t> corners, std::vector<ReadingRun>& runs);

 private:
  void find_peaks(std::span<const ScanPoint> points, std::span<const double> turn,
                  std::span<const double> deviation);
  bool shows_curvature(const ReadingRun& run, const CurveMoments& moments) const;
  /// What a run costs as the line or circle that explains it best.
  double cost(const ReadingRun& run) const;
  /// By how much two neighbours cost less apart than as one.
  double gain(const ReadingRun& before, const ReadingRun& after) const;
  void update_gains();
  bool merges(std::size_t k) const;
  void merge();
  void place_corners();

  CornerRule rule_;
  CurveMomentSums sums_;
  double fourth_moment_ = 0;  ///< of the cluster
  std::vector<std::size_t> corners_;
  std::vector<ReadingRun> segments_;
  std::vector<double> gains_;  ///< of each segment and the next; NaN: to be found again
};

}  // namespace ilss
