// Which runs of a scan's readings lie on one straight line each.
#pragma once

#include <cstddef>
#include <vector>

#include "sensors/range/line_information.h"
#include "sensors/range/reading_run.h"

namespace ilss {

/// What a further segment has to bring before it is believed.
struct SegmentationRule {
  /// Chi² that a segment must save. A third segment on two walls saves this by luck in the best of
  /// all places, so it is well above what one place would need.
  double evidence = 36;
  double outlier_cost = 12;        ///< chi² for a reading that belongs to no segment
  std::size_t least_readings = 5;  ///< of a segment
};

/// Finds the segments of a scan recursively: each reading either goes on with the open segment or,
/// where two lines explain the last readings better than one by the rule's evidence, ends it. The
/// tests look 4, 8, 16, ... readings back, so a reading costs a few sums.
class LineSegmentation {
 public:
  explicit LineSegmentation(const SegmentationRule& rule) : rule_(rule) {}

  /// Starts a scan.
  void clear();
  /// Takes the reading that was added to `sums` last; true where it ended the open segment, which
  /// then is the last but one of `runs()`.
  bool advance(const LineInformationSums& sums);
  /// Ends the open segment before the latest reading, whatever the readings say: a gap.
  void break_before_last(const LineInformationSums& sums);
  /// The runs so far, the open one last. Runs of fewer than `least_readings` are no segments.
  const std::vector<ReadingRun>& runs() const { return runs_; }

  /// Whether the run that begins at a reading was begun by `break_before_last`.
  bool is_behind_gap(std::size_t begin) const;

  /// Moves, removes and adds ends of segments while that lowers the cost: chi² of all segments,
  /// their evidence, and the outliers' cost. What the recursion decided on a few readings is
  /// decided here on all; gaps stay.
  void refine(const LineInformationSums& sums);

  /// The cost of a run: as a segment where it is long enough, or as outliers, if that is less.
  double cost(const LineInformationSums& sums, std::size_t begin, std::size_t end) const;
  const SegmentationRule& rule() const { return rule_; }

 private:
  struct Split {
    std::size_t at;
    double cost;
  };
  Split best_split(const LineInformationSums& sums, std::size_t begin, std::size_t end) const;
  bool refine_once(const LineInformationSums& sums);
  bool remove_middles(const LineInformationSums& sums);

  SegmentationRule rule_;
  std::vector<ReadingRun> runs_ = std::vector<ReadingRun>(1);
  std::vector<std::size_t> gaps_;  ///< runs that start behind a gap begin here
  std::vector<ReadingRun> refined_;
};

}  // namespace ilss
