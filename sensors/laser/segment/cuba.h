// Segments by curvature from vectors whose length fits the scan: adaptive curvature.
#pragma once

#include "sensors/laser/segment/contour_length.h"
#include "sensors/laser/segment/curvature_segments.h"
#include "sensors/laser/segment/regions_of_support.h"
#include "sensors/laser/segment/segmenter.h"

namespace ilss {

/// Adaptive curvature (CUBA). The support of reading i forwards is the largest k for which the
/// contour is hardly longer than its chord,
///   l(i, i + k) - |p_{i+k} - p_i| <= U_k,
/// backwards likewise; U_k is `excess` and twice what noise adds to the contour's length, which is
/// walked in steps of `ruler` deviations of a reading's place. The curvature index is that of the
/// angle between the vectors f_i and b_i from i to its support's ends, (1 + cos(f_i, b_i)) / 2: 0
/// on a line, 1 where the contour turns back; here it is taken as the angle by which the contour
/// turns.
class Cuba {
 public:
  static constexpr std::string_view name = "cuba";
  static constexpr std::string_view description =
      "segmenter: splits at peaks of the curvature, from vectors of adaptive length";
  static constexpr std::string_view reference =
      "Núñez et al. 2006 and 2008, as in Núñez et al. 2009, sec. 3.1 (CUBA)";

  struct Options {
    double excess = 0.01;  ///< m
    double ruler = 4;
    SupportRule support = {};
    CornerRule corners = {};
    void declare(OptionVisitor& visit);
  };

  explicit Cuba(const Options& options)
      : options_(options),
        lengths_(options.ruler),
        regions_(options.support),
        segments_(options.corners) {}

  void segment(std::span<const ScanPoint> points, const LaserNoise& noise,
               std::vector<ReadingRun>& runs);

  /// Where each reading's support ends, of the last cluster.
  const RegionsOfSupport& regions() const { return regions_; }
  /// Whether the contour between two of its readings is hardly longer than its chord.
  bool supports(std::size_t from, std::size_t to) const;

 private:
  Options options_;
  ContourLength lengths_;
  RegionsOfSupport regions_;
  CurvatureSegments segments_;
  std::span<const ScanPoint> points_;
  std::vector<double> turn_, deviation_;
};

}  // namespace ilss
