// Lines that earlier scans saw, for a sensor whose frame stands still.
#pragma once

#include <cstddef>
#include <vector>

#include "sensors/range/scan_lines.h"

namespace ilss {

/// Joins a scan's lines with those of earlier scans: their noise averages out, what the scans share
/// does not. A line is the same where the difference of the two is within its 99.9 % bound and
/// their extents overlap.
class LineMemory {
 public:
  /// Over at most `scans` scans; then a line starts anew, so that its covariance stays exact.
  explicit LineMemory(std::size_t scans, double max_gap) : scans_(scans), max_gap_(max_gap) {}

  void clear() { lines_.clear(); }
  /// Replaces each line's fit by the mean with what is remembered of it, and remembers that. What a
  /// scan does not see is forgotten.
  void join(std::span<FittedSegment> segments, std::span<const RangeReading> readings);

 private:
  struct Line {
    LineFit fit;
    std::size_t scans;
    double begin;  ///< along the line, from the foot of the perpendicular (m)
    double end;
  };
  bool same(const Line& known, const Line& seen) const;

  std::size_t scans_;
  double max_gap_;
  std::vector<Line> lines_;
  std::vector<Line> seen_;
};

}  // namespace ilss
