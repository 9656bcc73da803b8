// Moments of runs of points: what a bounded question about a circle tells.
#include "sensors/laser/segment/curve_moments.h"

#include <gtest/gtest.h>

#include "tests/sensors/laser/segment/cluster_points.h"

namespace ilss {
namespace {

TEST(CurveMoments, OfACircleThatIsGoodEnoughAreThoseAskedWithoutABound) {
  constexpr std::uint64_t seed = 20261128;
  SCOPED_TRACE(seed);
  std::mt19937_64 draw(seed);
  std::uniform_real_distribution<double> unit;
  const LaserNoise noise{0.005 * 0.005, 0};
  int bounded = 0;
  int whole = 0;
  for (const auto& beams : {corner_beams(), pillar_beams(0.5, 2, 120)}) {
    const auto points = points_of(beams, 0.005, seed);
    CurveMomentSums sums;
    sums.set(points, noise);
    for (int i = 0; i < 2000; ++i) {
      const auto begin = static_cast<std::size_t>(unit(draw) * 100);
      const auto end = begin + 6 + static_cast<std::size_t>(unit(draw) * 14);
      const CurveMoments moments = sums.of(begin, end);
      const double enough = 40 * unit(draw);
      const CircleCost all = moments.circle();
      const CircleCost some = moments.circle(enough);
      EXPECT_LE(some.chi_squared, all.chi_squared);
      if (all.chi_squared <= enough) {
        ++whole;
        EXPECT_EQ(some.chi_squared, all.chi_squared);
        EXPECT_EQ(some.radius, all.radius);
      } else {
        ++bounded;
        EXPECT_GT(some.chi_squared, enough);
      }
    }
  }
  EXPECT_GT(whole, 100);
  EXPECT_GT(bounded, 100);
}

}  // namespace
}  // namespace ilss
