// What a range scan is made of: straight segments, arcs and edges, each with its error.
#pragma once

#include "framework/estimate/payload.h"

namespace ilss {

/// Whether the scan has seen the segment's end.
inline constexpr std::string_view segment_states[] = {"ended", "open"};
inline constexpr LabelField line_segment_labels[] = {{"state", segment_states}};

/// A straight piece of surface: the line x cos(phi) + z sin(phi) = rho, from where the sensor's
/// rays first met it to where they last did. The ends lie on the line, so the covariance has rank 4
/// at most. `readings` is how many readings it explains.
template <typename T>
struct LineSegment {
  T rho, phi, start_x, start_z, end_x, end_z, readings;
  std::array<int, 1> label{};

  static constexpr std::string_view name = "line_segment";
  static constexpr std::string_view documentation = "a straight piece of surface";
  static constexpr auto fields =
      Fields{{"rho", "m", "distance of the line from the frame's origin, not negative"},
             {"phi", "rad", "direction of its normal, from x towards z", required, true},
             {"start_x", "m", "where the scan's first ray met it"},
             {"start_z", "m", "the same"},
             {"end_x", "m", "where the last ray met it"},
             {"end_z", "m", "the same"},
             {"readings", "1", "how many it explains; exact"}};
  static constexpr std::span<const LabelField> labels = line_segment_labels;
};

/// A piece of a round surface.
template <typename T>
struct ArcSegment {
  T centre_x, centre_z, radius, start_x, start_z, end_x, end_z, readings;

  static constexpr std::string_view name = "arc_segment";
  static constexpr std::string_view documentation = "a piece of a round surface";
  static constexpr auto fields =
      Fields{{"centre_x", "m", "of the circle"},
             {"centre_z", "m", "of the circle"},
             {"radius", "m", "positive where it bulges towards the sensor, negative where hollow"},
             {"start_x", "m", "where the scan's first ray met it"},
             {"start_z", "m", "the same"},
             {"end_x", "m", "where the last ray met it"},
             {"end_z", "m", "the same"},
             {"readings", "1", "how many it explains; exact"}};
};

/// What an edge is: where two surfaces meet, or where the nearer one ends before a farther one.
inline constexpr std::string_view edge_kinds[] = {"corner", "jump"};
enum class EdgeKind { corner, jump };
inline constexpr LabelField range_edge_labels[] = {{"kind", edge_kinds}};

/// The place of an edge: a range discontinuity or a bend.
template <typename T>
struct RangeEdge {
  T x, z;
  std::array<int, 1> label{};

  static constexpr std::string_view name = "range_edge";
  static constexpr std::string_view documentation = "where a surface ends or bends";
  static constexpr auto fields = Fields{{"x", "m", "its place"}, {"z", "m", "its place"}};
  static constexpr std::span<const LabelField> labels = range_edge_labels;
};

/// A set of line segments, arcs and edges, in the order in which the sensor saw them: estimates
/// over common sources.
template <typename T>
struct RangeFeatures {
  T segments;

  static constexpr std::string_view name = "range_features";
  static constexpr std::string_view documentation =
      "a set of line_segment, arc_segment and range_edge";
  static constexpr auto fields = Fields{{"segments", "1", "how many segments and arcs; exact"}};
  static constexpr std::string_view element = "line_segment, arc_segment or range_edge";
};

}  // namespace ilss
