// Rotations in space: exponential, logarithm and their Jacobians from no rotation to half a turn.
#include "framework/estimate/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <vector>

#include "framework/estimate/random.h"

namespace ilss {
namespace {

constexpr double pi = std::numbers::pi;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector = RotationVector<double>;

Vector3d vector_of(const Vector& r) { return {r[0], r[1], r[2]}; }
Vector from(const Vector3d& r) { return {r[0], r[1], r[2]}; }

/// Axes drawn, angles chosen where formulas change or fail.
std::vector<Vector> rotations() {
  std::vector<Vector> result = {{0, 0, 0}, {pi, 0, 0}, {0, -pi, 0}, {0, 0, pi}};
  RandomBits random(20261128);
  for (const double angle :
       {1e-300, 1e-160,    1e-12,     1e-8,      1e-5,       1e-4, 1e-3, 0.0999,
        0.1001, 0.2,       0.2236,    0.3162,    0.3163,     0.5,  1.0,  2.0,
        3.0,    pi - 1e-3, pi - 1e-6, pi - 1e-9, pi - 1e-13, pi})
    for (int i = 0; i < 20; ++i) {
      Vector3d axis;
      do axis = Vector3d::NullaryExpr([&] { return draw_uniform(random, -1, 1); });
      while (axis.norm() < 0.1 || axis.norm() > 1);
      result.push_back(from(angle * axis.normalized()));
    }
  return result;
}

/// The rotation matrix by another way than ours.
Matrix3d reference(const Vector& r) {
  const Vector3d v = vector_of(r);
  const double angle = v.stableNorm();
  if (angle == 0) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

TEST(Rotation, MatrixIsTheTurnAboutTheAxis) {
  for (const Vector& r : rotations())
    ASSERT_LT((rotation_matrix(r) - reference(r)).norm(), 2e-15) << vector_of(r).transpose();
}

TEST(Rotation, ProductIsThatOfTheMatrices) {
  for (const Vector& a : rotations())
    for (const Vector& b : rotations())
      ASSERT_LT((reference(rotation_product(a, b)) - reference(a) * reference(b)).norm(), 5e-15)
          << vector_of(a).transpose() << " and " << vector_of(b).transpose();
}

TEST(Rotation, OfNoTurnComesBackToTheLastBits) {
  for (const Vector& r : rotations()) {
    const Vector back = rotation_product<double>({0, 0, 0}, r);
    const double angle = vector_of(r).stableNorm();
    const Vector3d apart = vector_of(back) - vector_of(r);
    // At half a turn itself the other vector is the same rotation.
    const Vector3d other = vector_of(back) + vector_of(r);
    const double error =
        std::abs(angle - pi) < 1e-12 ? std::min(apart.norm(), other.norm()) : apart.stableNorm();
    ASSERT_LE(error, 1e-15 * angle) << vector_of(r).transpose();
  }
}

TEST(Rotation, IsNeverLongerThanHalfATurn) {
  RandomBits random(3);
  for (int i = 0; i < 10000; ++i) {
    const Vector r = from(Vector3d::NullaryExpr([&] { return draw_uniform(random, -20, 20); }));
    const Vector s = shortest(r);
    ASSERT_LE(vector_of(s).norm(), pi * (1 + 1e-15));
    ASSERT_LT((reference(s) - reference(r)).norm(), 1e-13);
    ASSERT_EQ(shortest(s), s);
  }
}

TEST(Rotation, DifferenceIsSmallWhereRotationsAreOnEitherSideOfHalfATurn) {
  for (const Vector& r : rotations()) {
    const double angle = vector_of(r).norm();
    if (angle < 3.1) continue;
    const double over = 1e-3;
    const Vector3d axis = vector_of(r) / angle;
    const Vector beyond = from(-(2 * pi - pi - over) * axis);  // pi + over about the axis
    const Vector d = rotation_between(r, beyond);
    ASSERT_LT((vector_of(d) - (pi + over - angle) * axis).norm(), 1e-14);
  }
}

/// d log(exp(-at) exp(at + e)) / de at e = 0, by automatic differentiation.
Matrix3d automatic_right_jacobian(const Vector& at) {
  const RotationVector<Dual<3>> start = {Dual<3>(at[0]), Dual<3>(at[1]), Dual<3>(at[2])};
  RotationVector<Dual<3>> moved;
  seed_variables<3>(at, 0, moved);
  const auto apart = rotation_between(start, moved);
  Matrix3d result;
  for (int i = 0; i < 3; ++i) result.row(i) = apart[static_cast<std::size_t>(i)].v.transpose();
  return result;
}

/// d log(exp(at) exp(e)) / de at e = 0.
Matrix3d automatic_inverse_right_jacobian(const Vector& at) {
  const RotationVector<Dual<3>> start = {Dual<3>(at[0]), Dual<3>(at[1]), Dual<3>(at[2])};
  RotationVector<Dual<3>> error;
  seed_variables<3>(std::array{0.0, 0.0, 0.0}, 0, error);
  const auto moved = rotation_product(start, error);
  Matrix3d result;
  for (int i = 0; i < 3; ++i) result.row(i) = moved[static_cast<std::size_t>(i)].v.transpose();
  return result;
}

TEST(Rotation, RightJacobianIsTheAutomaticOne) {
  for (const Vector& r : rotations())
    ASSERT_LT((right_jacobian(r) - automatic_right_jacobian(r)).norm(), 1e-12)
        << vector_of(r).transpose();
}

TEST(Rotation, InverseRightJacobianIsTheAutomaticOne) {
  for (const Vector& r : rotations()) {
    Matrix3d automatic = automatic_inverse_right_jacobian(r);
    // At half a turn the logarithm may have taken the other vector.
    const Vector back = rotation_product<double>(r, {0, 0, 0});
    if (vector_of(back).dot(vector_of(r)) < 0) {
      ASSERT_LT((inverse_right_jacobian(back) - automatic).norm(), 1e-11);
      continue;
    }
    ASSERT_LT((inverse_right_jacobian(r) - automatic).norm(), 1e-11) << vector_of(r).transpose();
  }
}

TEST(Rotation, JacobiansAreInverseToEachOther) {
  for (const Vector& r : rotations())
    ASSERT_LT((right_jacobian(r) * inverse_right_jacobian(r) - Matrix3d::Identity()).norm(), 1e-13)
        << vector_of(r).transpose();
}

}  // namespace
}  // namespace ilss
