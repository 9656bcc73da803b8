// From a segmented scan to what it shows: lines, arcs, corners and edges with their errors.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/module/module_type.h"
#include "sensors/features/range_features.h"
#include "sensors/laser/features/laser_segment.h"
#include "sensors/laser/segment/segmented_points.h"

namespace ilss {

/// Estimator: fits each segment of a segmented_scan and gives it as a line_segment or arc_segment,
/// with the corners and edges between them, in the robot's plane (x forward, z to the right).
///
/// Fits are those of maximum likelihood (fit_laser_line, fit_laser_arc); an arc is chosen where it
/// saves `evidence` of chi². What fits neither (chi² above `largest_misfit` a degree of freedom) is
/// left out. Readings next to a segment that no segment has and that lie on it (3 sd) count as its.
/// A real corner lies where the surface bends: neighbouring lines that meet between the
/// last beam of the one and the first of the other. Virtual corners lie where two other lines would
/// meet within `virtual_reach` of their ends. An edge is where a line ends before a farther
/// surface (a breakpoint, by the adaptive detector), never at the scan's first or last beam.
/// Each segment's noise is its own sources, so a corner is correlated with its two lines and these
/// are not with each other; the scan's mount and its ranges' systematic errors pass through to all.
/// Faults: bad_data where a number is not finite or a range negative; no_error_known where the
/// scan states no noise; no_detection where no segment fits.
class LaserFeatures final : public Module {
 public:
  static constexpr std::string_view name = "laser_features";
  static constexpr std::string_view description =
      "lines, arcs, corners and edges of a segmented laser scan, each with its error";
  static constexpr std::string_view reference = "Núñez et al. 2009, sec. 3.2";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr std::array faults = {FaultKind::bad_data, FaultKind::no_error_known,
                                        FaultKind::no_detection};
  static constexpr std::array moved_parameters = {MovedParameter{
      "mount",
      "a scan carries it: give it where the scan comes from (laser_log, laser_scene, "
      "laser_scene_segments)"}};

  struct Options {
    LaserModelRule model = {};
    double virtual_reach = 0;
    double least_corner_angle = 0.17453292519943295;
    double incidence = 0.17453292519943295;
    std::string frame = "robot";
    void declare(OptionVisitor& visit);
  };

  static Interface interface(const Options& options);

  explicit LaserFeatures(Options options)
      : options_(std::move(options)), parallel_(std::cos(options_.least_corner_angle)) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;

 private:
  bool is_real_corner(const LaserSegment& before, const LaserSegment& after,
                      const LaserNoise& noise) const;
  bool is_within_reach(double x, double y, const LaserSegment& segment) const;
  Fault nothing_fits(const LaserNoise& noise) const;
  void fit_all(const LaserNoise& noise, const UncertainBiases& biases);
  void extend(LaserSegment& segment, std::size_t begin, std::size_t end, const LaserNoise& noise,
              const UncertainBiases& biases) const;
  void add_virtual_corners(class LaserFeatureWriter& writer) const;
  void add_edges(std::size_t index, double deviation, class LaserFeatureWriter& writer) const;

  Options options_;
  double parallel_;  ///< cosine between two lines from which they make no corner
  SegmentedPoints scan_;
  std::vector<LaserSegment> segments_;
};

}  // namespace ilss
