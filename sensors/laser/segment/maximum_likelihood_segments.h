// The segments that explain a cluster best: lines and arcs, by dynamic programming.
#pragma once

#include <optional>

#include "sensors/laser/features/laser_segment.h"
#include "sensors/laser/segment/curve_moments.h"
#include "sensors/laser/segment/segmenter.h"

namespace ilss {

/// Segments of maximum likelihood, ours: of all ways to take a cluster apart into lines, arcs and
/// readings that belong to neither, the one of least cost: chi² of the readings, `line_cost` for
/// each line, `arc_cost` for each arc and `outlier_cost` for each reading left over. By dynamic
/// programming over where segments end, every `stride` readings, with those beginnings left out
/// that can no longer be best (Killick et al. 2012), and fits from sums; then each end between two
/// neighbours moves to where their exact fits part, and neighbours that are cheaper as one are one.
/// Costs n times the length of segments.
class MaximumLikelihoodSegments {
 public:
  static constexpr std::string_view name = "maximum_likelihood";
  static constexpr std::string_view description =
      "segmenter: the lines and arcs that explain the readings best, by dynamic programming";
  static constexpr std::string_view reference =
      "ours, after Schaefer et al. 2018 (maximum-likelihood polylines) and Killick et al. 2012";

  struct Options {
    double line_cost = 30;
    double arc_cost = 50;
    double outlier_cost = 12;
    double least_radius = 0.1;
    double largest_radius = 3;
    std::int64_t stride = 2;
    void declare(OptionVisitor& visit);
  };

  explicit MaximumLikelihoodSegments(const Options& options) : options_(options) {}

  void segment(std::span<const ScanPoint> points, const LaserNoise& stated,
               std::vector<ReadingRun>& runs);

 private:
  /// The best way to explain all readings before `end`, whose last piece begins at `begin`.
  struct Solution {
    double cost;
    std::size_t begin;  ///< index of a solution
    bool is_segment;    ///< the last piece; otherwise outliers
  };

  /// A run with its exact fit, if it has one.
  struct FittedRun {
    ReadingRun run;
    std::optional<LaserSegment> fit;
  };

  bool consider(std::size_t from, std::size_t at, Solution& best) const;
  void solve(std::size_t readings);
  LaserModelRule model() const;
  FittedRun fit(std::span<const ScanPoint> points, const LaserNoise& noise,
                const ReadingRun& run) const;
  const std::optional<LaserSegment>& fit_of(std::span<const ScanPoint> points,
                                            const LaserNoise& noise,
                                            std::span<const ReadingRun> runs, std::size_t i);
  double exact_cost(const std::optional<LaserSegment>& fit) const;
  void join(std::span<const ScanPoint> points, const LaserNoise& noise,
            std::vector<ReadingRun>& runs);
  void move_ends(std::span<const ScanPoint> points, const LaserNoise& noise,
                 std::span<ReadingRun> runs);

  Options options_;
  CurveMomentSums sums_;
  std::vector<std::size_t> ends_;
  std::vector<Solution> solutions_;
  std::vector<std::size_t> beginnings_;  ///< solutions that a piece may still begin at
  std::vector<ReadingRun> found_;
  std::vector<FittedRun> fits_;  ///< of those found
};

}  // namespace ilss
