// LepRay against the paper's equations as printed, and against a construction by rays.
#include "sensors/lep/lep_geometry.h"

#include <gtest/gtest.h>

#include <numbers>

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;

/// Calls `visit(theta, z)` over the sensor's whole field: +-20 deg, 0.4 m to 2.5 m.
template <typename Visit>
void for_the_whole_field(Visit visit) {
  for (double theta = -20 * degree; theta <= 20.01 * degree; theta += 0.5 * degree)
    for (double z = 0.4; z <= 2.5001; z += 0.025) visit(theta, z);
}

/// Equations 6 to 9 of Pears 1997 as printed: z from image position.
double printed_depth(const LepGeometry<double>& g, double theta, double p) {
  const double f = g.focal_length;
  const double d = g.baseline;
  const double gamma = g.vergence;
  const std::array<double, 3> a = {f * d / p * std::pow(std::cos(theta), 2),
                                   d / 2 * std::sin(2 * theta), -g.lens_distance * std::cos(theta)};
  const std::array<double, 3> big_gamma = {1 + (std::tan(theta) - p / f) * std::tan(gamma), 1,
                                           1 / std::cos(gamma)};
  const double q = 1 + f / p * std::tan(gamma);
  return (a[0] * big_gamma[0] + a[1] * big_gamma[1] + a[2] * big_gamma[2]) / q;
}

/// Equation 10 as printed: image position from z.
double printed_position(const LepGeometry<double>& g, double theta, double z) {
  const double f = g.focal_length;
  const double d = g.baseline;
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  const double t = std::tan(g.vergence);
  return f * (z * t - d * c * c * (1 + std::tan(theta) * t)) /
         (d * c * (s - c * t) - g.lens_distance * c / std::cos(g.vergence) - z);
}

/// The image of (x, z) = z (tan theta, 1) through a pinhole that stands behind (d, 0) by s along an
/// optical axis at angle theta - gamma from z towards x, on a plane at f behind it.
double constructed_position(const LepGeometry<double>& g, double theta, double z) {
  const double axis = theta - g.vergence;
  const double lens_x = g.baseline - g.lens_distance * std::sin(axis);
  const double lens_z = -g.lens_distance * std::cos(axis);
  const double dx = z * std::tan(theta) - lens_x;
  const double dz = z - lens_z;
  const double along = dx * std::sin(axis) + dz * std::cos(axis);
  const double to_the_right = dx * std::cos(axis) - dz * std::sin(axis);
  return -g.focal_length * to_the_right / along;
}

TEST(LepGeometry, ImagePositionIsEquation10) {
  const LepGeometry<double> g;
  for_the_whole_field([&](double theta, double z) {
    EXPECT_NEAR(LepRay<double>(g, theta).image_position(std::cos(theta) / z),
                printed_position(g, theta, z), 1e-12 * g.focal_length)
        << theta / degree << " deg, " << z << " m";
  });
}

TEST(LepGeometry, RangeIsEquation6) {
  const LepGeometry<double> g;
  for_the_whole_field([&](double theta, double z) {
    const double p = printed_position(g, theta, z);
    ASSERT_NE(p, 0);  // where the printed form has no value
    const double range = 1 / LepRay<double>(g, theta).inverse_range(p);
    EXPECT_NEAR(range * std::cos(theta) / printed_depth(g, theta, p), 1, 1e-12)
        << theta / degree << " deg, " << z << " m";
  });
}

TEST(LepGeometry, Equations6And10InvertEachOtherOverTheWholeField) {
  const LepGeometry<double> g;
  for_the_whole_field([&](double theta, double z) {
    const LepRay<double> ray(g, theta);
    const double u = std::cos(theta) / z;
    EXPECT_NEAR(ray.inverse_range(ray.image_position(u)) / u, 1, 1e-12);
    EXPECT_NEAR(printed_depth(g, theta, printed_position(g, theta, z)) / z, 1, 1e-12)
        << theta / degree << " deg, " << z << " m";
  });
}

TEST(LepGeometry, HoldsWhereTheImagePassesTheDetectorsMiddle) {
  const LepGeometry<double> g;
  int passed = 0;
  for (double theta = -20 * degree; theta <= 20.01 * degree; theta += degree) {
    const LepRay<double> ray(g, theta);
    const double u = ray.inverse_range(0);
    const double z = std::cos(theta) / u;
    passed += z > 0.4 && z < 2.5;
    EXPECT_NEAR(constructed_position(g, theta, z), 0, 1e-15);
    for (const double p : {-1e-15, 1e-15}) EXPECT_NEAR(ray.inverse_range(p) / u, 1, 1e-12);
  }
  EXPECT_EQ(passed, 41);
}

TEST(LepGeometry, AgreesWithAConstructionByRays) {
  for (const LepGeometry<double>& g :
       {LepGeometry<double>{}, LepGeometry<double>{0.035, 0.12, -3 * degree, 0.02},
        LepGeometry<double>{0.05, -0.086, -7.07 * degree, 0.06}})
    for_the_whole_field([&](double theta, double z) {
      EXPECT_NEAR(LepRay<double>(g, theta).image_position(std::cos(theta) / z),
                  constructed_position(g, theta, z), 1e-12 * g.focal_length)
          << theta / degree << " deg, " << z << " m";
    });
}

}  // namespace
}  // namespace ilss
