// Segments by curvature from triangles whose sides fit the scan: adaptive triangle-area.
#pragma once

#include "sensors/laser/segment/curvature_segments.h"
#include "sensors/laser/segment/regions_of_support.h"
#include "sensors/laser/segment/segmenter.h"

namespace ilss {

/// The adaptive triangle-area representation. The support of reading i forwards is the largest t
/// for which contour and chord enclose little,
///   |T^a - T^c| < U_t,  T^a = sum over j of |p_j × p_{j+1}| / 2,  T^c = |p_i × p_{i+t}| / 2
/// (areas of the triangles that the laser spans with the contour and with the chord; from running
/// sums, so that a test costs the same for every t), backwards likewise; U_t is `area`, or what the
/// noise of the chord's ends comes to, `deviations_of_area` times the chord times its deviation, if
/// that is more. With the vectors f = p_{i+t_f} - p_i and b = p_{i-t_b} - p_i the triangle's area
/// is
///   kappa = (b × f) / 2,
/// and normalised by its sides, 2 kappa / (|b| |f|), the sine of the turn at i. Supports follow
/// from reading to reading, so that a scan costs as much as it has readings. Opposite bumps cancel
/// in T^a - T^c; with `absolute`, areas on both sides of the chord add up instead, at a cost that
/// grows with the supports.
class TriangleArea {
 public:
  static constexpr std::string_view name = "triangle_area";
  static constexpr std::string_view description =
      "segmenter: splits at peaks of the curvature, from triangles of adaptive size";
  static constexpr std::string_view reference =
      "Núñez et al. 2009, sec. 4 (the proposed method, TAR); support as rebuilt";

  struct Options {
    double area = 0.0025;  ///< m², U_t
    double deviations_of_area = 1;
    bool absolute = false;
    SupportRule support = {};
    CornerRule corners = {};
    void declare(OptionVisitor& visit);
  };

  explicit TriangleArea(const Options& options)
      : options_(options), regions_(options.support), segments_(options.corners) {}

  void segment(std::span<const ScanPoint> points, const LaserNoise& noise,
               std::vector<ReadingRun>& runs);

  /// The area between contour and chord from one reading to a later one (m²): signed, so that
  /// opposite bumps cancel, or absolute. `update` first.
  double area(std::size_t from, std::size_t to) const;
  double absolute_area(std::size_t from, std::size_t to) const;
  void update(std::span<const ScanPoint> points, const LaserNoise& noise);

 private:
  bool supports(std::size_t from, std::size_t to) const;
  void find_turns();

  Options options_;
  RegionsOfSupport regions_;
  CurvatureSegments segments_;
  std::span<const ScanPoint> points_;
  std::vector<double> variance_;  ///< m², of a reading's place
  std::vector<double> areas_;     ///< m², running: of the triangles laser, p_{j-1}, p_j up to here
  std::vector<double> turn_, deviation_;
};

}  // namespace ilss
