// Segments by curvature from the contour smoothed at several scales.
#pragma once

#include "sensors/laser/segment/curvature_segments.h"
#include "sensors/laser/segment/segmenter.h"
#include "sensors/laser/segment/smoothed_contour.h"

namespace ilss {

/// Curvature scale space (Mokhtarian & Mackworth 1986). The contour, by its length, is smoothed
/// with Gaussians. Corners are extrema of the curvature at the coarsest scale; each is followed
/// through finer scales, every one 1/sqrt(2) of the one before, to where it is at the finest. The
/// turn at such an extremum is its curvature by that of a corner of 1 rad, 1 / (sqrt(2 pi) scale).
class CurvatureScaleSpace {
 public:
  static constexpr std::string_view name = "curvature_scale_space";
  static constexpr std::string_view description =
      "segmenter: splits at extrema of the curvature, found at a coarse scale, placed at a fine "
      "one";
  static constexpr std::string_view reference =
      "Mokhtarian & Mackworth 1986, as in Núñez et al. 2009, sec. 2.3 (CSS)";

  struct Options {
    double coarse = 0.15;  ///< m
    double fine = 0.05;    ///< m
    CornerRule corners = {};
    void declare(OptionVisitor& visit);
  };

  explicit CurvatureScaleSpace(const Options& options)
      : options_(options), contour_(options.fine / 2), segments_(options.corners) {}

  void segment(std::span<const ScanPoint> points, const LaserNoise& noise,
               std::vector<ReadingRun>& runs);

 private:
  void find_extrema();
  /// Where the extremum near a sample is at the scale that is set.
  std::size_t followed(std::size_t sample, double scale) const;

  Options options_;
  SmoothedContour contour_;
  CurvatureSegments segments_;
  std::vector<double> curvature_;
  std::vector<std::size_t> extrema_;  ///< samples of the contour, then readings
};

}  // namespace ilss
