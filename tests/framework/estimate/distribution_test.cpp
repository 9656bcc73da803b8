// Laws of error: unit variance and their ends, by many draws.
#include "framework/estimate/distribution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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

INSTANTIATE_TEST_SUITE_P(Laws, EveryLaw,
                         testing::Values(Shape::normal, Shape::uniform, Shape::triangular,
                                         Shape::arcsine, Shape::student_t, Shape::empirical),
                         [](const auto& law_of_test) {
                           return std::string(shape_name(law_of_test.param));
                         });

}  // namespace
}  // namespace ilss
