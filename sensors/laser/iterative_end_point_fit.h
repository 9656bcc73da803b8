// Split at the point farthest from the chord, until none is far.
#pragma once

#include "sensors/laser/segmenter.h"

namespace ilss {

/// The iterative end-point fit (Ramer 1972, Duda & Hart 1973): the line through a run's first and
/// last points; where the point farthest from it is farther than `threshold`, the run is split
/// there. The point of a split goes to the piece behind it. n log n for pieces of like length.
class IterativeEndPointFit {
 public:
  static constexpr std::string_view name = "iterative_end_point_fit";
  static constexpr std::string_view description =
      "segmenter: splits runs at the point farthest from the chord";
  static constexpr std::string_view reference = "Núñez et al. 2009, sec. 2.2 (IEPF)";

  struct Options {
    double threshold = 0.05;  ///< m
    void declare(OptionVisitor& visit);
  };

  explicit IterativeEndPointFit(const Options& options) : options_(options) {}

  void segment(std::span<const ScanPoint> points, const LaserNoise& noise,
               std::vector<ReadingRun>& runs);

 private:
  Options options_;
  std::vector<ReadingRun> open_;  ///< a stack: the next run to look at is its last
};

}  // namespace ilss
