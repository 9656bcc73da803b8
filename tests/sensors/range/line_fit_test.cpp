// Fits of lines and circles: values, and errors by noise and by what a scan's readings share.
#include "sensors/range/line_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "framework/estimate/consistency.h"
#include "sensors/range/arc_fit.h"
#include "tests/sensors/lep_rig.h"
#include "tests/sensors/range/scans.h"

namespace ilss {
namespace {

double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

std::optional<LineFit> fit(std::span<const RangeReading> readings, double noise_correlation = 0) {
  const ReadingRun all{0, readings.size()};
  return fit_line(readings, {&all, 1}, sums_of(readings).of(0, readings.size()).line(),
                  noise_correlation);
}

Eigen::Vector2d vector(const InverseLine& m) { return {m.x, m.z}; }

/// Weighted normal equations of the exact model, iterated to the end.
Eigen::Vector2d converged(std::span<const RangeReading> readings, Eigen::Vector2d m) {
  for (int step = 0; step < 20; ++step) {
    Eigen::Matrix2d a = Eigen::Matrix2d::Zero();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    for (const RangeReading& r : readings) {
      const Eigen::Vector2d o(r.origin_x, r.origin_z);
      const Eigen::Vector2d e(std::cos(r.bearing), std::sin(r.bearing));
      const double d = 1 - m.dot(o);
      const Eigen::Vector2d j = e / d + m.dot(e) / (d * d) * o;
      a += j * j.transpose() / (r.deviation * r.deviation);
      b += j * (r.inverse_range - m.dot(e) / d) / (r.deviation * r.deviation);
    }
    m += a.llt().solve(b);
  }
  return m;
}

std::vector<RangeReading> random_line_scan(std::mt19937_64& random, double deviation) {
  ScanOf scan;
  scan.readings = 60;
  scan.deviation = deviation;
  auto readings =
      scan.on(on_line(polar_line(uniform(random, 0.6, 2), uniform(random, 1, 2))), random);
  for (RangeReading& r : readings)
    for (double& s : r.sensitivity) s = uniform(random, -1, 1);
  return readings;
}

TEST(FitLine, IsExactWithoutNoise) {
  std::mt19937_64 random(91);
  for (int run = 0; run < 100; ++run) {
    const InverseLine truth = polar_line(uniform(random, 0.5, 2), uniform(random, 1, 2));
    ScanOf scan;
    const Surface surface = on_line(truth);
    auto readings = scan.on(surface, random);
    for (RangeReading& r : readings) r.inverse_range = surface(r);
    const auto fitted = fit(readings);
    ASSERT_TRUE(fitted);
    EXPECT_NEAR(fitted->line.x, truth.x, 1e-10);
    EXPECT_NEAR(fitted->line.z, truth.z, 1e-10);
    EXPECT_NEAR(fitted->chi_squared, 0, 1e-10);
  }
}

TEST(FitLine, OneStepFromTheLinearFormIsTheMaximumLikelihood) {
  constexpr unsigned seed = 92;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  for (int run = 0; run < 200; ++run) {
    const auto readings = random_line_scan(random, 0.02);
    const auto fitted = fit(readings);
    ASSERT_TRUE(fitted);
    const Eigen::Vector2d difference =
        vector(fitted->line) - converged(readings, vector(fitted->line));
    const double in_sd = std::sqrt(difference.dot(fitted->covariance.llt().solve(difference)));
    EXPECT_LT(in_sd, 1e-3) << "run " << run;
  }
}

TEST(FitLine, IsAsWrongAsItSays) {
  constexpr unsigned seed = 93;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  double sum = 0;
  double chi_squared = 0;
  constexpr int runs = 3000;
  for (int run = 0; run < runs; ++run) {
    const InverseLine truth = polar_line(uniform(random, 0.6, 2), uniform(random, 1, 2));
    const auto fitted = fit(ScanOf{}.on(on_line(truth), random));
    ASSERT_TRUE(fitted);
    const Eigen::Vector2d error = vector(fitted->line) - vector(truth);
    sum += error.dot(fitted->covariance.llt().solve(error));
    chi_squared += fitted->chi_squared;
  }
  EXPECT_TRUE(chi_square_interval(2 * runs, 0.99).contains(sum)) << sum / runs / 2;
  EXPECT_TRUE(chi_square_interval(126.0 * runs, 0.99).contains(chi_squared))
      << chi_squared / runs / 126;
}

TEST(FitLine, NeighboursThatErrTogetherSayLess) {
  std::mt19937_64 random(94);
  const auto readings = random_line_scan(random, 0.01);
  const Eigen::Matrix2d ratio =
      fit(readings, 0.2)->covariance * fit(readings)->covariance.inverse();
  EXPECT_NEAR((ratio - 1.5 * Eigen::Matrix2d::Identity()).norm(), 0, 1e-9);
}

/// The same readings with one of the scan's mount_x, mount_z, mount_heading and errors changed:
/// seen from the frame for the mount, and in the inverse range for what is systematic.
std::vector<RangeReading> changed(std::vector<RangeReading> readings, int dependence, double by) {
  for (RangeReading& r : readings) {
    const double c = std::cos(r.head);
    const double s = std::sin(r.head);
    if (dependence == 0) {
      r.origin_x += by * c;
      r.origin_z += by * s;
    } else if (dependence == 1) {
      r.origin_x -= by * s;
      r.origin_z += by * c;
    } else if (dependence == 2) {
      r.bearing += by;
    } else {
      r.inverse_range += by * r.sensitivity[static_cast<std::size_t>(dependence - 3)];
    }
  }
  return readings;
}

TEST(FitLine, DependsOnTheScanAsRefitsOfChangedScansDo) {
  constexpr unsigned seed = 95;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  for (int run = 0; run < 50; ++run) {
    auto readings = random_line_scan(random, 0.001);
    for (std::size_t i = 0; i < readings.size(); ++i)
      readings[i].head = 0.3 + 0.01 * static_cast<double>(i);
    const auto fitted = fit(readings);
    for (int k = 0; k < scan_dependences; ++k) {
      constexpr double by = 1e-5;
      const auto more = fit(changed(readings, k, by));
      const auto less = fit(changed(readings, k, -by));
      const Eigen::Vector2d difference = (vector(more->line) - vector(less->line)) / (2 * by);
      // The fit takes its dependence at the noisy readings: as near as the noise is small.
      EXPECT_NEAR((difference - fitted->by_scan.col(k)).norm(), 0, 0.01) << "dependence " << k;
    }
  }
}

TEST(FitLine, NeedsTwoReadingsInDifferentDirections) {
  std::mt19937_64 random(96);
  auto readings = random_line_scan(random, 0.01);
  readings.resize(1);
  EXPECT_FALSE(fit(readings));
  readings.assign(9, readings[0]);
  EXPECT_FALSE(fit(readings));
  EXPECT_FALSE(fit({}));
}

struct Circle {
  double x, z, radius;
};

std::vector<RangeReading> circle_scan(std::mt19937_64& random, const Circle& c, double deviation,
                                      double share = 0.9) {
  ScanOf scan;
  scan.readings = 80;
  scan.deviation = deviation;
  scan.origin_x = 0.03;
  const double middle = std::atan2(c.z - 0.05, c.x - 0.03);
  const double half = std::asin(share * std::abs(c.radius) / std::hypot(c.x - 0.03, c.z - 0.05));
  scan.from = middle + half;
  scan.to = middle - half;
  auto readings = scan.on(on_circle(c.x, c.z, c.radius), random);
  for (RangeReading& r : readings)
    for (double& s : r.sensitivity) s = uniform(random, -1, 1);
  return readings;
}

TEST(FitArc, FindsCentreAndRadiusOfBulgesAndHollows) {
  std::mt19937_64 random(97);
  for (const Circle& c : {Circle{0, 1, 0.1}, Circle{0.2, 1.2, 0.3}, Circle{0, 1, -0.5}}) {
    const auto readings = circle_scan(random, c, 1e-6);
    const auto fitted = fit_arc(readings, {}, 0);
    ASSERT_TRUE(fitted);
    EXPECT_NEAR(fitted->circle[0], c.x, 1e-5);
    EXPECT_NEAR(fitted->circle[1], c.z, 1e-5);
    EXPECT_NEAR(fitted->circle[2], c.radius, 1e-5);
    EXPECT_EQ(fitted->readings, readings.size());
  }
}

TEST(FitArc, IsAsWrongAsItSays) {
  constexpr unsigned seed = 98;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  double sum = 0;
  constexpr int runs = 500;
  const Circle c{0, 1, 0.1};
  for (int run = 0; run < runs; ++run) {
    const auto fitted = fit_arc(circle_scan(random, c, 0.003), {}, 0);
    ASSERT_TRUE(fitted);
    const Eigen::Vector3d error = fitted->circle - Eigen::Vector3d(c.x, c.z, c.radius);
    sum += error.dot(fitted->covariance.llt().solve(error));
  }
  EXPECT_TRUE(chi_square_interval(3 * runs, 0.99).contains(sum)) << sum / runs / 3;
}

TEST(FitArc, DependsOnTheScanAsRefitsOfChangedScansDo) {
  std::mt19937_64 random(99);
  for (int run = 0; run < 10; ++run) {
    auto readings = circle_scan(random, {0.1, 1, 0.15}, 1e-5);
    for (std::size_t i = 0; i < readings.size(); ++i)
      readings[i].head = 0.3 + 0.01 * static_cast<double>(i);
    const auto fitted = fit_arc(readings, {}, 0);
    ASSERT_TRUE(fitted);
    for (int k = 0; k < scan_dependences; ++k) {
      constexpr double by = 1e-4;
      const auto more = fit_arc(changed(readings, k, by), {}, 0);
      const auto less = fit_arc(changed(readings, k, -by), {}, 0);
      ASSERT_TRUE(more && less);
      const Eigen::Vector3d difference = (more->circle - less->circle) / (2 * by);
      EXPECT_NEAR((difference - fitted->by_scan.col(k)).norm(), 0, 0.01 * (1 + difference.norm()))
          << "dependence " << k;
    }
  }
}

TEST(FitArc, RefusesALineAndARadiusOutOfBounds) {
  std::mt19937_64 random(100);
  ScanOf flat;
  flat.deviation = 1e-5;
  EXPECT_FALSE(fit_arc(flat.on(on_line(polar_line(1, 1.5)), random), {}, 0));
  const auto readings = circle_scan(random, {0, 1, 0.1}, 1e-4);
  EXPECT_FALSE(fit_arc(readings, {.least_radius = 0.12}, 0));
  EXPECT_FALSE(fit_arc(readings, {.largest_radius = 0.08}, 0));
  EXPECT_FALSE(fit_arc(std::span(readings).first(3), {}, 0));
}

TEST(ArcResidual, IsInfiniteWhereTheRayGrazes) {
  RangeReading r{.bearing = std::numbers::pi / 2, .inverse_range = 1, .deviation = 0.1};
  EXPECT_NEAR(arc_residual(r, {0, 1.5, 0.5}), 0, 1e-12);
  EXPECT_NEAR(arc_residual(r, {0, 1.75, 0.5}), (1 - 0.8) / 0.1, 1e-12);
  EXPECT_FALSE(std::isfinite(arc_residual(r, {0.476, 1.5, 0.5})));
  EXPECT_TRUE(std::isfinite(arc_residual(r, {0.474, 1.5, 0.5})));
}

// Ranges with an sd of 5 % of the distance, as most sensors' are: normal in range.
TEST(LineFit, OfNoiseInRangeHasNoBiasAndIsAsWrongAsItSays) {
  constexpr std::uint64_t seed = 271;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  constexpr double distance = 2;
  constexpr double sd = 0.1;
  const auto honesty_of = [&](bool in_range) {
    double sum = 0;
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise;
    constexpr int runs = 1000;
    for (int run = 0; run < runs; ++run) {
      std::vector<RangeReading> readings;
      for (int i = 0; i < 360; ++i) {
        const double bearing = (60 + i / 6.0) * degree;
        const double range = distance / std::sin(bearing) + sd * noise(random);
        RangeReading reading;
        reading.bearing = bearing;
        reading.inverse_range = 1 / range;
        reading.deviation = sd / (range * range);
        readings.push_back(reading);
      }
      const ReadingRun all{0, readings.size()};
      const auto fitted = fit_line(readings, {&all, 1},
                                   sums_of(readings).of(0, readings.size()).line(), {0, in_range});
      sum += nees(*fitted, {0, 1 / distance}) / 2;
    }
    return sum / runs;
  };
  EXPECT_NEAR(honesty_of(true), 1, 0.1);
  EXPECT_GT(honesty_of(false), 2) << "weights of measured ranges prefer what came out too far";
}

}  // namespace
}  // namespace ilss
