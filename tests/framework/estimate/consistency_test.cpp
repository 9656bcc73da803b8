// NEES, NIS and their chi-square bounds, including that they can fail.
#include "framework/estimate/consistency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "framework/estimate/random.h"

namespace ilss {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

template <typename T>
struct Scalar {
  T x;
  static constexpr std::string_view name = "test_scalar";
  static constexpr auto fields = Fields{{"x", "m"}};
};
template <typename T>
struct Heading {
  T angle;
  static constexpr std::string_view name = "test_heading";
  static constexpr auto fields = Fields{{"angle", "rad", "", required, Geometry::circular}};
};

/// Errors drawn with covariance root rootᵀ, judged under `claimed`.
ConsistencyStatistic judge(const MatrixXd& root, const MatrixXd& claimed, std::uint64_t seed) {
  RandomBits bits(seed);
  ConsistencyStatistic statistic;
  for (int run = 0; run < 2000; ++run) {
    const VectorXd z = VectorXd::NullaryExpr(root.cols(), [&] { return draw_normal(bits); });
    statistic.add(normalized_squared_error(root * z, claimed));
  }
  return statistic;
}

// Components of very different units: metres, radians, amperes.
const MatrixXd full_root = (MatrixXd(3, 3) << 2, 0, 0, 1e-4, 3e-4, 0, 1e-9, 0, 2e-9).finished();

TEST(Nees, OfHonestCovariancesLiesInItsBounds) {
  const ConsistencyStatistic s = judge(full_root, full_root * full_root.transpose(), 1);
  EXPECT_EQ(s.degrees_of_freedom(), 6000);
  EXPECT_TRUE(s.consistent(0.99)) << s.mean();
  EXPECT_LT(s.unexplained(), 1e-6);
}

TEST(Nees, OfWrongCovariancesDoesNot) {
  const MatrixXd honest = full_root * full_root.transpose();
  EXPECT_FALSE(judge(full_root, 0.9 * honest, 1).consistent(0.99));
  EXPECT_FALSE(judge(full_root, 1.1 * honest, 1).consistent(0.99));
  // Right variances with the correlations left out: the mean alone would not tell, but here the
  // errors have fewer dimensions than claimed.
  const MatrixXd line = (MatrixXd(2, 1) << 1, 1).finished();
  const ConsistencyStatistic s = judge(line, 1.2 * MatrixXd::Identity(2, 2), 1);
  EXPECT_FALSE(s.consistent(0.99));
}

TEST(Nees, OfASingularCovarianceCountsItsRank) {
  const MatrixXd root = (MatrixXd(4, 2) << 1, 0, 0, 1e-3, 1, 1e-3, 2, -1e-3).finished();
  const ConsistencyStatistic s = judge(root, root * root.transpose(), 2);
  EXPECT_EQ(s.degrees_of_freedom(), 4000);
  EXPECT_TRUE(s.consistent(0.99)) << s.mean();
  EXPECT_LT(s.unexplained(), 1e-5);
}

TEST(Nees, TellsErrorsThatASingularCovarianceRulesOut) {
  const MatrixXd p = (MatrixXd(2, 2) << 1, 1, 1, 1).finished();
  const NormalizedError along = normalized_squared_error(VectorXd::Constant(2, 3.0), p);
  EXPECT_EQ(along.rank, 1);
  EXPECT_NEAR(along.value, 9, 1e-12);
  EXPECT_NEAR(along.unexplained, 0, 1e-12);
  const NormalizedError across = normalized_squared_error(Eigen::Vector2d(1, -1), p);
  EXPECT_NEAR(across.value, 0, 1e-12);
  EXPECT_NEAR(across.unexplained, std::sqrt(2.0), 1e-12);
}

TEST(Nees, OfAnExactComponentAllowsNoError) {
  const MatrixXd p = Eigen::Vector2d(0, 4).asDiagonal();
  EXPECT_EQ(normalized_squared_error(Eigen::Vector2d(0, 2), p).unexplained, 0);
  EXPECT_EQ(normalized_squared_error(Eigen::Vector2d(0, 2), p).rank, 1);
  EXPECT_EQ(normalized_squared_error(Eigen::Vector2d(1e-9, 2), p).unexplained, infinity);
}

TEST(Nees, NeverTakesNotANumberForAnHonestEstimate) {
  const MatrixXd p = MatrixXd::Identity(2, 2);
  ConsistencyStatistic of_error;
  of_error.add(normalized_squared_error(Eigen::Vector2d(nan, 0), p));
  EXPECT_FALSE(of_error.consistent(0.99));
  EXPECT_EQ(of_error.unexplained(), infinity);
  ConsistencyStatistic of_covariance;
  of_covariance.add(normalized_squared_error(Eigen::Vector2d(0, 0), nan * p));
  EXPECT_FALSE(of_covariance.consistent(0.99));
}

TEST(Nees, OfNoRunsIsNotConsistent) { EXPECT_FALSE(ConsistencyStatistic{}.consistent(0.99)); }

TEST(Nees, MeasuresAnglesTheShortWayRound) {
  Estimate e(descriptor<Heading>());
  e.value = {std::numbers::pi - 0.1};
  e.lineage.add({0, 0, 0}, 0, 0.1);
  EXPECT_NEAR(nees(e, std::vector{-std::numbers::pi + 0.1}).value, 4, 1e-10);
}

Estimate scalar(double value, double shared, double own, std::uint32_t owner) {
  Estimate e(descriptor<Scalar>());
  e.value = {value};
  if (shared != 0) e.lineage.add({0, 0, persistent_tick}, 0, shared);
  if (own != 0) e.lineage.add({owner, 0, 0}, 0, own);
  return e;
}

TEST(Nis, LeavesOutErrorsThatBothShare) {
  // e = 5, P = 3² + 4²; the shared error of 100 cancels.
  const NormalizedError n = nis(scalar(5, 100, 3, 1), scalar(0, 100, 4, 2));
  EXPECT_EQ(n.rank, 1);
  EXPECT_NEAR(n.value, 1, 1e-12);
  EXPECT_NEAR(nis(scalar(5, 0, 3, 1), scalar(0, 0, 4, 2)).value, 1, 1e-12);
}

TEST(Nis, OfAnEstimateWithItselfHasNothingToTest) {
  Estimate e(descriptor<Scalar>());
  for (std::uint32_t k = 0; k < 20; ++k) e.lineage.add({0, k, 0}, 0, 0.1 * (k + 1));
  const NormalizedError n = nis(e, e);
  EXPECT_EQ(n.rank, 0);
  EXPECT_EQ(n.value, 0);
  EXPECT_EQ(n.unexplained, 0);
}

TEST(Nis, OfDisagreeingEstimatesWithOneErrorIsUnexplained) {
  EXPECT_EQ(nis(scalar(1, 2, 0, 1), scalar(0, 2, 0, 2)).unexplained, infinity);
}

TEST(ChiSquareQuantile, AgreesWithPublishedTables) {
  // NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.6.7.4, critical values of chi-square.
  const struct {
    double degrees, probability, value;
  } table[] = {{1, 0.95, 3.841},   {1, 0.99, 6.635},     {2, 0.95, 5.991},    {2, 0.999, 13.816},
               {3, 0.90, 6.251},   {5, 0.99, 15.086},    {10, 0.95, 18.307},  {10, 0.975, 20.483},
               {30, 0.99, 50.892}, {100, 0.95, 124.342}, {100, 0.05, 77.929}, {10, 0.025, 3.247}};
  for (const auto& entry : table)
    EXPECT_NEAR(chi_square_quantile(entry.degrees, entry.probability), entry.value, 5.1e-4)
        << entry.degrees << " degrees, " << entry.probability;
}

TEST(ChiSquareInterval, HasEqualTails) {
  const Interval interval = chi_square_interval(10, 0.95);
  EXPECT_NEAR(interval.low, 3.247, 5e-4);
  EXPECT_NEAR(interval.high, 20.483, 5e-4);
  EXPECT_TRUE(interval.contains(10));
  EXPECT_FALSE(interval.contains(3.2));
}

TEST(ChiSquareQuantile, RefusesWhatHasNone) {
  EXPECT_THROW((void)chi_square_quantile(0, 0.5), std::invalid_argument);
  EXPECT_THROW((void)chi_square_quantile(1, 1), std::invalid_argument);
  EXPECT_THROW((void)chi_square_quantile(1, nan), std::invalid_argument);
}

}  // namespace
}  // namespace ilss
