// What a range scan is made of: straight segments, arcs, corners and edges, each with its error.
#pragma once

#include "framework/estimate/payload.h"

namespace ilss {

/// Whether the scan has seen the segment's end.
inline constexpr std::string_view segment_states[] = {"ended", "open"};
inline constexpr LabelField line_segment_labels[] = {{"state", segment_states}};

/// A straight piece of surface: the line x cos(phi) + z sin(phi) = rho, from where the sensor's
/// rays first met it to where they last did. The ends lie on the line, so to first order
/// the covariance has rank 4. An end is not where the surface ends: that is an edge. Where rho is
/// within a few sd of 0, phi may be off by pi: (rho, phi) and (-rho, phi + pi) are one line.
/// `readings` is how many readings it explains, `first_reading` and `last_reading` the first and
/// last of them by their places in the scan (of a laser's: beams), so that segments can be told
/// apart and matched by what they were made of.
template <typename T>
struct LineSegment {
  T rho, phi, start_x, start_z, end_x, end_z, readings, first_reading, last_reading;
  std::array<int, 1> label{};

  static constexpr std::string_view name = "line_segment";
  static constexpr std::string_view documentation = "a straight piece of surface";
  static constexpr auto fields = Fields{
      {"rho", "m", "distance of the line from the frame's origin, not negative"},
      {"phi", "rad", "direction of its normal, from x towards z", required, Geometry::circular},
      {"start_x", "m", "where the scan's first ray met it"},
      {"start_z", "m", "the same"},
      {"end_x", "m", "where the last ray met it"},
      {"end_z", "m", "the same"},
      {"readings", "1", "how many it explains; exact"},
      {"first_reading", "1", "in the scan; exact"},
      {"last_reading", "1", "in the scan; exact"}};
  static constexpr std::span<const LabelField> labels = line_segment_labels;
};

/// A piece of a round surface.
template <typename T>
struct ArcSegment {
  T centre_x, centre_z, radius, start_x, start_z, end_x, end_z, readings, first_reading,
      last_reading;

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
             {"readings", "1", "how many it explains; exact"},
             {"first_reading", "1", "in the scan; exact"},
             {"last_reading", "1", "in the scan; exact"}};
};

/// Whether the scan has seen the surface bend there, or two lines would meet there if they went on.
inline constexpr std::string_view corner_kinds[] = {"real", "virtual"};
enum class CornerKind { real_corner, virtual_corner };
inline constexpr LabelField corner_labels[] = {{"kind", corner_kinds}};

/// Where two lines meet.
template <typename T>
struct Corner {
  T x, z;
  std::array<int, 1> label{};

  static constexpr std::string_view name = "corner";
  static constexpr std::string_view documentation = "where two lines meet";
  static constexpr auto fields = Fields{{"x", "m", "its place"}, {"z", "m", "its place"}};
  static constexpr std::span<const LabelField> labels = corner_labels;
};

/// Where a flat surface ends before a farther one: a jump in range.
template <typename T>
struct SurfaceEdge {
  T x, z, phi;

  static constexpr std::string_view name = "edge";
  static constexpr std::string_view documentation =
      "where a flat surface ends before a farther one";
  static constexpr auto fields =
      Fields{{"x", "m", "its place"},
             {"z", "m", "its place"},
             {"phi", "rad", "direction of the surface's normal, as of its line", required,
              Geometry::circular}};
};

/// A set of line segments, arcs, corners and edges, in the order in which the sensor saw them:
/// estimates over common sources.
template <typename T>
struct RangeFeatures {
  T segments;

  static constexpr std::string_view name = "range_features";
  static constexpr std::string_view documentation =
      "a set of line_segment, arc_segment, corner and edge";
  static constexpr auto fields = Fields{{"segments", "1", "how many segments and arcs; exact"}};
  static constexpr std::string_view element = "line_segment, arc_segment, corner or edge";
  static std::vector<const PayloadDescriptor*> elements() {
    return {&descriptor<LineSegment>(), &descriptor<ArcSegment>(), &descriptor<Corner>(),
            &descriptor<SurfaceEdge>()};
  }
};

}  // namespace ilss
