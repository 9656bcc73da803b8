// A segmented scan as points and runs of them.
#pragma once

#include <span>
#include <vector>

#include "framework/module/module.h"
#include "sensors/laser/scan_points.h"
#include "sensors/range/reading_run.h"

namespace ilss {

/// The points of a segmented scan, and its segments as runs of them, in order. Keeps its buffers
/// from scan to scan.
class SegmentedPoints {
 public:
  /// Takes a segmented_scan apart; bad_data where a number is not finite or a range negative.
  Outcome<> read(const Output& scan);

  std::span<const ScanPoint> points() const { return points_; }
  std::span<const ReadingRun> runs() const { return runs_; }
  std::span<const ScanPoint> points_of(const ReadingRun& run) const {
    return points_.subspan(run.begin, run.size());
  }

  /// Writes the scan with other segments: runs of its beams, in order.
  void write(const Evaluation& evaluation, std::span<const ReadingRun> segments,
             Output& output) const;

 private:
  ScanPoints buffer_;
  std::span<const ScanPoint> points_;
  std::vector<ReadingRun> runs_;
};

}  // namespace ilss
