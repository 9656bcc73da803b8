// Split at the point farthest from the chord, until none is far.
#pragma once

#include "sensors/laser/segment/segmenter.h"

namespace ilss {

/// The iterative end-point fit (Ramer 1972, Duda & Hart 1973): the line through a run's first and
/// last points; where the point farthest from it is farther than `threshold` and than `deviations`
/// times the noise, the run is split there. Where the run returns to where it began, distances are
/// taken from that point. The point of a split goes to the piece behind it. Of points that are as
/// far, the one nearest to the run's middle counts: a staircase costs n log n, too.
class IterativeEndPointFit {
 public:
  static constexpr std::string_view name = "iterative_end_point_fit";
  static constexpr std::string_view description =
      "segmenter: splits runs at the point farthest from the chord";
  static constexpr std::string_view reference = "Núñez et al. 2009, sec. 2.2 (IEPF)";

  struct Options {
    double threshold = 0.05;  ///< m
    double deviations = 4.5;
    void declare(OptionVisitor& visit);
  };

  explicit IterativeEndPointFit(const Options& options) : options_(options) {}

  void segment(std::span<const ScanPoint> points, const LaserNoise& noise,
               std::vector<ReadingRun>& runs);

 private:
  Options options_;
  std::vector<ReadingRun> open_;  ///< a stack: the next run to look at is its last
};

/// The reading of `run` that is farthest from the line through its first and last points, or from
/// the first where the last is within `limit` (m) of it; 0 where none is farther than `limit`.
std::size_t farthest_from_chord(std::span<const ScanPoint> points, const ReadingRun& run,
                                double limit);

}  // namespace ilss
