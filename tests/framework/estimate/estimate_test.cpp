// Estimates: differences on the circle and linear combinations.
#include "framework/estimate/estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "framework/estimate/differentiate.h"
#include "framework/estimate/random.h"

namespace ilss {
namespace {

constexpr double pi = std::numbers::pi;

template <typename T>
struct Pose {
  T range, angle;
  static constexpr std::string_view name = "test_pose";
  static constexpr auto fields =
      Fields{{"range", "m", "", 1.5}, {"angle", "rad", "", required, Geometry::circular}};
};

Estimate pose(double range, double angle) {
  Estimate e(descriptor<Pose>(), "robot");
  e.value = {range, angle};
  return e;
}

TEST(WrapAngle, StaysInTheHalfOpenIntervalAndChangesByWholeTurnsOnly) {
  RandomBits bits(1);
  std::vector<double> angles = {0, pi, -pi, 3 * pi, -3 * pi, std::nextafter(pi, 0), 1e-300};
  for (int turns = -1000; turns <= 1000; ++turns)
    for (const double direction : {-10.0, 0.0, 10.0})
      angles.push_back(std::nextafter((2 * turns + 1) * pi, direction * 1e4));
  for (int i = 0; i < 10000; ++i) angles.push_back(draw_uniform(bits, -1e4, 1e4));
  for (const double angle : angles) {
    SCOPED_TRACE(angle);
    const double wrapped = wrap_angle(angle);
    ASSERT_GE(wrapped, -pi);
    ASSERT_LT(wrapped, pi);
    const double turns = (angle - wrapped) / (2 * pi);
    ASSERT_NEAR(turns, std::round(turns), 1e-9);
  }
}

TEST(WrapAngle, PassesDerivativesUnchanged) {
  const Dual<2> angle(3.5, 1);
  const Dual<2> wrapped = wrap_angle(angle);
  EXPECT_DOUBLE_EQ(wrapped.a, 3.5 - 2 * pi);
  EXPECT_EQ(wrapped.v[0], 0.0);
  EXPECT_EQ(wrapped.v[1], 1.0);
}

TEST(Estimate, StartsExactAtTheDefaults) {
  const Estimate e(descriptor<Pose>(), "robot");
  EXPECT_EQ(e.value, (std::vector<double>{1.5, 0.0}));
  EXPECT_TRUE(e.lineage.empty());
  EXPECT_EQ(e.lineage.dimension(), 2u);
}

TEST(Difference, WrapsCircularComponentsOnly) {
  const Eigen::VectorXd d = difference(pose(10, 3.1), std::vector{1.0, -3.1});
  EXPECT_DOUBLE_EQ(d[0], 9.0);
  EXPECT_NEAR(d[1], 6.2 - 2 * pi, 1e-15);
}

TEST(LinearCombination, OfAnEstimateMinusItselfIsExactlyZeroWithoutError) {
  Estimate x = pose(0.1, 0.2);
  x.lineage.add_noise({0, 0, 0}, (Eigen::Matrix2d() << 2, 0.3, 0.3, 1).finished());
  x.lineage.add({1, 0, persistent_tick}, 0, 0.7);
  const Estimate zero = linear_combination(std::vector{x, x}, std::vector{1.0, -1.0});
  EXPECT_EQ(zero.value, (std::vector<double>{0.0, 0.0}));
  EXPECT_EQ(zero.lineage.covariance(), Eigen::Matrix2d::Zero());
}

TEST(LinearCombination, OfAnglesOnEitherSideOfPiIsNearPi) {
  const Estimate mean = linear_combination(std::vector{pose(1, pi - 0.01), pose(3, -pi + 0.03)},
                                           std::vector{0.5, 0.5});
  EXPECT_DOUBLE_EQ(mean.value[0], 2.0);
  EXPECT_NEAR(mean.value[1], -pi + 0.01, 1e-12);
  const Estimate other = linear_combination(std::vector{pose(1, -pi + 0.03), pose(3, pi - 0.01)},
                                            std::vector{0.5, 0.5});
  EXPECT_NEAR(other.value[1], -pi + 0.01, 1e-12);
}

TEST(LinearCombination, MeanOverTicksAveragesOutRandomErrorsButNotPersistentOnes) {
  constexpr std::size_t n = 1000;
  constexpr double random = 0.02;
  constexpr double persistent = 0.003;
  std::vector<Estimate> ticks;
  for (std::size_t t = 0; t < n; ++t) {
    ticks.push_back(pose(2, 0));
    ticks.back().lineage.add({0, 0, static_cast<std::int64_t>(t)}, 0, random);
    ticks.back().lineage.add({1, 0, persistent_tick}, 0, persistent);
  }
  const Estimate mean = linear_combination(ticks, std::vector<double>(n, 1.0 / n));
  EXPECT_NEAR(mean.value[0], 2.0, 1e-12);
  Lineage of_random(2);
  Lineage of_persistent(2);
  for (std::size_t k = 0; k < mean.lineage.size(); ++k)
    (mean.lineage.sources()[k].persistent() ? of_persistent : of_random)
        .add(mean.lineage.sources()[k], mean.lineage.column(k));
  EXPECT_NEAR(of_random.standard_deviation(0), random / std::sqrt(1000.0), 1e-14);
  EXPECT_NEAR(of_persistent.standard_deviation(0), persistent, 1e-14);
}

TEST(LinearCombination, KeepsUnknownCorrelationOfAnyEstimate) {
  Estimate b = pose(2, 0);
  b.correlation_unknown = true;
  EXPECT_TRUE(
      linear_combination(std::vector{pose(1, 0), b}, std::vector{1.0, 1.0}).correlation_unknown);
}

TEST(LinearCombination, SaysWhyItRefuses) {
  const auto message = [](const std::vector<Estimate>& estimates, std::vector<double> weights) {
    try {
      (void)linear_combination(estimates, weights);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("no refusal");
  };
  EXPECT_EQ(message({}, {}),
            "a linear combination needs a weight for each of at least one estimate; got 0 "
            "estimates, 0 weights");
  EXPECT_EQ(message({pose(1, 0)}, {1, 1}),
            "a linear combination needs a weight for each of at least one estimate; got 1 "
            "estimates, 2 weights");
  Estimate elsewhere = pose(1, 0);
  elsewhere.frame = "camera";
  EXPECT_EQ(message({pose(1, 0), elsewhere}, {1, 1}),
            "a linear combination needs estimates of one payload in one frame; got test_pose in "
            "'robot' and test_pose in 'camera'");
  EXPECT_EQ(message({pose(1, 0), Estimate{}}, {1, 1}),
            "a linear combination needs estimates that have a payload type");
}

TEST(Payload, RoundTripsThroughAnEstimate) {
  Estimate e = pose(0, 0);
  e.lineage.add({0, 0, 0}, 0, 1.0);
  e.correlation_unknown = true;
  assign<Pose>(e, {2.5, -0.5});
  EXPECT_TRUE(e.lineage.empty());
  EXPECT_FALSE(e.correlation_unknown);
  const Pose<double> back = payload_of<Pose>(e);
  EXPECT_EQ(back.range, 2.5);
  EXPECT_EQ(back.angle, -0.5);
}

}  // namespace
}  // namespace ilss
