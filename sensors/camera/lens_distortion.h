// Lens distortion by OpenCV's radial and tangential model, generic in the scalar.
#pragma once

#include <cmath>
#include <optional>

#include "framework/estimate/differentiate.h"
#include "sensors/camera/image.h"

namespace ilss {

/// A position in an image (pixels), or in the normalised image plane at unit distance.
template <typename T>
struct ImagePoint {
  T column;
  T row;
};

/// The normalised position at which a lens shows the ideal normalised position p (columns to the
/// right, rows downwards), with r² = x² + y²:
///   x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²)
///   y' = y (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2 y²) + 2 p2 x y
template <typename T>
ImagePoint<T> distort_normalized(const Image<T>& camera, const ImagePoint<T>& p) {
  const T& x = p.column;
  const T& y = p.row;
  const T r2 = x * x + y * y;
  const T radial = 1.0 + r2 * (camera.k1 + r2 * (camera.k2 + r2 * camera.k3));
  return {x * radial + 2.0 * camera.p1 * x * y + camera.p2 * (r2 + 2.0 * x * x),
          y * radial + camera.p1 * (r2 + 2.0 * y * y) + 2.0 * camera.p2 * x * y};
}

/// Whether a camera's lens distorts at all.
inline bool is_distorted(const Image<double>& camera) {
  return camera.k1 != 0 || camera.k2 != 0 || camera.p1 != 0 || camera.p2 != 0 || camera.k3 != 0;
}

/// The pixel that shows what a lens without distortion would show at pixel `ideal`.
template <typename T>
ImagePoint<T> distort_pixel(const Image<T>& camera, const ImagePoint<T>& ideal) {
  const T scale = camera.magnification();
  const ImagePoint<T> shown =
      distort_normalized(camera, ImagePoint<T>{(ideal.column - camera.principal_column) / scale,
                                               (ideal.row - camera.principal_row) / scale});
  return {camera.principal_column + scale * shown.column, camera.principal_row + scale * shown.row};
}

/// A camera whose components carry no derivatives by `N` further variables.
template <std::size_t N>
Image<Dual<N>> constant_camera(const Image<double>& camera) {
  Image<Dual<N>> result{};
  const auto in = components(camera);
  const auto out = components(result);
  for (std::size_t i = 0; i < in.size(); ++i) out[i] = Dual<N>(in[i]);
  return result;
}

/// Where a pixel goes, and the derivatives of that by the ideal column and row.
struct DistortionAt {
  ImagePoint<double> shown;
  ImagePoint<double> by_column;
  ImagePoint<double> by_row;
};
inline DistortionAt distortion_at(const Image<double>& camera, const ImagePoint<double>& ideal) {
  using D = Dual<2>;
  const ImagePoint<D> shown =
      distort_pixel(constant_camera<2>(camera), ImagePoint<D>{D(ideal.column, 0), D(ideal.row, 1)});
  return {{shown.column.a, shown.row.a},
          {shown.column.v[0], shown.row.v[0]},
          {shown.column.v[1], shown.row.v[1]}};
}

namespace internal {

/// Solves J step = error for the 2 x 2 Jacobian of `at`.
template <typename T>
ImagePoint<T> newton_step(const DistortionAt& at, const ImagePoint<T>& error) {
  const double determinant =
      at.by_column.column * at.by_row.row - at.by_row.column * at.by_column.row;
  return {(at.by_row.row * error.column - at.by_row.column * error.row) / determinant,
          (at.by_column.column * error.row - at.by_column.row * error.column) / determinant};
}

}  // namespace internal

/// The inverse of `distort_pixel`: Newton's method on the values, whose last step is taken in T so
/// that the derivatives by the position and by the camera come out right. Nothing where the lens
/// shows no point there (beyond the radius at which its model folds back).
template <typename T>
std::optional<ImagePoint<T>> undistort_pixel(const Image<T>& camera, const ImagePoint<T>& shown) {
  Image<double> values{};
  const auto in = components(camera);
  const auto out = components(values);
  for (std::size_t i = 0; i < in.size(); ++i) out[i] = scalar_value(in[i]);
  const ImagePoint<double> target{scalar_value(shown.column), scalar_value(shown.row)};

  ImagePoint<double> ideal = target;
  constexpr int most_iterations = 20;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const DistortionAt at = distortion_at(values, ideal);
    const ImagePoint<double> step = internal::newton_step(
        at, ImagePoint<double>{at.shown.column - target.column, at.shown.row - target.row});
    ideal = {ideal.column - step.column, ideal.row - step.row};
    const double length = std::hypot(step.column, step.row);
    if (!std::isfinite(length)) return std::nullopt;
    if (length > 1e-10 * (1 + std::hypot(ideal.column, ideal.row))) continue;
    const DistortionAt last = distortion_at(values, ideal);
    // A lens never turns the image over; a solution that does lies beyond the fold.
    if (!(last.by_column.column * last.by_row.row > last.by_row.column * last.by_column.row))
      return std::nullopt;
    const ImagePoint<T> again = distort_pixel(camera, ImagePoint<T>{T(ideal.column), T(ideal.row)});
    const ImagePoint<T> correction = internal::newton_step(
        last, ImagePoint<T>{again.column - shown.column, again.row - shown.row});
    return ImagePoint<T>{ideal.column - correction.column, ideal.row - correction.row};
  }
  return std::nullopt;
}

}  // namespace ilss
