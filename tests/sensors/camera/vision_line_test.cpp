#include "sensors/camera/vision_line.h"

#include <gtest/gtest.h>

#include <random>

#include "framework/estimate/estimate.h"
#include "tests/sensors/camera/camera_rig.h"

namespace ilss {
namespace {

Estimate parameters(double target_height, double spacing, double focal, double point_spacing) {
  Estimate estimate(descriptor<VisionLine::Parameters>());
  estimate.value = {target_height, spacing, focal, point_spacing};
  return estimate;
}

Output rows(double y_l, double y_c, double y_r, double std) {
  Output output;
  output.estimate = Estimate(descriptor<TargetRows>(), "camera");
  output.estimate.value = {y_l, y_c, y_r};
  for (std::uint32_t i = 0; i < 3; ++i) output.estimate.lineage.add({1, i, 0}, i, std);
  return output;
}

FaultKind fault_of(const TargetRows<double>& input) {
  const auto outcome = VisionLine()(VisionLine::Parameters<double>{0.2, 0.3, 6e-3, 1}, input);
  EXPECT_TRUE(outcome.is_fault());
  return outcome.is_fault() ? outcome.fault().kind : FaultKind::internal;
}

TEST(VisionLine, ExactJacobianIsTheAutomaticOne) {
  const FunctionModule<VisionLine> module{VisionLine()};
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 2000; ++i) {
    const double depth = 0.5 + 3 * unit(random);
    const double sine = 1.8 * unit(random) - 0.9;
    const Estimate p = parameters(0.1 + unit(random), 0.3, 6e-3, 0.5 + unit(random));
    const double scale = p.value[0] * p.value[2];
    const Output input =
        rows(scale / (depth + 0.15 * sine), scale / depth, scale / (depth - 0.15 * sine), 1e-5);
    const Output* inputs[] = {&input};
    const auto automatic = module.differentiate({.parameters = p, .inputs = inputs});
    ASSERT_TRUE(automatic);
    std::array<double, 28> exact{};
    VisionLine().jacobian(
        payload_of<VisionLine::Parameters>(p), payload_of<TargetRows>(input.estimate),
        {automatic->value[0], automatic->value[1], automatic->value[2], automatic->value[3]},
        exact);
    for (std::size_t k = 0; k < exact.size(); ++k)
      ASSERT_NEAR(exact[k], automatic->jacobian[k], 1e-11 * (1 + std::abs(exact[k])))
          << "run " << i << ", entry " << k;
  }
}

TEST(VisionLine, GivesThePapersExampleWithTheRightChainRule) {
  // Henderson & Dekhil 1997, sec. 2.2: f = 1 mm, Y0 = 500 mm, D0 = 300 mm, y = 10 mm, variance
  // 1 mm² each: {0, 25, 0, 25} mm². The printed L_alpha, without 1 / D0², would give 75 for z2.
  constexpr double mm = 1e-3;
  FunctionModule<VisionLine> module{VisionLine()};
  const Output input = rows(10 * mm, 10 * mm, 10 * mm, 1 * mm);
  Output output;
  output.estimate = Estimate(descriptor<WallPoints>());
  ASSERT_TRUE(run(module, parameters(500 * mm, 300 * mm, 1 * mm, 1 * mm), &input, 1, output));
  const Eigen::MatrixXd covariance = output.estimate.lineage.covariance() / (mm * mm);
  EXPECT_NEAR(covariance(0, 0), 0, 1e-12);
  EXPECT_NEAR(covariance(1, 1), 25, 1e-9);
  EXPECT_NEAR(covariance(2, 2), 0, 1e-12);
  EXPECT_NEAR(covariance(3, 3), 25 + 50.0 / 90000, 1e-9);
  EXPECT_NEAR(covariance(1, 3), 25, 1e-9);
}

TEST(VisionLine, RecoversAnyWallFromItsRows) {
  const std::uint64_t seed = 5;
  SCOPED_TRACE("seed " + std::to_string(seed));
  RandomBits bits(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const VisionLine::Parameters<double> p{0.2, 0.3, 6e-3, 0.7};
  for (int trial = 0; trial < 1000; ++trial) {
    const double alpha = 1.2 * uniform(bits);  // positive: the wall comes nearer to the right
    const double z_c = 1.5 + uniform(bits);
    const double along_left = -0.15 + 0.1 * uniform(bits);
    const auto depth = [&](double along) { return z_c - along * std::sin(alpha); };
    const double scale = p.focal_length * p.target_height;
    const auto line = VisionLine()(p, TargetRows<double>{scale / depth(along_left), scale / z_c,
                                                         scale / depth(along_left + 0.3)});
    ASSERT_TRUE(line);
    EXPECT_NEAR(line->x1, 0, 1e-12);
    EXPECT_NEAR(line->z1, z_c, 1e-12);
    EXPECT_NEAR(line->x2, 0.7 * std::cos(alpha), 1e-11);
    EXPECT_NEAR(line->z2, z_c - 0.7 * std::sin(alpha), 1e-11);
  }
}

TEST(VisionLine, LineOnTheHorizonIsDegenerate) {
  EXPECT_EQ(fault_of({1e-3, 0, 1e-3}), FaultKind::degenerate);
}

TEST(VisionLine, LineBehindTheCameraIsOutOfRange) {
  EXPECT_EQ(fault_of({1e-3, -1e-3, 1e-3}), FaultKind::out_of_range);
}

TEST(VisionLine, DepthsMoreThanAStripeSpacingApartAreOutOfRange) {
  // z_l - z_r = 0.31 m between stripes 0.3 m apart.
  EXPECT_EQ(fault_of({1.2e-3 / 1.3, 1.2e-3 / 1.15, 1.2e-3 / 0.99}), FaultKind::out_of_range);
}

}  // namespace
}  // namespace ilss
