// One wall out of a set of segments.
#include "sensors/features/wall_from_segments.h"

#include <gtest/gtest.h>

#include "tests/sensors/features/feature_run.h"

namespace ilss {
namespace {

Estimate segment(double start_x, double start_z, double end_x, double end_z, std::uint32_t owner) {
  Estimate element(descriptor<LineSegment>(), "lep");
  element.value = {1, 1, start_x, start_z, end_x, end_z, 20, 0, 19};
  element.labels = {0};
  const std::vector<double> column = {9, 8, 1, 2, 3, 4, 0, 0, 0};
  element.lineage.add({owner, 0, 3}, column);
  return element;
}

Output three_walls() {
  Output features;
  features.estimate = Estimate(descriptor<RangeFeatures>(), "lep");
  features.elements = {segment(-1, 1, -0.2, 1, 11), segment(-0.1, 2, 0.2, 2, 12),
                       segment(0.3, 1, 2, 1, 13)};
  Estimate edge(descriptor<Corner>(), "lep");
  features.elements.push_back(edge);
  return features;
}

ModuleRun wall(std::optional<double> bearing, const Output& features) {
  WallFromSegments::Options options;
  options.bearing = bearing;
  WallFromSegments module(options);
  Tick tick;
  tick.inputs = {&features};
  ModuleRun result;
  result.output.estimate = Estimate(descriptor<WallPoints>(), "lep");
  result.outcome = module.evaluate(tick.evaluation(), result.output);
  return result;
}

TEST(WallFromSegments, IsTheLongestWithoutABearing) {
  const ModuleRun result = wall({}, three_walls());
  ASSERT_TRUE(result.outcome);
  EXPECT_EQ(result.output.estimate.value, (std::vector<double>{0.3, 1, 2, 1}));
}

TEST(WallFromSegments, IsTheOneAtTheBearing) {
  EXPECT_EQ(wall(90 * degree, three_walls()).output.estimate.value,
            (std::vector<double>{-0.1, 2, 0.2, 2}));
  EXPECT_EQ(wall(120 * degree, three_walls()).output.estimate.value,
            (std::vector<double>{-1, 1, -0.2, 1}));
  EXPECT_EQ(fault_of(wall(-90 * degree, three_walls()).outcome), "no_detection") << "behind";
  EXPECT_EQ(fault_of(wall(0.0, three_walls()).outcome), "no_detection");
}

TEST(WallFromSegments, PassesItsEndsErrorsWithTheirSources) {
  const ModuleRun result = wall(90 * degree, three_walls());
  const Lineage& lineage = result.output.estimate.lineage;
  ASSERT_EQ(lineage.size(), 1u);
  EXPECT_EQ(lineage.sources()[0], (Source{12, 0, 3}));
  const auto column = lineage.column(0);
  EXPECT_EQ(std::vector<double>(column.begin(), column.end()), (std::vector<double>{1, 2, 3, 4}));
}

TEST(WallFromSegments, DetectsNothingWithoutASegment) {
  Output features;
  features.estimate = Estimate(descriptor<RangeFeatures>(), "lep");
  EXPECT_EQ(fault_of(wall({}, features).outcome), "no_detection");
  features.elements.push_back(Estimate(descriptor<Corner>(), "lep"));
  EXPECT_EQ(fault_of(wall({}, features).outcome), "no_detection") << "an edge is no wall";
}

}  // namespace
}  // namespace ilss
