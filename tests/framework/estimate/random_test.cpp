// Seeded streams: independent of each other, and random enough for normals.
#include "framework/estimate/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

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
  std::normal_distribution<double> normal_a;
  std::normal_distribution<double> normal_b;
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += normal_a(a) * normal_b(b);
  EXPECT_LT(std::abs(sum / n), 4 / std::sqrt(n));
}

TEST(RandomBits, NormalsHaveTheMomentsOfANormal) {
  constexpr int n = 1'000'000;
  RandomBits bits(derive_seed(7, "moments"));
  std::normal_distribution<double> normal;
  double moments[4] = {};
  for (int i = 0; i < n; ++i) {
    const double x = normal(bits);
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

}  // namespace
}  // namespace ilss
