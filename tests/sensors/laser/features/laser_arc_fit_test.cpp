// Circles through laser readings: their errors are what they are said to be.
#include "sensors/laser/features/laser_arc_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "sensors/laser/features/laser_line_fit.h"
#include "tests/sensors/laser/features/simulated_readings.h"

namespace ilss {
namespace {

/// A circle; the radius is negative where the laser sees its hollow side.
struct Circle {
  double x, y, radius;
  double operator()(double cosine, double sine) const {
    const double along = x * cosine + y * sine;
    const double across = x * sine - y * cosine;
    const double half = std::sqrt(std::max(0.0, radius * radius - across * across));
    return radius > 0 ? along - half : along + half;
  }
};

struct Scan {
  Circle circle;
  std::vector<ScanPoint> points;
};

/// A pillar of radius 0.3 to 1.5 m that is seen over 60 to `most` degrees of its circle, by at
/// least ten beams half a degree apart.
Scan random_pillar(double most, const LaserDevice& device, std::mt19937_64& draw) {
  std::uniform_real_distribution<double> unit;
  while (true) {
    const double radius = 0.3 + 1.2 * unit(draw);
    const double distance = radius + 0.3 + 4 * unit(draw);
    const double bearing = 2 * std::numbers::pi * unit(draw);
    const double seen = (60 * degree + (most - 60 * degree) * unit(draw)) / 2;
    const Circle circle{distance * std::cos(bearing), distance * std::sin(bearing), radius};
    // The laser sees the near side up to the tangents: acos(radius / distance) to either side.
    const double tangent = std::acos(radius / distance);
    if (seen > tangent) continue;
    const double half = std::atan2(radius * std::sin(seen), distance - radius * std::cos(seen));
    const double step = 0.5 * degree;
    const int count = static_cast<int>(2 * half / step) + 1;
    if (count < 10) continue;
    return {circle, simulate_readings(device, bearing - half, step, count, circle, draw)};
  }
}

/// The same of a hollow: a niche or a round room seen over 60 to 200 degrees from inside.
Scan random_hollow(const LaserDevice& device, std::mt19937_64& draw) {
  std::uniform_real_distribution<double> unit;
  const double radius = 0.5 + 2 * unit(draw);
  const double off = 0.6 * radius * unit(draw);
  const double bearing = 2 * std::numbers::pi * unit(draw);
  const Circle circle{off * std::cos(bearing), off * std::sin(bearing), -radius};
  const double step = 0.5 * degree;
  const int count = static_cast<int>((80 + 120 * unit(draw)) * degree / step);
  const double first = bearing - count * step / 2;
  return {circle, simulate_readings(device, first, step, count, circle, draw)};
}

template <typename Draw>
double mean_nees(const LaserDevice& device, const Draw& draw_scan) {
  std::mt19937_64 draw(20261122);
  double sum = 0;
  constexpr int runs = 10000;
  for (int i = 0; i < runs; ++i) {
    const Scan scan = draw_scan(device, draw);
    const auto fit = fit_laser_arc(scan.points, device.noise());
    if (!fit) return NAN;
    const Eigen::Vector3d error(fit->x - scan.circle.x, fit->y - scan.circle.y,
                                fit->radius - scan.circle.radius);
    const Eigen::Matrix3d covariance =
        fit->covariance + fit->second_order() * fit->second_order().transpose();
    sum += error.dot(covariance.inverse() * error);
  }
  return sum / runs;
}

// Honest fits give 3 on average over 10,000, within 0.06 with a probability of 99 %.
TEST(LaserArcFit, NeesOfPillarsIsThree) {
  const auto pillar = [](const LaserDevice& device, std::mt19937_64& draw) {
    return random_pillar(120 * degree, device, draw);
  };
  const double nees = mean_nees({0.005, 0.1 * degree}, pillar);
  EXPECT_GT(nees, 2.85);
  EXPECT_LT(nees, 3.15);
}

TEST(LaserArcFit, NeesOfPillarsIsThreeUpToTheirGrazedSides) {
  const auto pillar = [](const LaserDevice& device, std::mt19937_64& draw) {
    return random_pillar(165 * degree, device, draw);
  };
  const double nees = mean_nees({0.005, 0.1 * degree}, pillar);
  EXPECT_GT(nees, 2.85);
  EXPECT_LT(nees, 3.15);
}

TEST(LaserArcFit, NeesOfNoisilySeenPillarsIsThree) {
  const auto pillar = [](const LaserDevice& device, std::mt19937_64& draw) {
    return random_pillar(120 * degree, device, draw);
  };
  const double nees = mean_nees({0.02, 0.1 * degree}, pillar);
  EXPECT_GT(nees, 2.85);
  EXPECT_LT(nees, 3.15);
}

TEST(LaserArcFit, NeesOfHollowsIsThree) {
  const double nees = mean_nees({0.01, 0.1 * degree, 0.01}, random_hollow);
  EXPECT_GT(nees, 2.85);
  EXPECT_LT(nees, 3.15);
}

TEST(LaserArcFit, NeesOfHollowsWithoutBearingNoiseIsThree) {
  const double nees = mean_nees({0.01, 0}, random_hollow);
  EXPECT_GT(nees, 2.85);
  EXPECT_LT(nees, 3.15);
}

/// Readings of a bent surface, of radius 0.3 to 100 m, or of a corner: an arc, a wall or neither.
std::vector<ScanPoint> random_surface(const LaserDevice& device, std::mt19937_64& draw) {
  std::uniform_real_distribution<double> unit;
  const double radius = 0.3 * std::pow(300, unit(draw)) * (unit(draw) < 0.5 ? -1 : 1);
  const double distance = std::max(0.5, std::abs(radius) + (unit(draw) < 0.5 ? 2 : -0.4));
  const Circle circle{radius > 0 ? std::abs(radius) + 0.5 + 2 * unit(draw) : distance - 0.4, 0,
                      radius};
  const double slope = unit(draw) - 0.5;
  const bool is_corner = unit(draw) < 0.3;
  const int count = 8 + static_cast<int>(40 * unit(draw));
  return simulate_readings(
      device, -count * degree / 4, 0.5 * degree, count,
      [&](double cosine, double sine) {
        if (is_corner) return 2 / (cosine + (sine > 0 ? slope : 3 * slope) * sine);
        return circle(cosine, sine);
      },
      draw);
}

double chi_squared_of(const LaserArcFit& arc, std::span<const ScanPoint> points,
                      const LaserNoise& noise) {
  double sum = 0;
  for (const ScanPoint& p : points) sum += squared_residual(arc, p, noise);
  return sum;
}

TEST(LaserArcFit, NoCircleWithinTheLimitsFitsReadingsThatAreSaidToExceedThem) {
  constexpr std::uint64_t seed = 20261128;
  SCOPED_TRACE(seed);
  std::mt19937_64 draw(seed);
  std::uniform_real_distribution<double> unit;
  const LaserDevice device{0.005, 0, 0.01};
  int excluded = 0;
  int fitted = 0;
  constexpr int runs = 3000;
  for (int i = 0; i < runs; ++i) {
    const auto points = random_surface(device, draw);
    const ArcLimits limits{0.1, 3, (0.5 + 6 * unit(draw)) * static_cast<double>(points.size())};
    const auto fit = fit_laser_arc(points, device.noise());
    const auto is_within = [&](const LaserArcFit& arc) {
      const double radius = std::abs(arc.radius);
      return radius >= limits.least_radius && radius <= limits.largest_radius &&
             chi_squared_of(arc, points, device.noise()) <= limits.most_chi_squared;
    };
    if (!exceeds_limits(points, device.noise(), limits)) {
      if (fit && is_within(*fit)) ++fitted;
      continue;
    }
    ++excluded;
    if (!fit) continue;
    EXPECT_FALSE(is_within(*fit)) << i;
    for (int k = 0; k < 20; ++k) {
      LaserArcFit other = *fit;
      other.radius *= std::exp(unit(draw) - 0.5);
      other.x += 0.2 * (unit(draw) - 0.5);
      other.y += 0.2 * (unit(draw) - 0.5);
      EXPECT_FALSE(is_within(other)) << i;
    }
  }
  EXPECT_GT(excluded, runs / 5);
  EXPECT_GT(fitted, runs / 20);
}

TEST(LaserArcFit, NeitherLineNorArcFitsWhereBothAreSaidToExceedTheirLimits) {
  constexpr std::uint64_t seed = 20261129;
  SCOPED_TRACE(seed);
  std::mt19937_64 draw(seed);
  std::uniform_real_distribution<double> unit;
  const LaserDevice device{0.005, 0, 0.01};
  int excluded = 0;
  int fitted = 0;
  constexpr int runs = 3000;
  for (int i = 0; i < runs; ++i) {
    const auto points = random_surface(device, draw);
    const double most = (0.5 + 6 * unit(draw)) * static_cast<double>(points.size());
    const bool exceeds = exceeds_as_line_and_arc(points, device.noise(), most, {0.1, 3, most - 20});
    const auto line = fit_laser_line(points, device.noise());
    excluded += exceeds ? 1 : 0;
    fitted += line && line->chi_squared <= most ? 1 : 0;
    if (exceeds && line) {
      EXPECT_GT(line->chi_squared, most) << i;
    }
  }
  EXPECT_GT(excluded, runs / 10);
  EXPECT_GT(fitted, runs / 20);
}

TEST(LaserArcFit, OfAnOddReadingAtTheEndCountsItOnce) {
  std::mt19937_64 draw(5);
  const LaserDevice device;
  Scan scan = random_hollow(device, draw);
  if (scan.points.size() % 2 == 0) scan.points.pop_back();
  const auto fit = fit_laser_arc(scan.points, device.noise());
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->chi_squared, chi_squared_of(*fit, scan.points, device.noise()), 1e-2);
}

}  // namespace
}  // namespace ilss
