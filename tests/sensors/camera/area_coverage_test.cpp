#include "sensors/camera/area_coverage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "framework/estimate/random.h"

namespace ilss {
namespace {

using Point = ImagePoint<double>;

TEST(AreaCoverage, RectangleCoversPixelsByItsShareOfThem) {
  AreaCoverage coverage(4, 5);
  // Columns 0.75 to 2.5 and rows 1 to 2.25 of the pixel grid, whose pixel 0 spans -0.5 to 0.5.
  coverage.add(std::array<Point, 4>{{{0.75, 1}, {2.5, 1}, {2.5, 2.25}, {0.75, 2.25}}}, 2);
  const std::vector<double> values = coverage.values(10);
  const auto at = [&](std::size_t row, std::size_t column) { return values[row * 5 + column]; };
  EXPECT_DOUBLE_EQ(at(0, 1), 10);
  EXPECT_DOUBLE_EQ(at(1, 1), 10 + 2 * 0.75 * 0.5);
  EXPECT_DOUBLE_EQ(at(2, 1), 10 + 2 * 0.75 * 0.75);
  EXPECT_DOUBLE_EQ(at(1, 2), 10 + 2 * 0.5);
  EXPECT_DOUBLE_EQ(at(2, 2), 10 + 2 * 0.75);
  EXPECT_DOUBLE_EQ(at(1, 3), 10);
}

TEST(AreaCoverage, TriangleCutsAPixelAlongItsDiagonal) {
  AreaCoverage coverage(2, 2);
  coverage.add(std::array<Point, 3>{{{-0.5, -0.5}, {1.5, -0.5}, {-0.5, 1.5}}}, 1);
  const std::vector<double> values = coverage.values(0);
  EXPECT_NEAR(values[0], 1, 1e-15);
  EXPECT_NEAR(values[1], 0.5, 1e-15);
  EXPECT_NEAR(values[2], 0.5, 1e-15);
  EXPECT_NEAR(values[3], 0, 1e-15);
}

TEST(AreaCoverage, SumsToThePolygonsAreaWhateverItsOrientation) {
  const std::uint64_t seed = 11;
  SCOPED_TRACE("seed " + std::to_string(seed));
  RandomBits bits(seed);
  for (int trial = 0; trial < 1000; ++trial) {
    // A star around the image's middle: its corners in order of direction.
    std::vector<Point> polygon;
    double area = 0;
    for (int i = 0; i < 7; ++i) {
      const double direction = 2 * std::numbers::pi * (i + draw_unit(bits)) / 7;
      const double radius = 1 + 6 * draw_unit(bits);
      polygon.push_back({8 + radius * std::cos(direction), 7.5 + radius * std::sin(direction)});
    }
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Point& p = polygon[i];
      const Point& q = polygon[(i + 1) % polygon.size()];
      area += 0.5 * (p.column * q.row - q.column * p.row);
    }
    if (trial % 2 == 1) std::reverse(polygon.begin(), polygon.end());
    AreaCoverage coverage(16, 17);
    coverage.add(polygon, 1);
    const std::vector<double> values = coverage.values(0);
    EXPECT_NEAR(std::accumulate(values.begin(), values.end(), 0.0), area, 1e-11);
  }
}

TEST(AreaCoverage, PartsBeyondTheImageAreCutOff) {
  AreaCoverage coverage(3, 3);
  coverage.add(std::array<Point, 4>{{{-90, -90}, {0.5, -90}, {90.5, 90}, {-90, 90}}}, 1);
  // The slanting side passes columns 45.5 + row / 2 far right of the image.
  for (const double value : coverage.values(0)) EXPECT_NEAR(value, 1, 1e-12);
  AreaCoverage beside(3, 3);
  beside.add(std::array<Point, 4>{{{5, -90}, {9, -90}, {9, 90}, {5, 90}}}, 1);
  for (const double value : beside.values(0)) EXPECT_EQ(value, 0);
}

}  // namespace
}  // namespace ilss
