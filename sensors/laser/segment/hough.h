// Segments by the lines that the readings vote for.
#pragma once

#include <optional>

#include "sensors/laser/segment/run_fits.h"
#include "sensors/laser/segment/segmenter.h"

namespace ilss {

/// Hough transform with mean shift (Bandera et al. 2006). There is no grid of votes: each reading
/// votes for the line of least squares through its `neighbourhood`, a place in the domain of
/// (theta, rho) that is known with a covariance; taken about the neighbourhood's centre, rho and
/// theta are independent, and their variances are
///   v / n and v / (sum of squares along the line),
/// v that of a reading's distance. Votes are clustered by mean shift with variable bandwidth
/// (Comaniciu 2003, with the kernel of Epanechnikov): from a vote, the line goes to the weighted
/// mean of those votes that are within `bandwidth` deviations of it, until it stays; the best vote
/// that belongs to no cluster starts the next. Runs of votes for one line become segments, those
/// shorter than a neighbourhood are votes across a corner. Segments meet where the squared
/// distances to both lines are least.
class Hough {
 public:
  static constexpr std::string_view name = "hough";
  static constexpr std::string_view description =
      "segmenter: readings vote for lines, whose votes are clustered by mean shift";
  static constexpr std::string_view reference =
      "Bandera et al. 2006, as in Núñez et al. 2009, sec. 2.2 (HT)";

  struct Options {
    double neighbourhood = 0.4;  ///< m
    double bandwidth = 4;
    double roughness = 0.003;  ///< m
    double spacing = 0.02;     ///< m
    void declare(OptionVisitor& visit);
  };

  explicit Hough(const Options& options) : options_(options) {}

  void segment(std::span<const ScanPoint> points, const LaserNoise& noise,
               std::vector<ReadingRun>& runs);

 private:
  /// A line as a place in the Hough domain, about a point of it.
  struct Place {
    double x, y;                ///< m
    double normal_x, normal_y;  ///< of length 1
  };
  struct Vote {
    Place place;
    double offset_weight, angle_weight;  ///< 1/m², 1/rad²: by the variances
    double misfit;                       ///< the reduced chi² of its neighbourhood
    std::size_t reading;
    std::size_t line;  ///< its cluster, from 1; 0: none yet
  };
  /// A vote as seen from a line: how far away, in metres and radians, and in bandwidths squared.
  struct Difference {
    double along, offset, angle, square;
  };

  void vote(std::span<const ScanPoint> points);
  Difference difference(const Place& line, const Vote& vote) const;
  Place shifted(Place line, std::span<const Vote> votes) const;
  void cluster();
  void find_runs(std::span<const ScanPoint> points);
  void append_runs(std::size_t count, std::vector<ReadingRun>& runs) const;

  Options options_;
  RunFits fits_;
  std::vector<Vote> votes_;
  std::vector<std::size_t> order_;
  std::vector<ReadingRun> runs_;
  std::vector<std::size_t> lines_;  ///< of the runs
};

}  // namespace ilss
