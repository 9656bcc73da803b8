// Seeded streams: independent of each other, and the laws that are drawn from them.
#include "framework/estimate/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <set>
#include <vector>

#include "framework/estimate/consistency.h"

namespace ilss {
namespace {

TEST(RandomBits, FollowsTheReferenceSplitmix64) {
  // First outputs of Vigna's splitmix64.c (prng.di.unimi.it) from state 1234567, as published with
  // the Rosetta Code task "Pseudo-random numbers/Splitmix64".
  RandomBits bits(1234567);
  EXPECT_EQ(bits(), 6457827717110365317u);
  EXPECT_EQ(bits(), 3203168211198807973u);
  EXPECT_EQ(bits(), 9817491932198370423u);
}

TEST(DeriveSeed, DiffersByPurposeAndBySeed) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    for (std::uint64_t purpose = 0; purpose < 100; ++purpose)
      seeds.insert(derive_seed(seed, purpose));
    seeds.insert(derive_seed(seed, "left"));
    seeds.insert(derive_seed(seed, "right"));
  }
  EXPECT_EQ(seeds.size(), 100u * 102u);
  static_assert(derive_seed(1, "left") == derive_seed(1, "left"));
}

TEST(RandomBits, StreamsOfNeighbouringPurposesAreUncorrelated) {
  constexpr int n = 100'000;
  RandomBits a(derive_seed(42, 1));
  RandomBits b(derive_seed(42, 2));
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += draw_normal(a) * draw_normal(b);
  EXPECT_LT(std::abs(sum / n), 4 / std::sqrt(n));
}

/// The largest distance between the distribution of draws and the law's, times sqrt(n); a right
/// one exceeds 1.95 once in a thousand seeds (Kolmogorov).
template <typename Draw, typename Law>
double kolmogorov_statistic(std::uint64_t seed, Draw draw, Law distribution_function) {
  constexpr int n = 1'000'000;
  RandomBits random(derive_seed(seed, "kolmogorov"));
  std::vector<double> draws(n);
  for (double& x : draws) x = draw(random);
  std::sort(draws.begin(), draws.end());
  double largest = 0;
  for (int i = 0; i < n; ++i) {
    const double p = distribution_function(draws[static_cast<std::size_t>(i)]);
    largest = std::max({largest, p - i / double{n}, (i + 1) / double{n} - p});
  }
  return largest * std::sqrt(double{n});
}
constexpr double once_in_a_thousand = 1.95;

double normal_distribution_function(double x) { return std::erfc(-x / std::numbers::sqrt2) / 2; }

TEST(DrawUnit, IsUniform) {
  const auto uniform = [](double x) { return x; };
  EXPECT_LT(kolmogorov_statistic(1, draw_unit, uniform), once_in_a_thousand);
}

TEST(DrawUnit, IsNeverOne) {
  RandomBits random(2);
  for (int i = 0; i < 1'000'000; ++i) {
    const double x = draw_unit(random);
    ASSERT_GE(x, 0);
    ASSERT_LT(x, 1);
  }
  EXPECT_LT(static_cast<double>(RandomBits::max() >> 11) * 0x1p-53, 1);
}

TEST(DrawNormal, IsNormal) {
  for (const std::uint64_t seed : {1, 2, 3})
    EXPECT_LT(kolmogorov_statistic(seed, draw_normal, normal_distribution_function),
              once_in_a_thousand)
        << "seed " << seed;
}

TEST(DrawNormal, TestTellsALawThatIsNotQuiteNormal) {
  const auto wide = [](RandomBits& random) { return 1.01 * draw_normal(random); };
  EXPECT_GT(kolmogorov_statistic(1, wide, normal_distribution_function), once_in_a_thousand);
}

TEST(DrawNormal, HasTheMomentsOfANormal) {
  constexpr int n = 1'000'000;
  RandomBits bits(derive_seed(7, "moments"));
  double moments[4] = {};
  for (int i = 0; i < n; ++i) {
    const double x = draw_normal(bits);
    double power = 1;
    for (double& moment : moments) moment += (power *= x);
  }
  // Standard deviations of the sample moments: sqrt((m_2k - m_k²) / n) with m = 0, 1, 0, 3, 0, 15,
  // 0, 105; four of each.
  const double root_n = std::sqrt(n);
  EXPECT_NEAR(moments[0] / n, 0, 4 * 1 / root_n);
  EXPECT_NEAR(moments[1] / n, 1, 4 * std::sqrt(2.0) / root_n);
  EXPECT_NEAR(moments[2] / n, 0, 4 * std::sqrt(15.0) / root_n);
  EXPECT_NEAR(moments[3] / n, 3, 4 * std::sqrt(96.0) / root_n);
}

