// The calibration: exact on exact data, honest on noisy ones, and it says what it cannot tell.
#include "sensors/lep/lep_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "framework/estimate/consistency.h"
#include "sensors/lep/lep_calibration_data.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;

std::array<double, 4> numbers(const LepGeometry<double>& g) {
  return {g.focal_length, g.baseline, g.vergence, g.lens_distance};
}

/// A small calibration; without noise its points still state an sd.
std::vector<LepCalibrationPoint> small_calibration(std::uint64_t seed, bool noisy = true,
                                                   const LepScanOrigin& origin = {}) {
  LepCalibrationDesign design;
  design.angles = 16;
  design.depths = 10;
  design.origin = origin;
  auto points = simulate_lep_calibration(design, seed);
  for (LepCalibrationPoint& point : points)
    if (!noisy)
      point.image_position =
          model_image_position(design.geometry, origin, point.scan_angle, point.depth);
  return points;
}

void expect_geometry(const LepGeometry<double>& found, const LepGeometry<double>& truth,
                     double tolerance) {
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(numbers(found)[i], numbers(truth)[i], tolerance) << lep_calibration_names[i];
}

TEST(LepCalibration, BothMethodsAreExactOnExactData) {
  const LepScanOrigin origin{-0.043, 0.06, 0.5 * degree, Eigen::Matrix3d::Zero()};
  const auto points = small_calibration(1, false, origin);
  const auto result = calibrate_lep(points, origin);
  ASSERT_TRUE(result) << result.fault().message;
  ASSERT_TRUE(result->linear);
  expect_geometry(result->linear->geometry, {}, 1e-9);
  expect_geometry(result->geometry, {}, 1e-9);
  EXPECT_LT(result->chi_squared, 1e-12);
}

TEST(LepCalibration, PapersUnknownsAreThoseOfEquation13) {
  const auto fit = fit_lep_linear(small_calibration(1, false), {});
  ASSERT_TRUE(fit);
  const LepGeometry<double> g;
  const double t = std::tan(g.vergence);
  const std::array<double, 6> expected = {g.baseline,
                                          g.baseline * t,
                                          g.lens_distance / std::cos(g.vergence),
                                          g.focal_length * g.baseline,
                                          g.focal_length * g.baseline * t,
                                          g.focal_length * t};
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(fit->unknowns[static_cast<Eigen::Index>(i)], expected[i], 1e-9) << "x" << i + 1;
}

// 256 angles x 40 depths of single noisy readings, 200 times.
TEST(LepCalibration, FitOfSingleReadingsIsAsWrongAsItSays) {
  const LepCalibrationDesign design;
  constexpr std::uint64_t first_seed = 1000;
  constexpr int calibrations = 200;
  ConsistencyStatistic honesty;
  double chi_squared = 0;
  for (int i = 0; i < calibrations; ++i) {
    SCOPED_TRACE(first_seed + static_cast<std::uint64_t>(i));
    const auto points =
        simulate_lep_calibration(design, first_seed + static_cast<std::uint64_t>(i));
    const auto result = calibrate_lep(points, design.origin);
    ASSERT_TRUE(result) << result.fault().message;
    Eigen::Vector4d error;
    for (std::size_t k = 0; k < 4; ++k)
      error[static_cast<Eigen::Index>(k)] =
          numbers(result->geometry)[k] - numbers(design.geometry)[k];
    honesty.add(normalized_squared_error(error, result->covariance.topLeftCorner<4, 4>()));
    chi_squared += result->chi_squared / static_cast<double>(points.size()) / calibrations;
    EXPECT_LT(std::abs(result->geometry.vergence - design.geometry.vergence), 1e-4);
  }
  EXPECT_TRUE(honesty.consistent(0.99)) << honesty.mean();
  EXPECT_GT(chi_squared, 0.99);
  EXPECT_LT(chi_squared, 1.01);
}

TEST(LepCalibration, UncertainScanOriginIsPartOfTheStatedError) {
  const LepScanOrigin truth{-0.043, 0.06, 0.5 * degree, Eigen::Matrix3d::Zero()};
  Eigen::Matrix3d covariance = Eigen::Vector3d(1e-6, 4e-6, 1e-7).asDiagonal();
  covariance(0, 2) = covariance(2, 0) = 2e-7;
  const Eigen::Matrix3d factor = covariance.llt().matrixL();
  const std::uint32_t seed = 8;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  ConsistencyStatistic honesty;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const Eigen::Vector3d error =
        factor * Eigen::Vector3d(normal(random), normal(random), normal(random));
    const LepScanOrigin believed{truth.x + error[0], truth.z + error[1],
                                 truth.projected_vergence + error[2], covariance};
    const auto result = calibrate_lep(small_calibration(i, true, truth), believed);
    ASSERT_TRUE(result) << result.fault().message;
    const auto values = result->values();
    const LepGeometry<double> g;
    const std::array<double, 7> true_values = {g.focal_length,          g.baseline, g.vergence,
                                               g.lens_distance,         truth.x,    truth.z,
                                               truth.projected_vergence};
    Eigen::VectorXd difference(7);
    for (std::size_t k = 0; k < 7; ++k)
      difference[static_cast<Eigen::Index>(k)] = values[k] - true_values[k];
    honesty.add(normalized_squared_error(difference, result->covariance));
  }
  EXPECT_DOUBLE_EQ(honesty.degrees_of_freedom(), 300 * 7);
  EXPECT_TRUE(honesty.consistent(0.99)) << honesty.mean();
}

