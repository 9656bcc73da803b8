// How values differ and move: on lines, circles and rotations, up to half a turn and at it.
#include "framework/estimate/manifold.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numbers>
#include <stdexcept>

#include "framework/estimate/random.h"
#include "framework/estimate/rotation.h"
#include "tests/allocation_count.h"
#include "tests/orientation.h"

namespace ilss {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::SpatialPose;

constexpr double pi = std::numbers::pi;
constexpr std::uint64_t seed = 8;
const PayloadDescriptor& pose() { return descriptor<SpatialPose>(); }

std::span<const double> span_of(const VectorXd& v) {
  return {v.data(), static_cast<std::size_t>(v.size())};
}

/// A vector of the given angle about an axis that is drawn.
std::array<double, 3> turn(RandomBits& random, double angle) {
  while (true) {
    std::array<double, 3> r{};
    for (double& component : r) component = draw_uniform(random, -1, 1);
    const double length = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    if (length < 0.1 || length > 1) continue;
    for (double& component : r) component *= angle / length;
    return r;
  }
}

/// Values (or errors) with turns up to `largest`, one in four nearly or quite so far.
std::vector<double> drawn_value(RandomBits& random, double largest) {
  double angle = draw_uniform(random, 0, largest);
  double joint = draw_uniform(random, -largest, largest);
  if (draw_index(random, 4) == 0) {
    const double less[] = {0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3};
    angle = largest - less[draw_index(random, 6)];
    joint = -angle;
  }
  const auto r = turn(random, angle);
  return {draw_uniform(random, -5, 5), r[0], r[1], r[2], draw_uniform(random, -5, 5), joint};
}

double apart(const std::vector<double>& a, const std::vector<double>& b) {
  return difference(pose(), a, b).norm();
}

TEST(Manifold, DifferenceLeadsBackToTheValue) {
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  RandomBits random(seed);
  for (int i = 0; i < 20000; ++i) {
    const auto a = drawn_value(random, pi);
    const auto b = drawn_value(random, pi);
    ASSERT_LT(apart(retract(pose(), b, span_of(difference(pose(), a, b))), a), 1e-14);
  }
}

TEST(Manifold, ErrorIsTheDifferenceThatItMakes) {
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  RandomBits random(seed + 1);
  for (int i = 0; i < 20000; ++i) {
    const auto b = drawn_value(random, pi);
    const auto e = drawn_value(random, pi - 1e-6);
    const VectorXd back = difference(pose(), retract(pose(), b, e), b);
    ASSERT_LT((back - Eigen::Map<const VectorXd>(e.data(), 6)).norm(), 1e-14);
  }
}

TEST(Manifold, DifferenceIsAntisymmetric) {
  RandomBits random(seed + 2);
  for (int i = 0; i < 20000; ++i) {
    const auto b = drawn_value(random, pi);
    const auto a = retract(pose(), b, drawn_value(random, pi - 1e-6));
    ASSERT_LT((difference(pose(), a, b) + difference(pose(), b, a)).norm(), 2e-14);
  }
}

TEST(Manifold, AtHalfATurnTheDifferenceIsHalfATurnEitherWay) {
  RandomBits random(seed + 3);
  const PayloadDescriptor& orientation = descriptor<test::Orientation>();
  for (int i = 0; i < 1000; ++i) {
    const auto b = turn(random, draw_uniform(random, 0, pi));
    const auto a = retract(orientation, b, turn(random, pi));
    EXPECT_NEAR(difference(orientation, a, b).norm(), pi, 1e-14);
    EXPECT_NEAR(difference(orientation, b, a).norm(), pi, 1e-14);
  }
}

TEST(Manifold, DifferenceDoesNotDependOnTheFrameOfTheWorld) {
  RandomBits random(seed + 4);
  const auto turned = [](const std::array<double, 3>& by, std::vector<double> value) {
    const auto r = rotation_product<double>(by, {value[1], value[2], value[3]});
    std::copy(r.begin(), r.end(), value.begin() + 1);
    return value;
  };
  for (int i = 0; i < 10000; ++i) {
    const auto by = turn(random, draw_uniform(random, 0, pi));
    const auto b = drawn_value(random, pi);
    const auto a = retract(pose(), b, drawn_value(random, pi - 1e-6));
    const VectorXd before = difference(pose(), a, b);
    ASSERT_LT((difference(pose(), turned(by, a), turned(by, b)) - before).norm(), 5e-14);
  }
}

TEST(Manifold, ResultsAreNormal) {
  RandomBits random(seed + 5);
  for (int i = 0; i < 20000; ++i) {
    const auto moved = retract(pose(), drawn_value(random, pi), drawn_value(random, 10));
    ASSERT_GE(moved[5], -pi);
    ASSERT_LT(moved[5], pi);
    ASSERT_LE(Eigen::Vector3d(moved[1], moved[2], moved[3]).norm(), pi * (1 + 1e-15));
    auto again = moved;
    normalize(pose(), again);
    ASSERT_LT(
        (Eigen::Map<const VectorXd>(again.data(), 6) - Eigen::Map<const VectorXd>(moved.data(), 6))
            .norm(),
        1e-14);
  }
}

TEST(Manifold, ResultMayTakeThePlaceOfEitherArgument) {
  const std::vector<double> a = {1, 0.3, -2, 0.4, 2, 3};
  const std::vector<double> b = {2, -1, 0.5, 0.7, 1, -3};
  const VectorXd expected = difference(pose(), a, b);
  auto in_a = a;
  difference(pose(), in_a, b, in_a);
  auto in_b = b;
  difference(pose(), a, in_b, in_b);
  EXPECT_EQ(in_a, std::vector<double>(expected.begin(), expected.end()));
  EXPECT_EQ(in_b, in_a);
  auto value = a;
  retract(pose(), value, b, value);
  auto error = b;
  retract(pose(), a, error, error);
  EXPECT_EQ(value, retract(pose(), a, b));
  EXPECT_EQ(error, value);
}

TEST(Manifold, DifferenceAndRetractIntoAnArrayDoNotAllocate) {
  SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED();
  const std::vector<double> a = {1, 0.3, -2, 0.4, 2, 3};
  std::vector<double> b = {2, -1, 0.5, 0.7, 1, -3};
  const PayloadDescriptor& type = pose();
  const std::size_t before = allocation_count;
  difference(type, a, b, b);
  retract(type, a, b, b);
  normalize(type, b);
  EXPECT_EQ(allocation_count, before);
}

/// The derivative of a function of an error, by differences that are exact to about 1e-10.
template <typename F>
MatrixXd numeric_jacobian(const F& f) {
  constexpr double step = 1e-5;
  MatrixXd result(6, 6);
  for (Eigen::Index k = 0; k < 6; ++k) {
    VectorXd e = VectorXd::Zero(6);
    e[k] = step;
    result.col(k) = (f(e) - f(-e)) / (2 * step);
  }
  return result;
}

TEST(Manifold, JacobiansAreWhatSmallErrorsDo) {
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  RandomBits random(seed + 6);
  constexpr double tolerance = 2e-8;
  for (int i = 0; i < 300; ++i) {
    const auto b = drawn_value(random, pi);
    const auto d = drawn_value(random, 3);
    const auto a = retract(pose(), b, d);
    const auto moved = [](const std::vector<double>& value, const VectorXd& e) {
      return retract(pose(), value, span_of(e));
    };
    ASSERT_LT((numeric_jacobian([&](const VectorXd& e) {
                 return VectorXd(difference(pose(), moved(a, e), b));
               }) -
               difference_by_first(pose(), d))
                  .norm(),
              tolerance);
    ASSERT_LT((numeric_jacobian([&](const VectorXd& e) {
                 return VectorXd(difference(pose(), a, moved(b, e)));
               }) -
               difference_by_second(pose(), d))
                  .norm(),
              tolerance);
    ASSERT_LT((numeric_jacobian([&](const VectorXd& e) {
                 return VectorXd(difference(pose(), retract(pose(), moved(b, e), d), a));
               }) -
               retract_by_value(pose(), d))
                  .norm(),
              tolerance);
    ASSERT_LT((numeric_jacobian([&](const VectorXd& e) {
                 std::vector<double> more = d;
                 for (std::size_t c = 0; c < 6; ++c) more[c] += e[static_cast<Eigen::Index>(c)];
                 return VectorXd(difference(pose(), retract(pose(), b, more), a));
               }) -
               retract_by_error(pose(), d))
                  .norm(),
              tolerance);
  }
}

TEST(Manifold, JacobianOfAFunctionByErrorsIsThatOfItsTangents) {
  // f: the rotation of the inverse, r -> -r, whose tangent map is known: R(r) R(e) inverts to
  // R(e)ᵀ R(r)ᵀ = R(-r) R(-R(r) e).
  const PayloadDescriptor& type = descriptor<test::Orientation>();
  RandomBits random(seed + 7);
  for (int i = 0; i < 100; ++i) {
    const auto r = turn(random, draw_uniform(random, 0, pi));
    const std::array inverse = {-r[0], -r[1], -r[2]};
    Eigen::Matrix3d jacobian = -Eigen::Matrix3d::Identity();
    jacobian_of_errors(type, inverse, type, r, std::span(jacobian.data(), 9));
    EXPECT_LT((jacobian + rotation_matrix(r)).norm(), 1e-13);
  }
}

TEST(Manifold, MeanTurnsWithTheWorldAndIsNoOneOfItsValuesInParticular) {
  RandomBits random(seed + 8);
  const PayloadDescriptor& type = descriptor<test::Orientation>();
  for (int i = 0; i < 200; ++i) {
    const auto centre = turn(random, draw_uniform(random, 0, pi));
    std::vector<std::vector<double>> values;
    for (int n = 0; n < 5; ++n)
      values.push_back(retract(type, centre, turn(random, draw_uniform(random, 0, 0.8))));
    const std::vector<double> weights = {0.1, 0.3, 0.2, 0.15, 0.25};
    std::vector<std::span<const double>> spans(values.begin(), values.end());
    const auto mean = weighted_mean(type, spans, weights);
    VectorXd sum = VectorXd::Zero(3);
    for (std::size_t n = 0; n < 5; ++n) sum += weights[n] * difference(type, values[n], mean);
    EXPECT_LT(sum.norm(), 1e-13);
    const std::vector<std::span<const double>> reversed(spans.rbegin(), spans.rend());
    const std::vector<double> reversed_weights(weights.rbegin(), weights.rend());
    EXPECT_LT(difference(type, weighted_mean(type, reversed, reversed_weights), mean).norm(),
              1e-13);
  }
}

TEST(Payload, OfOtherGeometryIsAnother) {
  PayloadDescriptor circular{"angle", "", {{"a", "rad", "", {}, Geometry::circular}}};
  PayloadDescriptor plain{"angle", "", {{"a", "rad", "", {}, Geometry::plain}}};
  EXPECT_FALSE(same_payload(circular, plain));
  EXPECT_NE(&intern_payload(circular), &intern_payload(plain));
}

TEST(Payload, RotationsHaveThreeComponentsInRadians) {
  const Component r{"r", "rad", "", {}, Geometry::rotation};
  EXPECT_THROW((void)intern_payload({"two", "", {r, r}}), std::invalid_argument);
  EXPECT_THROW((void)intern_payload({"four", "", {r, r, r, r}}), std::invalid_argument);
  EXPECT_THROW((void)intern_payload({"split", "", {r, r, {"x", "m", "", {}}, r}}),
               std::invalid_argument);
  const Component metres{"r", "m", "", {}, Geometry::rotation};
  EXPECT_THROW((void)intern_payload({"metres", "", {metres, metres, metres}}),
               std::invalid_argument);
  EXPECT_NO_THROW((void)intern_payload({"six", "", {r, r, r, r, r, r}}));
}

}  // namespace
}  // namespace ilss
