#include "sensors/camera/scene_renderer.h"

#include <algorithm>
#include <cmath>

#include "sensors/camera/area_coverage.h"
#include "sensors/scene/wall_target_patches.h"

namespace ilss {
namespace {

using Polygon = std::vector<ImagePoint<double>>;

/// What is nearer than this to the camera's plane is not seen (m).
constexpr double near_plane = 1e-3;

/// A wall as the camera sees it: over tangents t = x / z to the right of the optical axis.
struct SeenWall {
  const Wall* wall;
  ScenePoint from;  ///< the wall's first end: x is depth, z to the right
  ScenePoint direction;
  double along_begin, along_end;      ///< the part before the near plane (m from the first end)
  double tangent_begin, tangent_end;  ///< in increasing order
  double inverse_depth_0, inverse_depth_1;  ///< 1 / z = inverse_depth_0 + inverse_depth_1 t

  double tangent(double along) const {
    return (from.z + along * direction.z) / (from.x + along * direction.x);
  }
  double inverse_depth(double t) const { return inverse_depth_0 + inverse_depth_1 * t; }
};

/// The wall in the camera's axes, or nothing where it is behind the camera or seen edge-on.
bool see_wall(const Wall& wall, const ScenePose& pose, SeenWall& seen) {
  seen.wall = &wall;
  seen.from = to_frame(pose, wall.from);
  const ScenePoint to = to_frame(pose, wall.to);
  const double length = std::hypot(to.x - seen.from.x, to.z - seen.from.z);
  if (!(length > 0)) return false;
  seen.direction = {(to.x - seen.from.x) / length, (to.z - seen.from.z) / length};
  seen.along_begin = 0;
  seen.along_end = length;
  if (seen.from.x < near_plane && to.x < near_plane) return false;
  if (seen.from.x < near_plane) seen.along_begin = (near_plane - seen.from.x) / seen.direction.x;
  if (to.x < near_plane) seen.along_end = (near_plane - seen.from.x) / seen.direction.x;
  // On the wall's line, direction.z depth - direction.x right = offset.
  const double offset = seen.direction.z * seen.from.x - seen.direction.x * seen.from.z;
  if (std::abs(offset) < 1e-9) return false;
  seen.inverse_depth_0 = seen.direction.z / offset;
  seen.inverse_depth_1 = -seen.direction.x / offset;
  seen.tangent_begin = seen.tangent(seen.along_begin);
  seen.tangent_end = seen.tangent(seen.along_end);
  if (seen.tangent_begin > seen.tangent_end) std::swap(seen.tangent_begin, seen.tangent_end);
  return true;
}

/// A part of a wall that nothing hides.
struct VisiblePart {
  const SeenWall* seen;
  double tangent_begin, tangent_end;
};

/// Cuts the field of view where walls begin, end or cross, and takes the nearest in each piece.
std::vector<VisiblePart> visible_parts(const std::vector<SeenWall>& walls) {
  std::vector<double> cuts;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    cuts.push_back(walls[i].tangent_begin);
    cuts.push_back(walls[i].tangent_end);
    for (std::size_t j = 0; j < i; ++j) {
      const double slope = walls[i].inverse_depth_1 - walls[j].inverse_depth_1;
      const double crossing = (walls[j].inverse_depth_0 - walls[i].inverse_depth_0) / slope;
      if (std::isfinite(crossing) && crossing > walls[i].tangent_begin &&
          crossing < walls[i].tangent_end && crossing > walls[j].tangent_begin &&
          crossing < walls[j].tangent_end)
        cuts.push_back(crossing);
    }
  }
  std::sort(cuts.begin(), cuts.end());
  std::vector<VisiblePart> parts;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double middle = 0.5 * (cuts[i] + cuts[i + 1]);
    const SeenWall* nearest = nullptr;
    for (const SeenWall& wall : walls)
      if (wall.tangent_begin <= middle && middle <= wall.tangent_end &&
          (nearest == nullptr || wall.inverse_depth(middle) > nearest->inverse_depth(middle)))
        nearest = &wall;
    if (nearest == nullptr) continue;
    if (!parts.empty() && parts.back().seen == nearest && parts.back().tangent_end == cuts[i])
      parts.back().tangent_end = cuts[i + 1];
    else
      parts.push_back({nearest, cuts[i], cuts[i + 1]});
  }
  return parts;
}

/// A rectangle of pixels, edges included.
struct PixelBounds {
  ImagePoint<double> least, greatest;
};

/// The ideal pixels that the image can show: its own rectangle, undistorted, with a margin.
PixelBounds ideal_bounds(const CameraView& view) {
  const auto width = static_cast<double>(view.columns);
  const auto height = static_cast<double>(view.rows);
  PixelBounds bounds{{-1, -1}, {width, height}};
  if (!is_distorted(view.intrinsics)) return bounds;
  constexpr int steps = 32;
  for (int i = 0; i <= steps; ++i) {
    const double u = width * i / steps - 0.5;
    const double v = height * i / steps - 0.5;
    for (const ImagePoint<double>& border :
         {ImagePoint<double>{u, -0.5}, {u, height - 0.5}, {-0.5, v}, {width - 0.5, v}}) {
      const auto ideal = undistort_pixel(view.intrinsics, border);
      if (!ideal) continue;
      bounds.least.column = std::min(bounds.least.column, ideal->column - 1);
      bounds.least.row = std::min(bounds.least.row, ideal->row - 1);
      bounds.greatest.column = std::max(bounds.greatest.column, ideal->column + 1);
      bounds.greatest.row = std::max(bounds.greatest.row, ideal->row + 1);
    }
  }
  return bounds;
}

