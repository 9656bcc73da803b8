// Straight segments, arcs and edges from range scans, honest and in one piece each.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "framework/module/module_type.h"
#include "sensors/range/feature_estimates.h"
#include "sensors/range/line_memory.h"
#include "sensors/range/scan_lines.h"

namespace ilss {

/// Estimator: line segments, arcs and edges of a range scan, recursively and with errors that are
/// true: ours, beside the published `ekf_line_extractor`.
///
/// It works in inverse range, in which a line is linear in m = (cos phi, sin phi) / rho, so that
/// nothing is linearised about a noisy start. A reading's variance is the sensor's, not one made of
/// the noisy range. Where a segment ends is decided on the way by the last readings, and at the end
/// of the scan by all (LineSegmentation); two lines that meet end where they do. Neighbouring
/// pieces of one line are one segment, across outliers and missing readings up to `max_gap`. Pieces
/// that a circle explains better become an arc. Each segment's own noise is fresh sources; what the
/// scan's readings share (mount, calibration) passes through the fit and does not average out.
///
/// A tick's readings are a scan. With `continuous`, they go on from tick to tick until the sweep
/// jumps back; a tick gives the segments that ended in it and the open one as it is now, without
/// arcs and edges. With `memory`, a line that earlier scans saw is the mean over up to so many
/// scans and then starts anew, for a vehicle that stands still.
/// Output frame: the scan's. Faults: bad_data where a reading is not finite, its inverse range or
/// sd is not above 0, or bearings do not run in one direction; no_detection where a scan has fewer
/// than `least_readings` readings. Pending, if `continuous`, where nothing ended and the open
/// segment is too short.
class LineExtractor final : public Module {
 public:
  static constexpr std::string_view name = "line_extractor";
  static constexpr std::string_view description =
      "line segments, arcs and edges of a range scan, with true errors";
  static constexpr std::string_view reference =
      "after Pears 1997, sec. 4, in inverse range and with merging, corners and arcs";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr bool remembers = true;
  static constexpr std::array faults = {FaultKind::bad_data, FaultKind::no_detection};

  struct Options {
    ScanLinesRule rule = {};
    std::int64_t least_readings = 5;
    bool continuous = false;
    std::int64_t memory = 1;
    void declare(OptionVisitor& visit);
  };

  static Interface interface(const Options& options);

  explicit LineExtractor(const Options& options);

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
  void reset() override;

 private:
  Outcome<> extract_scan(const Evaluation& evaluation, const RangeScan<double>& shared,
                         Output& output);
  Outcome<> extract_on(const Evaluation& evaluation, const RangeScan<double>& shared,
                       Output& output);
  bool jumps_back(const RangeReading& reading) const;

  Options options_;
  ScanLines lines_;
  LineMemory memory_;
  FittedSegment open_;
  bool scan_begun_ = false;
};

/// What is wrong with a scan's readings, if anything: see LineExtractor's faults.
Outcome<> check_readings(std::span<const RangeReading> readings);

}  // namespace ilss
