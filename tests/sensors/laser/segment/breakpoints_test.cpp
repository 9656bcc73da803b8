// The adaptive breakpoint detector.
#include "sensors/laser/segment/breakpoints.h"

#include <gtest/gtest.h>

#include "tests/sensors/laser/segment/segmenter_run.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double incidence = 10 * degree;

ModuleRun clusters_of(const std::vector<LaserBeam>& beams, Breakpoints::Options options = {}) {
  Breakpoints breakpoints(options);
  const Output scan = scan_output(beams);
  return run(breakpoints, {.inputs = {&scan}});
}

/// A scan at steps of half a degree.
std::vector<LaserBeam> scan_of(const std::vector<double>& ranges, double step = 0.5 * degree) {
  std::vector<LaserBeam> beams(ranges.size());
  for (std::size_t i = 0; i < ranges.size(); ++i)
    beams[i] = {-1 + step * static_cast<double>(i), ranges[i]};
  return beams;
}

TEST(Breakpoints, BreakWhereTheStepIsLongerThanThePublishedLimit) {
  // Núñez et al. 2009, sec. 3.1, after Borges & Aldon 2004:
  // r sin(dphi) / sin(lambda - dphi) + 3 sigma.
  const double before = 2;
  const double deviation = 0.005;
  for (const double step : {0.25 * degree, 0.5 * degree, 1 * degree, 5 * degree}) {
    SCOPED_TRACE(step);
    const double limit = before * std::sin(step) / std::sin(incidence - step) + 3 * deviation;
    // The farther range at which the two points are `limit` apart: the law of cosines.
    const double along = before * std::cos(step);
    const double range = along + std::sqrt(limit * limit - before * before + along * along);
    BreakpointRule rule(incidence, 3 * deviation);
    EXPECT_FALSE(rule.breaks(before, range - 1e-9, step));
    EXPECT_TRUE(rule.breaks(before, range + 1e-9, step));
    EXPECT_TRUE(rule.breaks(before, range + 1e-9, -step)) << "either way of the sweep";
    EXPECT_FALSE(rule.breaks(before, range - 1e-9, -step));
  }
}

TEST(Breakpoints, NeverBreakAtStepsOfTheIncidenceAndMore) {
  BreakpointRule rule(incidence, 0.005);
  EXPECT_FALSE(rule.breaks(1, 100, incidence));
  EXPECT_FALSE(rule.breaks(1, 100, 2 * incidence));
  EXPECT_TRUE(rule.breaks(1, 100, 0.9 * incidence));
}

// 5 mm of noise: three standard deviations of one range are 15 mm, those of a difference 21 mm.
TEST(Breakpoints, AllowTheNoiseOfBothReadings) {
  std::vector<double> ranges(20, 2);
  const double step = 1e-4;  // so dense that a surface's own slope hardly counts
  const double slope = 2 * std::sin(step) / std::sin(10 * degree - step);
  for (std::size_t i = 10; i < ranges.size(); ++i) ranges[i] = 2 + slope + 0.018;
  const auto both = clusters_of(scan_of(ranges, step));
  ASSERT_TRUE(both.outcome);
  EXPECT_EQ(runs_of(both.output).size(), 1u);
  const auto published = clusters_of(scan_of(ranges, step), {.deviations = 3});
  EXPECT_EQ(runs_of(published.output).size(), 2u);
}

TEST(Breakpoints, EndAClusterAtABeamWithoutReturn) {
  const auto result = clusters_of(scan_of({2, 2, 2, 0, 2, 2, 2}));
  ASSERT_TRUE(result.outcome);
  EXPECT_EQ(runs_of(result.output), (std::vector<ReadingRun>{{0, 3}, {4, 7}}));
  EXPECT_EQ(segmented_beams_of(result.output)[3].segment, 0);
}

TEST(Breakpoints, LeaveIsolatedReadingsOut) {
  const auto result = clusters_of(scan_of({2, 2, 2, 5, 3, 3, 3, 4, 4}));
  ASSERT_TRUE(result.outcome);
  EXPECT_EQ(runs_of(result.output), (std::vector<ReadingRun>{{0, 3}, {4, 7}}));
  const auto all = clusters_of(scan_of({2, 2, 2, 5, 3, 3, 3, 4, 4}), {.least_readings = 1});
  EXPECT_EQ(runs_of(all.output), (std::vector<ReadingRun>{{0, 3}, {3, 4}, {4, 7}, {7, 9}}));
}

