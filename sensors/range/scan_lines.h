// From a scan's readings to its straight segments: runs found, pieces of one line joined, fitted.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sensors/range/arc_fit.h"
#include "sensors/range/line_fit.h"
#include "sensors/range/line_segmentation.h"
#include "sensors/range/range_scan.h"

namespace ilss {

/// How a scan is taken apart.
struct ScanLinesRule {
  SegmentationRule segmentation = {};
  /// Missing readings between two pieces of one line may be this far apart (m).
  double max_gap = 0.2;
  ArcRule arc = {};
};

/// A segment with the readings that it explains.
struct FittedSegment {
  LineFit fit;
  std::optional<ArcFit> arc = {};  ///< where a circle explains the readings better
  std::vector<ReadingRun> runs;
  std::size_t first = 0;         ///< reading
  std::size_t last = 0;          ///< reading
  std::size_t mixed_before = 0;  ///< readings left out before it at a jump in range
  std::size_t mixed_after = 0;   ///< and behind it
  bool meets_before = false;     ///< the segment before it, in a corner
};

/// Takes the readings of a scan one by one and tells its segments at the end; what ended on the way
/// can be had at once. Keeps its buffers from scan to scan.
class ScanLines {
 public:
  explicit ScanLines(const ScanLinesRule& rule);

  /// Starts a scan whose readings have such noise, and whose beam has this width (m).
  void begin(const RangeNoise& noise, double beam_width);
  /// Takes a reading; true where it ended a segment.
  bool add(const RangeReading& reading);
  /// Decides on all readings where segments end, joins and fits them.
  void finish();

  std::span<FittedSegment> segments() { return {segments_.data(), count_}; }
  std::span<const RangeReading> readings() const { return readings_; }

  /// On the way: the runs so far, the open one last, and the line through one of them; false where
  /// it has too few readings.
  const std::vector<ReadingRun>& runs() const { return segmentation_.runs(); }
  bool fit_run(const ReadingRun& run, FittedSegment& segment) const;

 private:
  bool is_gap(const RangeReading& reading) const;
  void join_pieces();
  bool joins(const FittedSegment& before, const ReadingRun& next, LineInformation& information);
  std::size_t mixed_readings(std::size_t reading, std::size_t inwards) const;
  void settle_ends();
  void settle_end(FittedSegment& first, FittedSegment& second);
  std::optional<std::size_t> find_corner(const ReadingRun& before, const ReadingRun& after,
                                         const InverseLine& a, const InverseLine& b) const;
  void find_arcs();
  bool may_be_round(const FittedSegment& a, const FittedSegment& b) const;
  bool join_to_arc(FittedSegment& before, const FittedSegment& after) const;
  double cost(const FittedSegment& segment) const;
  bool fit(FittedSegment& segment) const;
  void fit_all();
  LineInformation information_of(std::span<const ReadingRun> runs) const;
  FittedSegment& new_segment();

  ScanLinesRule rule_;
  RangeNoise noise_ = {};
  double beam_width_ = 0;
  std::vector<RangeReading> readings_;
  LineInformationSums sums_;
  LineSegmentation segmentation_;
  std::vector<FittedSegment> segments_;  ///< the first `count_` count; the rest are buffers
  std::size_t count_ = 0;
};

}  // namespace ilss
