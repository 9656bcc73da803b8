#include "sensors/camera/lens_distortion.h"

#include <gtest/gtest.h>

#include <array>
#include <opencv2/calib3d.hpp>
#include <string>

#include "framework/estimate/random.h"

namespace ilss {
namespace {

Image<double> distorting_camera() {
  Image<double> camera{};
  camera.pixel_pitch = 40e-6;
  camera.principal_row = 60;
  camera.principal_column = 66;
  camera.focal_length = 6e-3;
  camera.k1 = -0.28;
  camera.k2 = 0.07;
  camera.p1 = 1e-3;
  camera.p2 = -2e-3;
  camera.k3 = 0.004;
  return camera;
}
const cv::Matx33d opencv_matrix(150, 0, 66, 0, 150, 60, 0, 0, 1);
const std::vector<double> opencv_coefficients = {-0.28, 0.07, 1e-3, -2e-3, 0.004};

std::vector<ImagePoint<double>> random_pixels(std::uint64_t seed) {
  RandomBits bits(seed);
  const auto uniform = [](RandomBits& random) { return draw_uniform(random, 0, 127); };
  std::vector<ImagePoint<double>> result;
  for (int i = 0; i < 500; ++i) result.push_back({uniform(bits), uniform(bits)});
  return result;
}

TEST(LensDistortion, DistortsAsOpenCvProjects) {
  SCOPED_TRACE("seed 3");
  for (const ImagePoint<double>& ideal : random_pixels(3)) {
    const std::vector<cv::Point3d> point = {{(ideal.column - 66) / 150, (ideal.row - 60) / 150, 1}};
    std::vector<cv::Point2d> projected;
    cv::projectPoints(point, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), opencv_matrix,
                      opencv_coefficients, projected);
    const ImagePoint<double> shown = distort_pixel(distorting_camera(), ideal);
    EXPECT_NEAR(shown.column, projected[0].x, 1e-9);
    EXPECT_NEAR(shown.row, projected[0].y, 1e-9);
  }
}

TEST(LensDistortion, UndistortsAsOpenCvDoes) {
  SCOPED_TRACE("seed 4");
  for (const ImagePoint<double>& shown : random_pixels(4)) {
    const std::vector<cv::Point2d> point = {{shown.column, shown.row}};
    std::vector<cv::Point2d> undistorted;
    cv::undistortPoints(
        point, undistorted, opencv_matrix, opencv_coefficients, cv::noArray(), opencv_matrix,
        cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 200, 1e-12));
    const auto ideal = undistort_pixel(distorting_camera(), shown);
    ASSERT_TRUE(ideal);
    EXPECT_NEAR(ideal->column, undistorted[0].x, 1e-6);
    EXPECT_NEAR(ideal->row, undistorted[0].y, 1e-6);
  }
}

TEST(LensDistortion, UndistortInvertsDistort) {
  SCOPED_TRACE("seed 5");
  const Image<double> camera = distorting_camera();
  for (const ImagePoint<double>& ideal : random_pixels(5)) {
    const auto back = undistort_pixel(camera, distort_pixel(camera, ideal));
    ASSERT_TRUE(back);
    EXPECT_NEAR(back->column, ideal.column, 1e-8);
    EXPECT_NEAR(back->row, ideal.row, 1e-8);
  }
}

TEST(LensDistortion, DerivativesOfTheInverseAreThoseOfDifferences) {
  constexpr std::size_t n = dimension_of<Image>;
  using D = Dual<n>;
  const Image<double> camera = distorting_camera();
  const ImagePoint<double> shown{20, 110};
  Image<D> variable{};
  seed_variables<n>(components(camera), 0, components(variable));
  const auto ideal = undistort_pixel(variable, ImagePoint<D>{D(shown.column), D(shown.row)});
  ASSERT_TRUE(ideal);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    Image<double> more = camera;
    Image<double> less = camera;
    const double step = 1e-5 * (1e-3 + std::abs(components(camera)[i]));
    components(more)[i] += step;
    components(less)[i] -= step;
    const double numeric =
        (undistort_pixel(more, shown)->row - undistort_pixel(less, shown)->row) / (2 * step);
    const double exact = ideal->row.v[static_cast<Eigen::Index>(i)];
    EXPECT_NEAR(exact, numeric, 1e-4 * (1 + std::abs(numeric))) << Image<double>::fields[i].name;
  }
}

TEST(LensDistortion, BeyondTheFoldNothingIsShown) {
  Image<double> camera = distorting_camera();
  camera.k1 = -0.3;
  camera.k2 = camera.p1 = camera.p2 = camera.k3 = 0;
  // x (1 - 0.3 x²) has its greatest value, 0.703, at x = 1.054.
  EXPECT_FALSE(undistort_pixel(camera, ImagePoint<double>{66 + 0.71 * 150, 60}));
}

}  // namespace
}  // namespace ilss
