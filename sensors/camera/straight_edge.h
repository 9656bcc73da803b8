// A straight edge of the world as a lens shows it.
#pragma once

#include <optional>

#include "sensors/camera/lens_distortion.h"

namespace ilss {

/// A line in ideal pixels, across = offset + slope (along - reference). Along counts columns and
/// across rows for a horizontal line, the other way round for a vertical one (`vertical`).
struct StraightEdge {
  double offset;
  double slope;
  double reference;
  bool vertical;
};

/// Where the image shows a straight edge at one position along it, and how that changes.
struct EdgeAt {
  double across;     ///< shown position
  double slope;      ///< of the shown edge
  double by_offset;  ///< derivatives of `across` by the line's offset and slope
  double by_slope;
  ImagePoint<double> ideal;  ///< the point of the line that is shown there
};

/// The shown edge at position `along` (pixels). Without distortion it is the line itself; with it,
/// the line's point that is shown there is found by Newton's method. Nothing if there is none.
inline std::optional<EdgeAt> edge_at(const Image<double>& camera, const StraightEdge& edge,
                                     double along) {
  const auto point = [&](double x) {
    const double y = edge.offset + edge.slope * (x - edge.reference);
    return edge.vertical ? ImagePoint<double>{y, x} : ImagePoint<double>{x, y};
  };
  if (!is_distorted(camera)) {
    const double distance = along - edge.reference;
    return EdgeAt{edge.offset + edge.slope * distance, edge.slope, 1, distance, point(along)};
  }
  double x = along;
  constexpr int most_iterations = 20;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const DistortionAt at = distortion_at(camera, point(x));
    const auto& by_x = edge.vertical ? at.by_row : at.by_column;
    const auto& by_y = edge.vertical ? at.by_column : at.by_row;
    const auto along_of = [&](const ImagePoint<double>& p) {
      return edge.vertical ? p.row : p.column;
    };
    const auto across_of = [&](const ImagePoint<double>& p) {
      return edge.vertical ? p.column : p.row;
    };
    const double along_by_x = along_of(by_x) + edge.slope * along_of(by_y);
    const double step = (along_of(at.shown) - along) / along_by_x;
    if (!std::isfinite(step) || !(along_by_x > 0)) return std::nullopt;
    if (std::abs(step) < 1e-9) {
      const double slope = (across_of(by_x) + edge.slope * across_of(by_y)) / along_by_x;
      const double by_offset = across_of(by_y) - slope * along_of(by_y);
      return EdgeAt{across_of(at.shown), slope, by_offset, by_offset * (x - edge.reference),
                    point(x)};
    }
    x -= step;
  }
  return std::nullopt;
}

}  // namespace ilss