TEST(LepCalibration, ReportsTheResidualsOfTheFit) {
  auto points = small_calibration(4);
  points[37].image_position += 3e-3;
  const auto result = calibrate_lep(points, {});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->residuals.largest_at, 37u);
  EXPECT_EQ(result->residuals.largest_in_sd_at, 37u);
  EXPECT_GT(result->residuals.largest, 1e-3);
  EXPECT_GT(result->chi_squared, 2 * result->degrees_of_freedom());
}

/// The fault's text for points of a design of so many angles and depths.
std::string fault_of_design(std::size_t angles, std::size_t depths) {
  std::vector<LepCalibrationPoint> points;
  for (std::size_t a = 0; a < angles; ++a)
    for (std::size_t d = 0; d < depths; ++d) {
      const double angle = angles == 1 ? 0 : -0.3 + 0.05 * static_cast<double>(a);
      const double depth = depths == 1 ? 0.8 : 0.5 + 0.15 * static_cast<double>(d);
      points.push_back({angle, depth, model_image_position({}, {}, angle, depth), 1e-6});
    }
  const auto result = calibrate_lep(points, {});
  if (!result.is_fault()) return "no fault";
  return std::string(fault_name(result.fault().kind)) + ": " + result.fault().message;
}

TEST(LepCalibration, OneScanAngleLeavesOneCombinationOpenAndItIsNamed) {
  const std::string fault = fault_of_design(1, 12);
  EXPECT_NE(fault.find("degenerate: the data leave 1 of 4 parameters undetermined"),
            std::string::npos)
      << fault;
  EXPECT_NE(fault.find("vergence"), std::string::npos) << fault;
}

TEST(LepCalibration, OneScanAngleAtOneDepthLeavesThreeOpen) {
  LepCalibrationPoint point{0.1, 0.8, model_image_position({}, {}, 0.1, 0.8), 1e-6};
  const std::vector<LepCalibrationPoint> points(20, point);
  const auto result = calibrate_lep(points, {});
  ASSERT_TRUE(result.is_fault());
  EXPECT_NE(result.fault().message.find("leave 3 of 4"), std::string::npos)
      << result.fault().message;
}

TEST(LepCalibration, OpenCombinationReallyHardlyShows) {
  // At one scan angle z = f d / ... has three parameters; the named change must leave p as it is.
  const std::string fault = fault_of_design(1, 12);
  std::array<double, 4> change = {};
  for (std::size_t i = 0; i < 4; ++i) {
    const std::string name(lep_calibration_names[i]);
    if (const auto at = fault.find(name + " "); at != std::string::npos)
      change[i] = std::stod(fault.substr(at + name.size() + 1)) * (i == 2 ? degree : 1e-3);
  }
  LepGeometry<double> g;
  const double before = model_image_position(g, {}, 0, 0.6);
  // A small part of it, for the model is not linear.
  constexpr double part = 0.01;
  g = {g.focal_length + part * change[0], g.baseline + part * change[1],
       g.vergence + part * change[2], g.lens_distance + part * change[3]};
  const double moved = std::abs(model_image_position(g, {}, 0, 0.6) - before);
  const double alone = std::abs(
      model_image_position({0.05, 0.086, 7.07 * degree + part * change[2], 0.06}, {}, 0, 0.6) -
      before);
  EXPECT_GT(alone, 0);
  EXPECT_LT(moved, 0.05 * alone) << fault;  // the message has two digits
}

TEST(LepCalibration, RefusesBadPoints) {
  const auto kind = [](auto spoil) {
    auto points = small_calibration(1);
    spoil(points);
    const auto result = calibrate_lep(points, {});
    return result.is_fault() ? fault_name(result.fault().kind) : "calibrated";
  };
  using Points = std::vector<LepCalibrationPoint>;
  EXPECT_EQ(kind([](Points&) {}), "calibrated");
  EXPECT_EQ(kind([](Points& p) { p.resize(5); }), "degenerate");
  EXPECT_EQ(kind([](Points& p) { p[3].deviation = 0; }), "bad_data");
  EXPECT_EQ(kind([](Points& p) { p[3].image_position = std::nan(""); }), "bad_data");
  EXPECT_EQ(kind([](Points& p) { p[3].depth = -0.1; }), "bad_data");
  EXPECT_EQ(kind([](Points& p) { p[3].scan_angle = 1.7; }), "bad_data");
  EXPECT_EQ(kind([](Points& p) { p[3].scan_angle = INFINITY; }), "bad_data");
}

}  // namespace
}  // namespace ilss
