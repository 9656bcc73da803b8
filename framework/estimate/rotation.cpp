#include "framework/estimate/rotation.h"

#include <numbers>

namespace ilss {
namespace {

double squared_angle(const RotationVector<double>& r) {
  return r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
}

/// I + `first` [r] + `second` [r]², [r] the matrix of the cross product with r.
Eigen::Matrix3d polynomial(const RotationVector<double>& rotation, double first, double second) {
  const Eigen::Map<const Eigen::Vector3d> r(rotation.data());
  Eigen::Matrix3d cross;
  cross << 0, -r[2], r[1], r[2], 0, -r[0], -r[1], r[0], 0;
  return (1 - second * r.squaredNorm()) * Eigen::Matrix3d::Identity() + first * cross +
         second * r * r.transpose();
}

/// (1 - cos t)/t² without the cancellation.
double cosine_factor(double square) {
  if (square < 1e-8) return 0.5 - square / 24;
  const double half = std::sqrt(square) / 2;
  const double ratio = std::sin(half) / half;
  return ratio * ratio / 2;
}

}  // namespace

RotationVector<double> shortest(const RotationVector<double>& rotation) {
  return squared_angle(rotation) <= std::numbers::pi * std::numbers::pi
             ? rotation
             : internal::rotation_vector_of(internal::quaternion_of(rotation));
}

Eigen::Matrix3d rotation_matrix(const RotationVector<double>& rotation) {
  const double square = squared_angle(rotation);
  const double angle = std::sqrt(square);
  const double sine_factor = square < 1e-8 ? 1 - square / 6 : std::sin(angle) / angle;
  return polynomial(rotation, sine_factor, cosine_factor(square));
}

Eigen::Matrix3d right_jacobian(const RotationVector<double>& rotation) {
  const double q = squared_angle(rotation);
  const double angle = std::sqrt(q);
  const double second =
      q < 0.1 ? (1 - q / 20 * (1 - q / 42 * (1 - q / 72 * (1 - q / 110 * (1 - q / 156))))) / 6
              : (angle - std::sin(angle)) / (q * angle);
  return polynomial(rotation, -cosine_factor(q), second);
}

Eigen::Matrix3d inverse_right_jacobian(const RotationVector<double>& rotation) {
  const double q = squared_angle(rotation);
  const double half = std::sqrt(q) / 2;
  // Coefficients of the series |B_2n| / (2n)!, Bernoulli numbers.
  const double second =
      q < 0.1
          ? 1.0 / 12 +
                q * (1.0 / 720 +
                     q * (1.0 / 30240 +
                          q * (1.0 / 1209600 + q * (1.0 / 47900160 + q * (691.0 / 1307674368000)))))
          : (1 - half * std::cos(half) / std::sin(half)) / q;
  return polynomial(rotation, 0.5, second);
}

}  // namespace ilss
