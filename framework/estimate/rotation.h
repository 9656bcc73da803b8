// Rotations in space: their products and differences as rotation vectors, and the Jacobians of the
// exponential map of SO(3). Everything holds from no rotation to half a turn.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "framework/estimate/differentiate.h"

namespace ilss {

/// Axis times angle (rad).
template <typename T>
using RotationVector = std::array<T, 3>;

namespace internal {

/// A quaternion; those of rotations have unit length.
template <typename T>
struct Quaternion {
  T w, x, y, z;
};

/// cos(angle/2) and sin(angle/2) times the axis. Series near no rotation, where the closed form
/// divides 0 by 0.
template <typename T>
Quaternion<T> quaternion_of(const RotationVector<T>& r) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
  T w{};
  T factor{};
  if (scalar_value(square) < 0.05) {
    const T q = square / 4.0;
    w = 1.0 - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0 * (1.0 - q / 90.0))));
    factor = 0.5 *
             (1.0 -
              q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0 * (1.0 - q / 110.0)))));
  } else {
    const T angle = sqrt(square);
    w = cos(angle / 2.0);
    factor = sin(angle / 2.0) / angle;
  }
  return {w, factor * r[0], factor * r[1], factor * r[2]};
}

/// The rotation vector of at most half a turn. The quaternion stays well conditioned up to there,
/// where a rotation matrix would leave the axis to what rounding spares.
template <typename T>
RotationVector<T> rotation_vector_of(const Quaternion<T>& quaternion) {
  using std::atan2;
  using std::sqrt;
  const double sign = scalar_value(quaternion.w) < 0 ? -1 : 1;  // both are the same rotation
  const auto& [w, x, y, z] = quaternion;
  const T square = x * x + y * y + z * z;
  T factor;
  if (scalar_value(square) < 0.01) {
    const T q = square / (w * w);
    factor = 2.0 / (sign * w);
    T sum = T(1.0 / 17);
    for (const double odd : {15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0, 1.0}) sum = 1 / odd - q * sum;
    factor = factor * sum;
  } else {
    const T length = sqrt(square);
    factor = 2.0 * atan2(length, T(sign * w)) / length;
  }
  factor = sign * factor;
  return {factor * x, factor * y, factor * z};
}

template <typename T>
Quaternion<T> product(const Quaternion<T>& a, const Quaternion<T>& b) {
  return {
      a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
      a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

}  // namespace internal

/// R(a) R(b): turned by b in the frame that a has turned.
template <typename T>
RotationVector<T> rotation_product(const RotationVector<T>& a, const RotationVector<T>& b) {
  return internal::rotation_vector_of(
      internal::product(internal::quaternion_of(a), internal::quaternion_of(b)));
}

/// R(from)ᵀ R(to): what turns `from` into `to`, seen from `from` (or from `to`, which see the axis
/// alike).
template <typename T>
RotationVector<T> rotation_between(const RotationVector<T>& from, const RotationVector<T>& to) {
  return rotation_product<T>({-from[0], -from[1], -from[2]}, to);
}

/// The same rotation by at most half a turn.
RotationVector<double> shortest(const RotationVector<double>& rotation);

/// R of a rotation vector (Rodrigues).
Eigen::Matrix3d rotation_matrix(const RotationVector<double>& rotation);

/// J_r with R(r + dr) = R(r) R(J_r dr) to first order (Chirikjian 2012, eq. 10.86; Solà et al.
/// 2018, eq. 143): I - (1 - cos t)/t² [r] + (t - sin t)/t³ [r]², t the angle. The left one is its
/// transpose.
Eigen::Matrix3d right_jacobian(const RotationVector<double>& rotation);

/// Its inverse: I + [r]/2 + (1 - t/2 cot t/2)/t² [r]² (ibid., eq. 144); there is none at whole
/// turns.
Eigen::Matrix3d inverse_right_jacobian(const RotationVector<double>& rotation);

}  // namespace ilss
