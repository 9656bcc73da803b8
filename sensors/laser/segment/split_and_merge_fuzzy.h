// Split by two fuzzy lines where the scatter is too large for one, then merge neighbours.
#pragma once

#include "sensors/laser/segment/run_fits.h"
#include "sensors/laser/segment/segmenter.h"

namespace ilss {

/// Split-and-merge fuzzy (Borges & Aldon 2004). A run is split when the dispersion about its line,
/// the root of the mean squared distance, is larger than `dispersion` and than what the noise
/// across the line explains (by `deviations` standard deviations of such a mean). Two lines, at
/// first those on the two sides of the point farthest from the chord, become fuzzy prototypes: each
/// reading belongs to line k with the membership
///   u_k = (1/d_k²) / (1/d_1² + 1/d_2²), d_k² its squared distance and the noise's variance,
/// and each line is fitted again with the weights u_k² (fuzzy c-lines, exponent 2). In the merge
/// phase a line's candidates are its two neighbours, and it is fused with the one of smaller common
/// dispersion, if one line is enough for both. Boundaries end where the squared distances to both
/// lines are least.
/// Kept of the published method: split by dispersion, prototypes by fuzzy clustering, fusion by
/// least dispersion. Not kept: fuzzy clusters need not be runs, here they must; the split is where
/// the memberships of all readings on either side sum up to most. Hence the two closest lines are
/// the neighbours.
class SplitAndMergeFuzzy {
 public:
  static constexpr std::string_view name = "split_and_merge_fuzzy";
  static constexpr std::string_view description =
      "segmenter: splits runs between two fuzzy lines, merges neighbours of small scatter";
  static constexpr std::string_view reference =
      "Borges & Aldon 2004, as in Núñez et al. 2009, sec. 2.2 (SMF)";

  struct Options {
    double dispersion = 0.01;  ///< m
    double deviations = 5;
    std::int64_t iterations = 5;
    void declare(OptionVisitor& visit);
  };

  explicit SplitAndMergeFuzzy(const Options& options) : options_(options) {}

  void segment(std::span<const ScanPoint> points, const LaserNoise& noise,
               std::vector<ReadingRun>& runs);

 private:
  /// The dispersion about a run's line by its limit: above 1, one line is not enough.
  double excess(const ReadingRun& run) const;
  /// Where the memberships of two fuzzy lines split a run; `start` is a first guess.
  std::size_t fuzzy_split(std::span<const ScanPoint> points, const ReadingRun& run,
                          std::size_t start);
  void merge(std::vector<ReadingRun>& runs, std::size_t first) const;

  Options options_;
  RunFits fits_;
  std::vector<ReadingRun> open_;
  std::vector<double> membership_;  ///< of a run's readings in the first of two lines
};

}  // namespace ilss
