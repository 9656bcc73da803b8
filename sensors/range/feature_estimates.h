// Fitted segments, and the edges between them, as estimates with their sources of error.
#pragma once

#include <span>

#include "framework/module/module.h"
#include "sensors/features/range_features.h"
#include "sensors/range/scan_lines.h"

namespace ilss {

/// Writes the features of one tick into an output. The noise of each segment becomes fresh sources
/// of the module, so a corner is correlated with its two segments and these are not with each
/// other; the scan's own errors pass through to all.
class FeatureWriter {
 public:
  /// Forgets the output's elements. `scan` is the range_scan that the fits are of.
  FeatureWriter(const Evaluation& evaluation, const Estimate& scan, Output& output);

  /// Adds a segment or arc; `is_open` where the scan has not got to its end yet.
  void add(const FittedSegment& segment, std::span<const RangeReading> readings,
           bool is_open = false);
  /// Adds the edge between two neighbours that were added last, if there is one: the corner in
  /// which two lines meet, or the end of the nearer line at a jump; not where readings that belong
  /// to neither lie between.
  void add_edge(const FittedSegment& before, const FittedSegment& after,
                std::span<const RangeReading> readings);
  /// Completes the output.
  void finish();

 private:
  Estimate& next(const PayloadDescriptor& type);
  Source source(std::size_t segment, std::uint32_t column) const;

  const Evaluation& evaluation_;
  const Estimate& scan_;
  Output& output_;
  std::size_t count_ = 0;
  std::size_t segments_ = 0;
};

}  // namespace ilss