/// The part of a convex polygon with distance(p) >= 0, `distance` being linear.
template <typename Distance>
Polygon cut(const Polygon& polygon, Distance distance) {
  Polygon result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const ImagePoint<double>& p = polygon[i];
    const ImagePoint<double>& q = polygon[(i + 1) % polygon.size()];
    const double at_p = distance(p);
    const double at_q = distance(q);
    if (at_p >= 0) result.push_back(p);
    if ((at_p < 0) != (at_q < 0)) {
      const double share = at_p / (at_p - at_q);
      result.push_back({p.column + share * (q.column - p.column), p.row + share * (q.row - p.row)});
    }
  }
  return result;
}

Polygon cut_to(Polygon polygon, const PixelBounds& bounds) {
  using Point = ImagePoint<double>;
  polygon = cut(polygon, [&](const Point& p) { return p.column - bounds.least.column; });
  polygon = cut(polygon, [&](const Point& p) { return bounds.greatest.column - p.column; });
  polygon = cut(polygon, [&](const Point& p) { return p.row - bounds.least.row; });
  return cut(polygon, [&](const Point& p) { return bounds.greatest.row - p.row; });
}

/// The polygon as the lens shows it, its edges in pieces of at most a quarter of a pixel.
Polygon distort(const Polygon& polygon, const Image<double>& intrinsics) {
  constexpr double longest_piece = 0.25;
  Polygon result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const ImagePoint<double>& p = polygon[i];
    const ImagePoint<double>& q = polygon[(i + 1) % polygon.size()];
    const int pieces =
        1 + static_cast<int>(std::hypot(q.column - p.column, q.row - p.row) / longest_piece);
    for (int k = 0; k < pieces; ++k) {
      const double share = static_cast<double>(k) / pieces;
      result.push_back(
          distort_pixel(intrinsics, ImagePoint<double>{p.column + share * (q.column - p.column),
                                                       p.row + share * (q.row - p.row)}));
    }
  }
  return result;
}

/// Paints polygons given in ideal pixels.
class Painter {
 public:
  explicit Painter(const CameraView& view)
      : view_(view), bounds_(ideal_bounds(view)), coverage_(view.rows, view.columns) {}

  double column(double tangent) const {
    return view_.intrinsics.principal_column + view_.intrinsics.magnification() * tangent;
  }
  double row(double upward_tangent) const {
    return view_.intrinsics.principal_row - view_.intrinsics.magnification() * upward_tangent;
  }
  void paint(const Polygon& ideal, double weight) {
    const Polygon inside = cut_to(ideal, bounds_);
    coverage_.add(is_distorted(view_.intrinsics) ? distort(inside, view_.intrinsics) : inside,
                  weight);
  }
  /// A wall without its targets, infinitely high.
  void paint_wall(const VisiblePart& part) {
    const double left = column(part.tangent_begin);
    const double right = column(part.tangent_end);
    paint({{left, bounds_.least.row},
           {right, bounds_.least.row},
           {right, bounds_.greatest.row},
           {left, bounds_.greatest.row}},
          part.seen->wall->reflectivity - view_.background);
  }
  void paint_patch(const VisiblePart& part, const WallPatch& patch) {
    const SeenWall& seen = *part.seen;
    const double begin = std::max(patch.along_begin, seen.along_begin);
    const double end = std::min(patch.along_end, seen.along_end);
    if (begin >= end) return;
    const auto [low, high] = std::minmax({seen.tangent(begin), seen.tangent(end)});
    const double left = std::max(low, part.tangent_begin);
    const double right = std::min(high, part.tangent_end);
    if (left >= right) return;
    const double near_left = seen.inverse_depth(left);
    const double near_right = seen.inverse_depth(right);
    paint({{column(left), row(patch.top * near_left)},
           {column(right), row(patch.top * near_right)},
           {column(right), row(patch.bottom * near_right)},
           {column(left), row(patch.bottom * near_left)}},
          patch.reflectivity - seen.wall->reflectivity);
  }
  std::vector<double> values() const { return coverage_.values(view_.background); }

 private:
  const CameraView& view_;
  PixelBounds bounds_;
  AreaCoverage coverage_;
};

}  // namespace

std::vector<double> render_scene(const Scene& scene, const CameraView& view) {
  std::vector<SeenWall> walls;
  for (const Wall& wall : scene.walls) {
    SeenWall seen;
    if (see_wall(wall, view.pose, seen)) walls.push_back(seen);
  }
  Painter painter(view);
  for (const VisiblePart& part : visible_parts(walls)) {
    painter.paint_wall(part);
    for (const WallPatch& patch : target_patches(*part.seen->wall))
      painter.paint_patch(part, patch);
  }
  return painter.values();
}

}  // namespace ilss