TEST(Breakpoints, AreTheSameForAScanSweptTheOtherWay) {
  const std::vector<double> ranges = {2, 2.01, 2, 2.02, 2.6, 2.6, 2.61, 0, 3, 3, 3, 1, 1, 1};
  EXPECT_EQ(runs_of(clusters_of(scan_of(ranges, 0.5 * degree)).output),
            runs_of(clusters_of(scan_of(ranges, -0.5 * degree)).output));
}

TEST(Breakpoints, KeepTheScansBeamsAndComponents) {
  const auto beams = scan_of({2, 2, 2, 0});
  const auto result = clusters_of(beams);
  ASSERT_TRUE(result.outcome);
  const auto rows = segmented_beams_of(result.output);
  ASSERT_EQ(rows.size(), beams.size());
  for (std::size_t i = 0; i < beams.size(); ++i) {
    EXPECT_EQ(rows[i].bearing, beams[i].bearing);
    EXPECT_EQ(rows[i].range, beams[i].range);
  }
  EXPECT_EQ(result.output.estimate.value, scan_output(beams).estimate.value);
}

TEST(Breakpoints, RefuseNumbersThatAreNone) {
  for (const double bad : {double{NAN}, double{INFINITY}, -1.0}) {
    const auto result = clusters_of(scan_of({2, 2, bad, 2}));
    ASSERT_EQ(fault_of(result.outcome), "bad_data");
    EXPECT_NE(result.outcome.fault().message.find("beam 2"), std::string::npos);
  }
}

TEST(Breakpoints, FindNothingInAScanOfNoneOrTwoReadings) {
  EXPECT_EQ(fault_of(clusters_of({}).outcome), "no_detection");
  EXPECT_EQ(fault_of(clusters_of(scan_of({2, 2})).outcome), "no_detection");
  EXPECT_EQ(fault_of(clusters_of(scan_of({0, 0, 0, 0})).outcome), "no_detection");
}

TEST(Breakpoints, GiveTheClustersOfNeighbourByNeighbourOnRandomScans) {
  constexpr std::uint64_t seed = 20261128;
  SCOPED_TRACE(seed);
  std::mt19937_64 draw(seed);
  std::uniform_real_distribution<double> unit;
  const Breakpoints::Options options;
  for (int scan = 0; scan < 1000; ++scan) {
    std::vector<LaserBeam> beams(static_cast<std::size_t>(1 + 80 * unit(draw)));
    double range = 2;
    double bearing = -1;
    for (LaserBeam& beam : beams) {
      if (unit(draw) < 0.1) range = 0.5 + 3 * unit(draw);
      bearing += unit(draw) < 0.02 ? 0.03 : 0.5 * degree;
      beam = {bearing, unit(draw) < 0.1 ? 0 : range + 0.01 * unit(draw)};
    }
    const LaserNoise noise = noise_of(scan_output(beams).estimate);
    BreakpointRule rule(options.incidence, options.deviations * noise.range_deviation());
    std::vector<ReadingRun> plain;
    bool is_open = false;
    for (std::size_t i = 0; i < beams.size(); ++i) {
      const bool continues = is_open && !rule.breaks(beams[i - 1].range, beams[i].range,
                                                     beams[i].bearing - beams[i - 1].bearing);
      is_open = beams[i].range > 0;
      if (is_open && continues) plain.back().end = i + 1;
      if (is_open && !continues) plain.push_back({i, i + 1});
    }
    std::erase_if(plain, [](const ReadingRun& run) { return run.size() < 3; });
    const ModuleRun clusters = clusters_of(beams);
    ASSERT_EQ(clusters.outcome.has_output(), !plain.empty()) << "scan " << scan;
    if (!plain.empty()) {
      EXPECT_EQ(runs_of(clusters.output), plain) << "scan " << scan;
    }
  }
}

}  // namespace
}  // namespace ilss
