// Straight segments, arcs and edges from range scans, honest and in one piece each.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "framework/module/module_type.h"
#include "sensors/range/line_fit.h"
#include "sensors/range/line_segmentation.h"
#include "sensors/range/range_features.h"
#include "sensors/range/range_scan.h"

namespace ilss {

/// Estimator: line segments, arcs and edges of a range scan, recursively and with errors that are
/// true: ours, beside the published `ekf_line_extractor`.
///
/// It works in inverse range, in which a line is linear in m = (cos phi, sin phi) / rho, so that
/// nothing is linearised about a noisy start. A reading's variance is the sensor's, not one made of
/// the noisy range. Where the line ends is decided by LineSegmentation: on the way by the last
/// readings, at the end of the scan by all. Neighbouring pieces of one line are one segment, across
/// outliers and missing readings up to `max_gap`. Runs of segments that a circle explains better
/// become an arc. Each segment's own noise is fresh sources; what the scan's readings share (mount,
/// calibration) passes through by the fit's implicit derivative and does not average out.
///
/// A tick's readings are a scan. With `continuous`, they go on from tick to tick, until the sweep
/// jumps back: then a tick gives the segments that ended in it and the open one as it is now.
/// With `memory`, a segment that an earlier scan saw is the weighted mean over up to so many scans;
/// for a vehicle that stands still.
/// Output frame: the scan's. Faults: bad_data where a reading is not finite, its inverse range or
/// sd is not positive, or bearings do not run in one direction; no_detection where a scan has fewer
/// than `least_readings` readings. Pending, if `continuous`, where nothing ended and the open
/// segment is too short.
class LineExtractor final : public Module {
 public:
  static constexpr std::string_view name = "line_extractor";
  static constexpr std::string_view description =
      "line segments, arcs and edges of a range scan, with true errors";
  static constexpr std::string_view reference = "after Pears 1997, sec. 4; in inverse range";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr bool remembers = true;
  static constexpr std::array faults = {FaultKind::bad_data, FaultKind::no_detection};

  struct Options {
    SegmentationRule rule;
    double max_gap = 0.2;
    std::int64_t edge_readings = 1;
    void declare(OptionVisitor& visit);
  };

  static Interface interface();

  explicit LineExtractor(const Options& options);

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
  void reset() override;

 private:
  /// Runs of readings on one line.
  struct Group {
    std::vector<ReadingRun> runs;
    LineInformation information;
  };

  Outcome<> take(std::span<const RangeReading> readings);
  void segment(double noise_correlation);
  void group();
  bool joins(const Group& before, const ReadingRun& next) const;
  void drop_mixed_readings();
  void fit(double noise_correlation);
  void emit(const Evaluation& evaluation, Output& output) const;

  Options options_;
  std::vector<RangeReading> readings_;
  LineInformationSums sums_;
  LineSegmentation segmentation_;
  std::vector<Group> groups_;
  std::size_t group_count_ = 0;
  std::vector<LineFit> fits_;
  std::vector<std::size_t> fitted_groups_;  ///< the group of each fit
};

}  // namespace ilss
