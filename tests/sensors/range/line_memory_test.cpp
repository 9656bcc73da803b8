// Lines over several scans: the mean, its restart and what is forgotten; and readings tick by tick.
#include "sensors/range/line_memory.h"

#include <gtest/gtest.h>

#include "tests/sensors/features/feature_run.h"
#include "tests/sensors/range/scans.h"

namespace ilss {
namespace {

double rho_std(const ModuleRun& result) {
  const auto lines = elements_of<LineSegment>(result.output);
  return lines.empty() ? 0 : lines[0]->lineage.standard_deviation(0);
}

TEST(LineMemory, IsTheMeanOverScansAndStartsAnewAfterItsNumber) {
  std::mt19937_64 random(211);
  const Surface wall = on_line(polar_line(1.5, 1.5));
  LineExtractor remembering({.memory = 4});
  LineExtractor forgetful({});
  std::vector<double> single;
  for (int tick = 0; tick < 9; ++tick) {
    const Output scan = scan_output(ScanOf{}.on(wall, random));
    const double alone = rho_std(extract(forgetful, scan, tick));
    const double mean = rho_std(extract(remembering, scan, tick));
    EXPECT_NEAR(mean / alone, 1 / std::sqrt(tick % 4 + 1), 0.02) << "tick " << tick;
  }
}

TEST(LineMemory, MeanOfScansIsTheFitToAllTheirReadings) {
  std::mt19937_64 random(212);
  const Surface wall = on_line(polar_line(1.5, 1.5));
  LineExtractor remembering({.memory = 3});
  ScanLines all{ScanLinesRule{}};
  std::vector<RangeReading> readings;
  ModuleRun last;
  for (int tick = 0; tick < 3; ++tick) {
    const auto scan = ScanOf{}.on(wall, random);
    readings.insert(readings.end(), scan.begin(), scan.end());
    last = extract(remembering, scan_output(scan), tick);
  }
  const ReadingRun run{0, readings.size()};
  const auto fit =
      fit_line(readings, {&run, 1}, sums_of(readings).of(0, readings.size()).line(), 0);
  ASSERT_TRUE(fit);
  const auto lines = elements_of<LineSegment>(last.output);
  ASSERT_EQ(lines.size(), 1u);
  const auto expected = rho_phi(fit->line);
  EXPECT_NEAR(lines[0]->value[0], expected[0], 1e-6);
  EXPECT_NEAR(lines[0]->value[1], expected[1], 1e-6);
  EXPECT_EQ(lines[0]->value[6], 384);
}

TEST(LineMemory, ForgetsWhatAScanDoesNotSee) {
  std::mt19937_64 random(213);
  const Surface wall = on_line(polar_line(1.5, 1.5));
  const Surface other = on_line(polar_line(1.0, 1.7));
  LineExtractor remembering({.memory = 100});
  const auto scan = [&](const Surface& s) { return scan_output(ScanOf{}.on(s, random)); };
  const double alone = rho_std(extract(remembering, scan(wall), 0));
  EXPECT_LT(rho_std(extract(remembering, scan(wall), 1)), 0.75 * alone);
  EXPECT_LT(rho_std(extract(remembering, scan(other), 2)), alone);
  EXPECT_NEAR(rho_std(extract(remembering, scan(wall), 3)) / alone, 1, 0.05);
}

TEST(LineMemory, DoesNotJoinAnotherLineAndForgetsAllOnReset) {
  std::mt19937_64 random(214);
  LineExtractor remembering({.memory = 100});
  const auto scan = [&](double rho) {
    return scan_output(ScanOf{}.on(on_line(polar_line(rho, 1.5)), random));
  };
  const double alone = rho_std(extract(remembering, scan(1.5), 0));
  const ModuleRun moved = extract(remembering, scan(1.45), 1);
  EXPECT_NEAR(elements_of<LineSegment>(moved.output)[0]->value[0], 1.45, 0.02);
  EXPECT_GT(rho_std(moved), 0.85 * alone);
  remembering.reset();
  EXPECT_NEAR(rho_std(extract(remembering, scan(1.45), 2)) / rho_std(moved), 1, 0.05);
}

/// Readings given one a tick to a continuous extractor, and what it says of them.
struct TickByTick {
  int ended = 0;
  int open = 0;
  int pending = 0;
  std::vector<Estimate> segments;  ///< that ended

