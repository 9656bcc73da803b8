// Lines through laser readings: their errors are what they are said to be.
#include "sensors/laser/features/laser_line_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "framework/estimate/angle.h"
#include "tests/sensors/laser/features/simulated_readings.h"

namespace ilss {
namespace {

struct Line {
  double rho;
  double alpha;
  double operator()(double cosine, double sine) const {
    return rho / (std::cos(alpha) * cosine + std::sin(alpha) * sine);
  }
};

Eigen::Vector2d error_of(const LaserLineFit& fit, const Line& truth) {
  return {fit.rho - truth.rho, wrap_angle(fit.alpha - truth.alpha)};
}

/// A wall drawn at random whose middle is seen `least` to `most` off its normal, to either side.
struct RandomWall {
  Line line;
  double first;
  double step;
  int count;

  RandomWall(double least, double most, std::mt19937_64& draw) {
    std::uniform_real_distribution<double> unit;
    line = {1 + 5 * unit(draw), wrap_angle(2 * std::numbers::pi * unit(draw))};
    const double off = (least + (most - least) * unit(draw)) * (unit(draw) < 0.5 ? -1 : 1);
    step = 0.5 * degree;
    count = 10 + static_cast<int>(50 * unit(draw));
    // No beam meets the wall at less than 8 degrees.
    const double half = std::min(step * (count - 1) / 2, 82 * degree - std::abs(off));
    count = static_cast<int>(2 * half / step) + 1;
    first = line.alpha + off - half;
  }
};

/// The mean of what 10,000 random walls' fits are off, squared and over their covariances; fits of
/// honest covariance give 2 on average, within 0.05 with a probability of 99 %.
double mean_nees(double least, double most, const LaserDevice& device) {
  std::mt19937_64 draw(20261122);
  double sum = 0;
  constexpr int runs = 10000;
  for (int i = 0; i < runs; ++i) {
    const RandomWall wall(least, most, draw);
    const auto points =
        simulate_readings(device, wall.first, wall.step, wall.count, wall.line, draw);
    const auto fit = fit_laser_line(points, device.noise());
    if (!fit) return NAN;
    const Eigen::Vector2d error = error_of(*fit, wall.line);
    Eigen::Matrix2d covariance = fit->covariance;
    covariance(0, 0) += fit->second_order_variance();
    sum += error.dot(covariance.inverse() * error);
  }
  return sum / runs;
}

struct Device {
  const char* name;
  LaserDevice device;
};

class LaserLineNees : public testing::TestWithParam<Device> {};

TEST_P(LaserLineNees, IsTwoForWallsSeenCentred) {
  const double nees = mean_nees(0, 5 * degree, GetParam().device);
  EXPECT_GT(nees, 1.9);
  EXPECT_LT(nees, 2.1);
}

TEST_P(LaserLineNees, IsTwoForWallsSeen20To60DegreesOffCentre) {
  const double nees = mean_nees(20 * degree, 60 * degree, GetParam().device);
  EXPECT_GT(nees, 1.9);
  EXPECT_LT(nees, 2.1);
}

TEST_P(LaserLineNees, IsTwoForWallsSeen50To75DegreesOffCentre) {
  const double nees = mean_nees(50 * degree, 75 * degree, GetParam().device);
  EXPECT_GT(nees, 1.9);
  EXPECT_LT(nees, 2.1);
}

INSTANTIATE_TEST_SUITE_P(Devices, LaserLineNees,
                         testing::Values(Device{"Protocol", {0.005, 0.1 * degree}},
                                         Device{"Noisy", {0.02, 0.1 * degree}},
                                         Device{"NoBearingNoise", {0.01, 0}},
                                         Device{"Quantised", {0.008, 0.05 * degree, 0.01}}),
                         [](const auto& device) { return device.param.name; });

}  // namespace
}  // namespace ilss