TEST(DrawNormal, TailsHaveTheirShare) {
  constexpr double n = 10'000'000;
  const double from[] = {1, 2, 3, 3.6, 3.7, 4, 4.5};
  double beyond[2][std::size(from)] = {};
  RandomBits random(derive_seed(9, "tails"));
  for (int i = 0; i < static_cast<int>(n); ++i) {
    const double x = draw_normal(random);
    for (std::size_t k = 0; k < std::size(from); ++k)
      if (std::abs(x) > from[k]) ++beyond[x < 0 ? 1 : 0][k];
  }
  for (std::size_t k = 0; k < std::size(from); ++k)
    for (const auto& side : beyond) {
      const double expected = n * normal_distribution_function(-from[k]);
      EXPECT_NEAR(side[k], expected, 4 * std::sqrt(expected)) << "beyond " << from[k];
    }
}

TEST(DrawNormal, NeighboursAreUncorrelated) {
  constexpr int n = 1'000'000;
  RandomBits random(5);
  double last = draw_normal(random);
  double sum = 0;
  double of_sizes = 0;
  for (int i = 0; i < n; ++i) {
    const double x = draw_normal(random);
    sum += x * last;
    of_sizes += (x * x - 1) * (last * last - 1);
    last = x;
  }
  EXPECT_LT(std::abs(sum / n), 4 / std::sqrt(n));
  EXPECT_LT(std::abs(of_sizes / n), 4 * 2 / std::sqrt(n));
}

TEST(DrawIndex, IsUniform) {
  constexpr std::size_t count = 7;
  constexpr double n = 700'000;
  double hits[count] = {};
  RandomBits random(3);
  for (int i = 0; i < static_cast<int>(n); ++i) ++hits[draw_index(random, count)];
  double chi_square = 0;
  for (const double hit : hits) chi_square += std::pow(hit - n / count, 2) / (n / count);
  EXPECT_TRUE(chi_square_interval(count - 1, 0.999).contains(chi_square)) << chi_square;
}

TEST(DrawIndex, HasNoBiasWhereARemainderWould) {
  // Of 3/4 of all 64-bit numbers a remainder would hit the first third twice as often.
  constexpr std::uint64_t count = std::uint64_t{3} << 62;
  constexpr double n = 300'000;
  double in_first_third = 0;
  RandomBits random(4);
  for (int i = 0; i < static_cast<int>(n); ++i)
    in_first_third += draw_index(random, count) < count / 3 ? 1 : 0;
  EXPECT_NEAR(in_first_third / n, 1.0 / 3, 4 * std::sqrt(2.0 / 9 / n));
}

// Drawn once by this program; what they pin is that they are the same wherever it is built.
TEST(Draws, AreTheSameEverywhere) {
  RandomBits random(20261128);
  const double normals[] = {-0x1.e68d735af502bp+0, 0x1.79eb2528492cdp-3, -0x1.8797e1c8fdfd8p-5,
                            0x1.110f840694789p+0};
  for (const double expected : normals) EXPECT_EQ(draw_normal(random), expected);
  EXPECT_EQ(draw_uniform(random, -1, 2), 0x1.9e9f2ecdcdc38p-2);
  EXPECT_EQ(draw_index(random, 1000), 220u);
}

TEST(Draws, AMillionNormalsAreTheSameEverywhere) {
  // Layers, wedges and tail.
  RandomBits random(1);
  double sum = 0;
  double largest = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    const double x = draw_normal(random);
    sum += x;
    largest = std::max(largest, std::abs(x));
  }
  EXPECT_EQ(sum, -0x1.07c8f27cfc7d6p+9);
  EXPECT_EQ(largest, 0x1.3b3428fd3f262p+2);
}

}  // namespace
}  // namespace ilss