  explicit TickByTick(const std::vector<RangeReading>& readings) {
    LineExtractor extractor({.continuous = true});
    for (std::size_t i = 0; i < readings.size(); ++i) {
      const ModuleRun result =
          extract(extractor, scan_output({readings[i]}), static_cast<std::int64_t>(i));
      if (result.outcome.is_pending()) {
        ++pending;
        continue;
      }
      EXPECT_TRUE(result.outcome) << "tick " << i;
      int open_now = 0;
      for (const Estimate& element : result.output.elements) {
        EXPECT_EQ(element.type->name, LineSegment<double>::name);
        if (element.labels[0] == 1) {
          ++open;
          ++open_now;
          continue;
        }
        ++ended;
        segments.push_back(element);
      }
      EXPECT_LE(open_now, 1);
    }
  }
};

TEST(LineExtractorContinuous, EmitsEachSegmentOnceWhenItEnds) {
  std::mt19937_64 random(215);
  const Surface near = on_line(polar_line(1, 1.6));
  const Surface behind = on_line(polar_line(1.5, 1.6));
  std::vector<RangeReading> readings;
  for (int sweep = 0; sweep < 3; ++sweep) {
    const auto scan = ScanOf{}.on(
        [&](std::size_t i) -> const Surface& { return i < 64 ? near : behind; }, random);
    readings.insert(readings.end(), scan.begin(), scan.end());
  }
  const TickByTick result(readings);
  ASSERT_EQ(result.ended, 5) << "of three sweeps of two; the last is open";
  EXPECT_LT(result.pending, 3 * 2 * 5 + 1) << "at the start of each segment";
  EXPECT_GT(result.open, 340);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(result.segments[i].value[0], i % 2 == 0 ? 1 : 1.5, 0.02);
    EXPECT_GE(result.segments[i].value[6], 61);
    EXPECT_LE(result.segments[i].value[6], 67);
  }
}

TEST(LineExtractorContinuous, AgreesWithWholeScansWhileTheHeadTurns) {
  const Scene scene = edge_scene(1, 120 * degree);
  for (const double rate : {0.0, 90 * degree, -90 * degree}) {
    LepRig rig(scene);
    rig.head_rate = rate;
    const Output scan = rig.scan(8);
    const auto readings = readings_of(scan);
    const TickByTick single({readings.begin(), readings.end()});
    ASSERT_EQ(single.ended, 1) << rate;
    LineExtractor whole_extractor({});
    const ModuleRun whole = extract(whole_extractor, scan);
    const auto lines = elements_of<LineSegment>(whole.output);
    ASSERT_EQ(lines.size(), 2u);
    for (const std::size_t i : {0, 1})
      EXPECT_NEAR(single.segments[0].value[i], lines[0]->value[i],
                  2 * lines[0]->lineage.standard_deviation(i));
  }
}

TEST(LineExtractorContinuous, ANewSweepIsSeenWhileTheHeadTurns) {
  const Scene scene = edge_scene(1.2, 120 * degree);
  LepRig rig(scene);
  LepSensor sensor(rig.options);
  ASSERT_TRUE(sensor.command({"rotate_at", 60 * degree}));
  LineExtractor extractor({.continuous = true});
  int ended = 0;
  for (std::int64_t tick = 0; tick < 3; ++tick) {
    Output images;
    ASSERT_TRUE(rig.take(sensor, tick, 9, images));
    const ModuleRun result = extract(extractor, rig.ranges(images), tick);
    ASSERT_TRUE(result.outcome);
    for (const Estimate& element : result.output.elements) ended += element.labels[0] == 0 ? 1 : 0;
  }
  EXPECT_EQ(ended, 5) << "two a sweep; the last is open";
}

}  // namespace
}  // namespace ilss
