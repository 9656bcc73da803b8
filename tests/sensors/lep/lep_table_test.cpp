// The look-up table: depths by interpolation, its limits, and how wrong interpolation is.
#include "sensors/lep/lep_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "sensors/lep/lep_calibration_data.h"

namespace ilss {
namespace {

const LepGeometry<double> geometry;
const LepScanOrigin origin;

std::vector<LepCalibrationPoint> exact_points(std::size_t angles, std::size_t depths) {
  LepCalibrationDesign design;
  design.angles = angles;
  design.depths = depths;
  auto points = simulate_lep_calibration(design, 1);
  for (LepCalibrationPoint& point : points)
    point.image_position = model_image_position(geometry, origin, point.scan_angle, point.depth);
  return points;
}

LepTable table_of(const std::vector<LepCalibrationPoint>& points) {
  const auto table = LepTable::make(points);
  EXPECT_TRUE(table);
  return *table;
}

std::string kind_of(const Outcome<LepTableDepth>& outcome) {
  return outcome.is_fault() ? std::string(fault_name(outcome.fault().kind)) : "output";
}

TEST(LepTable, GivesBackItsOwnEntriesWhateverTheirOrder) {
  auto points = exact_points(9, 12);
  const std::uint32_t seed = 2;
  SCOPED_TRACE(seed);
  std::shuffle(points.begin(), points.end(), std::mt19937(seed));
  const LepTable table = table_of(points);
  for (const LepCalibrationPoint& point : points) {
    const auto depth = table.invert(point.scan_angle, point.image_position);
    ASSERT_TRUE(depth) << depth.fault().message;
    EXPECT_NEAR(depth->depth, point.depth, 1e-12);
  }
}

TEST(LepTable, GainIsTheModelsSlope) {
  const LepTable table = table_of(exact_points(256, 400));
  for (const double angle : {-0.2, 0.0, 0.15})
    for (const double z : {0.501, 1.203, 2.3}) {
      const auto depth = table.invert(angle, model_image_position(geometry, origin, angle, z));
      ASSERT_TRUE(depth);
      constexpr double step = 1e-6;
      const double slope = 2 * step /
                           (model_image_position(geometry, origin, angle, z + step) -
                            model_image_position(geometry, origin, angle, z - step));
      EXPECT_NEAR(depth->gain / slope, 1, 0.02) << angle << " " << z;
    }
}

TEST(LepTable, InterpolationErrorFallsWithTheSquareOfTheSpacing) {
  const LepTableError coarse =
      interpolation_error(table_of(exact_points(32, 21)), geometry, origin);
  const LepTableError fine = interpolation_error(table_of(exact_points(63, 41)), geometry, origin);
  EXPECT_EQ(coarse.cells, 31u * 20u);
  EXPECT_EQ(coarse.inverted, coarse.cells);
  EXPECT_NEAR(coarse.rms / fine.rms, 4, 0.4);
  EXPECT_GE(std::abs(coarse.largest), coarse.rms);
}

TEST(LepTable, ErrorOfAnExactTableIsThatOfInterpolation) {
  const LepTable table = table_of(exact_points(16, 20));
  EXPECT_DOUBLE_EQ(table_error(table, geometry, origin).rms,
                   interpolation_error(table, geometry, origin).rms);
}

TEST(LepTable, RefusesReadingsOutsideIt) {
  const LepTable table = table_of(exact_points(9, 12));
  EXPECT_EQ(kind_of(table.invert(0.5, 0)), "out_of_range");
  EXPECT_EQ(kind_of(table.invert(-0.5, 0)), "out_of_range");
  EXPECT_EQ(kind_of(table.invert(std::nan(""), 0)), "out_of_range");
  EXPECT_EQ(kind_of(table.invert(0, std::nan(""))), "out_of_range");
  EXPECT_EQ(kind_of(table.invert(0, model_image_position(geometry, origin, 0, 0.39))),
            "out_of_range");
  EXPECT_EQ(kind_of(table.invert(0, model_image_position(geometry, origin, 0, 2.6))),
            "out_of_range");
  EXPECT_EQ(kind_of(table.invert(0, model_image_position(geometry, origin, 0, 2.4))), "output");
}

TEST(LepTable, SaysWhereItFoldsBack) {
  auto points = exact_points(2, 12);
  std::swap(points[5].image_position, points[6].image_position);
  const LepTable table = table_of(points);
  const double between = (points[5].image_position + points[6].image_position) / 2;
  EXPECT_EQ(kind_of(table.invert(points[0].scan_angle, between)), "ambiguous");
  EXPECT_EQ(kind_of(table.invert(points[0].scan_angle, points[1].image_position)), "output");
}

TEST(LepTable, NeedsOneReadingAtEachAngleAndDepth) {
  const auto kind = [](auto spoil) {
    auto points = exact_points(3, 4);
    spoil(points);
    const auto table = LepTable::make(points);
    return table.is_fault() ? fault_name(table.fault().kind) : "table";
  };
  using Points = std::vector<LepCalibrationPoint>;
  EXPECT_EQ(kind([](Points&) {}), "table");
  EXPECT_EQ(kind([](Points& p) { p.pop_back(); }), "bad_data");
  EXPECT_EQ(kind([](Points& p) { p.push_back(p[3]); }), "bad_data");
  EXPECT_EQ(kind([](Points& p) { p.resize(4); }), "degenerate");
  EXPECT_EQ(kind([](Points& p) { p.clear(); }), "degenerate");
}

}  // namespace
}  // namespace ilss
