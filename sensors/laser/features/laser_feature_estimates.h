// Fitted segments of a laser scan, their corners and edges, as estimates in the robot's plane.
#pragma once

#include <span>
#include <vector>

#include "framework/module/module.h"
#include "sensors/features/range_features.h"
#include "sensors/laser/features/laser_segment.h"
#include "sensors/laser/laser_mount.h"

namespace ilss {

/// Writes the features of one tick into an output. The evaluation's input 0 is the scan, which
/// brings the ranges' systematic errors and the mount.
/// Each segment's noise is fresh sources of the module by the segment's place, which corners and
/// edges share.
class LaserFeatureWriter {
 public:
  LaserFeatureWriter(const Evaluation& evaluation, const LaserNoise& noise, Output& output);

  /// Adds a segment as a line_segment or arc_segment; `index` is its place among the segments.
  void add(std::size_t index, const LaserSegment& segment, std::span<const ScanPoint> scan);
  /// Adds the corner of two lines that are not parallel.
  void add_corner(std::size_t a, const LaserLineFit& line_a, std::size_t b,
                  const LaserLineFit& line_b, CornerKind kind);
  /// Adds the edge at which a line ends, after its last beam or before its first: between this beam
  /// and its neighbour, which is of the farther surface.
  void add_edge(std::size_t index, const LaserLineFit& line, const ScanPoint& beam,
                const ScanPoint& neighbour);
  /// Completes the output.
  void finish();

 private:
  /// A feature in the robot's plane: its components, and how they follow from its fit's P
  /// parameters, from the mount and from the ranges' biases.
  template <int Rows, int P>
  struct Feature {
    Eigen::Matrix<double, Rows, 1> value;
    Eigen::Matrix<double, Rows, P> by_fit = Eigen::Matrix<double, Rows, P>::Zero();
    Eigen::Matrix<double, Rows, 3> by_mount = Eigen::Matrix<double, Rows, 3>::Zero();
    Eigen::Matrix<double, Rows, static_cast<int>(range_biases)> by_bias =
        Eigen::Matrix<double, Rows, static_cast<int>(range_biases)>::Zero();
  };

  Estimate& next(const PayloadDescriptor& type);
  Eigen::Vector2d turn(const Eigen::Vector2d& place) const;
  template <int Rows, int P>
  void set_place(Feature<Rows, P>& feature, int row, const Eigen::Vector2d& place,
                 const Eigen::Matrix<double, 2, P>& by_fit) const;
  template <int Rows>
  void set_line(Feature<Rows, 2>& feature, int rho_row, int phi_row,
                const LaserLineFit& line) const;
  template <int Rows, int P>
  Estimate& write(const PayloadDescriptor& type, const Feature<Rows, P>& feature);
  void add_line(std::size_t index, const LaserSegment& segment, std::span<const ScanPoint> scan);
  void add_arc(std::size_t index, const LaserSegment& segment, std::span<const ScanPoint> scan);
  Source source(std::size_t segment, std::uint32_t column) const;

  const Evaluation& evaluation_;
  LaserNoise noise_;
  LaserMount mount_;
  double cosine_;  ///< of the mount's heading
  double sine_;
  bool has_systematic_errors_;
  Output& output_;
  std::size_t count_ = 0;
  std::size_t segments_ = 0;
};

}  // namespace ilss
