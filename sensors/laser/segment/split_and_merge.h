// Split where a least-squares line does not fit, then merge neighbours that one line fits.
#pragma once

#include "sensors/laser/segment/run_fits.h"
#include "sensors/laser/segment/segmenter.h"

namespace ilss {

/// Split and merge (Pavlidis & Horowitz 1974): the line of least squares through a run; where a
/// point is farther from it than `threshold` and than `deviations` times the noise across it, the
/// run is split. At a corner the ends of the run are as far from its line as the corner is, so that
/// the point of the split is the farthest one in measure of the line between the two ends.
/// Neighbours are merged from left to right as long as no point is farther from their common line
/// than that, and at last each boundary moves to where the squared distances to the two lines are
/// least.
class SplitAndMerge {
 public:
  static constexpr std::string_view name = "split_and_merge";
  static constexpr std::string_view description =
      "segmenter: splits runs that no least-squares line fits, merges neighbours that one fits";
  static constexpr std::string_view reference = "Núñez et al. 2009, sec. 2.2 (SM)";

  struct Options {
    double threshold = 0.03;  ///< m
    double deviations = 4.5;
    void declare(OptionVisitor& visit);
  };

  explicit SplitAndMerge(const Options& options) : options_(options) {}

  void segment(std::span<const ScanPoint> points, const LaserNoise& noise,
               std::vector<ReadingRun>& runs);

 private:
  /// Whether no point of the run is far from the line of least squares through it.
  bool fits(std::span<const ScanPoint> points, const ReadingRun& run) const;
  /// Splits the whole cluster into runs, merged.
  void split(std::span<const ScanPoint> points);
  /// Appends a run to the merged ones, and merges it with those before it while one line fits.
  void append_merged(std::span<const ScanPoint> points, const ReadingRun& run);

  Options options_;
  RunFits fits_;
  std::vector<ReadingRun> open_;    ///< a stack: the next run to look at is its last
  std::vector<ReadingRun> merged_;  ///< in order
};

}  // namespace ilss
