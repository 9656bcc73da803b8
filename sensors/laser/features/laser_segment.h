// A segment of a laser scan with what fits it best.
#pragma once

#include <optional>
#include <span>

#include "sensors/laser/features/laser_arc_fit.h"
#include "sensors/laser/features/laser_line_fit.h"
#include "sensors/range/reading_run.h"

namespace ilss {

/// A segment of a scan with what fits it best: a line or an arc.
struct LaserSegment {
  ReadingRun run = {};
  LaserLineFit line = {};
  std::optional<LaserArcFit> arc = {};
  bool meets_before = false;  ///< the segment before it, in a corner
};

/// What decides between a line, an arc and nothing.
struct LaserModelRule {
  double evidence = 12;       ///< chi² that an arc must save over a line
  double least_radius = 0.1;  ///< m
  double largest_radius = 3;  ///< m; 0: no arcs
  double largest_misfit = 4;  ///< chi² per degree of freedom
};

/// Fits a run of a scan's points; nothing where neither a line nor an arc fits, or the line's
/// direction is hardly known (0.15 rad). A line that is bent, but is no arc, gets the covariance
/// that its bend leaves it: the same surface, seen elsewhere, is another line.
std::optional<LaserSegment> fit_laser_segment(std::span<const ScanPoint> scan,
                                              const ReadingRun& run, const LaserNoise& noise,
                                              const LaserModelRule& rule,
                                              const UncertainBiases& biases);

/// How far a reading is off the segment's line or arc, in squared standard deviations.
double squared_residual(const LaserSegment& segment, const ScanPoint& p, const LaserNoise& noise);

}  // namespace ilss
