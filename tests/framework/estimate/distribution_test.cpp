// Laws of error: unit variance and their ends, by many draws.
#include "framework/estimate/distribution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numbers>
#include <vector>

namespace ilss {
namespace {

Distribution law(Shape shape) {
  Distribution distribution{shape, 0, nullptr};
  if (shape == Shape::student_t) distribution.degrees_of_freedom = 12;
  if (shape == Shape::empirical)
    distribution.samples = std::make_shared<const std::vector<double>>(
        std::vector<double>{-std::sqrt(1.5), 0, std::sqrt(1.5)});
  return distribution;
}

class EveryLaw : public testing::TestWithParam<Shape> {};

TEST_P(EveryLaw, HasZeroMeanAndUnitVarianceWithinItsEnds) {
  const Distribution distribution = law(GetParam());
  RandomBits random(17);
  constexpr int draws = 1'000'000;
  double sum = 0;
  double squares = 0;
  double largest = 0;
  for (int i = 0; i < draws; ++i) {
    const double x = draw(distribution, random);
    sum += x;
    squares += x * x;
    largest = std::max(largest, std::abs(x));
  }
  EXPECT_NEAR(sum / draws, 0, 0.005);
  EXPECT_NEAR(squares / draws, 1, 0.01);
  if (half_width(GetParam()) > 0) {
    EXPECT_LE(largest, half_width(GetParam()));
    EXPECT_GT(largest, 0.99 * half_width(GetParam()));
  }
}

// Drawn once by this program; what they pin is that they are the same wherever it is built.
TEST(Draw, IsTheSameEverywhere) {
  RandomBits random(2);
  EXPECT_EQ(draw({Shape::student_t, 5, nullptr}, random), -0x1.fadf81049995dp-1);
  EXPECT_EQ(draw({Shape::arcsine, 0, nullptr}, random), 0x1.ddb414e152063p-2);
}

/// The largest distance between the distribution of draws and the law's, times sqrt(n).
template <typename Law>
double kolmogorov_statistic(const Distribution& distribution, Law distribution_function) {
  constexpr int n = 100'000;
  RandomBits random(18);
  std::vector<double> draws(n);
  for (double& x : draws) x = draw(distribution, random);
  std::sort(draws.begin(), draws.end());
  double largest = 0;
  for (int i = 0; i < n; ++i) {
    const double p = distribution_function(draws[static_cast<std::size_t>(i)]);
    largest = std::max({largest, p - i / double{n}, (i + 1) / double{n} - p});
  }
  return largest * std::sqrt(double{n});
}
constexpr double once_in_a_thousand = 1.95;  // exceeded by the right law (Kolmogorov)

TEST(Draw, OfStudentsTIsThatOfItsDegreesOfFreedom) {
  for (const double n : {2.5, 12.0}) {
    const boost::math::students_t law_of_n(n);
    EXPECT_LT(
        kolmogorov_statistic({Shape::student_t, n, nullptr},
                             [&](double x) { return cdf(law_of_n, x / std::sqrt((n - 2) / n)); }),
        once_in_a_thousand)
        << n << " degrees of freedom";
  }
}

TEST(Draw, OfTheArcsineLawIsThatLaw) {
  EXPECT_LT(
      kolmogorov_statistic(
          {Shape::arcsine, 0, nullptr},
          [](double x) { return 0.5 + std::asin(x / std::numbers::sqrt2) / std::numbers::pi; }),
      once_in_a_thousand);
}

INSTANTIATE_TEST_SUITE_P(Laws, EveryLaw,
                         testing::Values(Shape::normal, Shape::uniform, Shape::triangular,
                                         Shape::arcsine, Shape::student_t, Shape::empirical),
                         [](const auto& law_of_test) {
                           return std::string(shape_name(law_of_test.param));
                         });

}  // namespace
}  // namespace ilss
