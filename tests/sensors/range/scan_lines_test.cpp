// From readings to segments: pieces joined, corners, jumps, arcs, and nothing lost.
#include "sensors/range/scan_lines.h"

#include <gtest/gtest.h>

#include "tests/sensors/range/scans.h"

namespace ilss {
namespace {

double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

struct Found {
  std::vector<FittedSegment> segments;

  explicit Found(const std::vector<RangeReading>& readings, double beam_width = 0,
                 const ScanLinesRule& rule = {}) {
    ScanLines lines(rule);
    lines.begin(0, beam_width);
    for (const RangeReading& r : readings) lines.add(r);
    lines.finish();
    segments.assign(lines.segments().begin(), lines.segments().end());
  }
};

using Selector = std::function<const Surface&(std::size_t)>;

TEST(ScanLines, JoinsThreePiecesOfOneLineAcrossWhatStandsBefore) {
  constexpr unsigned seed = 111;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  const Surface wall = on_line(polar_line(1.5, 1.5));
  const Surface post = on_line(polar_line(1.0, 1.6));
  for (int run = 0; run < 200; ++run) {
    // Two posts of 3 readings, 3 cm wide: too few for segments.
    const auto readings = ScanOf{}.on(
        [&](std::size_t i) -> const Surface& {
          return (i >= 40 && i < 43) || (i >= 90 && i < 93) ? post : wall;
        },
        random);
    const Found found(readings);
    ASSERT_EQ(found.segments.size(), 1u) << "run " << run;
    EXPECT_EQ(found.segments[0].runs.size(), 3u) << "run " << run;
    EXPECT_EQ(found.segments[0].first, 0u);
    EXPECT_EQ(found.segments[0].last, 127u);
    EXPECT_GE(found.segments[0].fit.readings, 118u);
    EXPECT_LE(found.segments[0].fit.readings, 122u);
  }
}

TEST(ScanLines, JoinsAcrossMissingReadingsNoWiderThanTheGapAllows) {
  std::mt19937_64 random(112);
  auto readings = ScanOf{}.on(on_line(polar_line(1.5, 1.5)), random);
  // Readings of 1.5 m and 0.315 degrees are 8.2 mm apart: 20 missing ones are 17 cm.
  readings.erase(readings.begin() + 50, readings.begin() + 70);
  EXPECT_EQ(Found(readings).segments.size(), 1u);
  EXPECT_EQ(Found(readings, 0, {.max_gap = 0.1}).segments.size(), 2u);
}

TEST(ScanLines, DoesNotJoinTheTwoSidesOfADoorway) {
  std::mt19937_64 random(113);
  const Surface wall = on_line(polar_line(1.5, 1.57));
  const Surface behind = on_line(polar_line(2.5, 1.57));
  for (int run = 0; run < 200; ++run) {
    ScanOf scan;
    scan.deviation = 0.005;
    const Found found(
        scan.on([&](std::size_t i) -> const Surface& { return i >= 45 && i < 85 ? behind : wall; },
                random));
    ASSERT_EQ(found.segments.size(), 3u) << "run " << run;
    EXPECT_NEAR(1 / found.segments[1].fit.line.z, 2.5, 0.1);
  }
}

TEST(ScanLines, EveryReadingOfALongPieceIsInASegmentOrBesideAnEdge) {
  constexpr unsigned seed = 114;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  for (int run = 0; run < 300; ++run) {
    const Surface a = on_line(polar_line(uniform(random, 0.7, 1.2), uniform(random, 1.3, 1.8)));
    const Surface b = on_line(polar_line(uniform(random, 1.6, 2.4), uniform(random, 1.3, 1.8)));
    const auto at = static_cast<std::size_t>(uniform(random, 20, 108));
    ScanOf scan;
    scan.deviation = 0.005;
    const Found found(
        scan.on(Selector([&](std::size_t i) -> const Surface& { return i < at ? a : b; }), random));
    ASSERT_EQ(found.segments.size(), 2u) << "run " << run;
    EXPECT_LE(found.segments[0].first, 1u);
    EXPECT_GE(found.segments[1].last, 126u);
    EXPECT_NEAR(static_cast<double>(found.segments[0].last), static_cast<double>(at) - 1, 2);
    EXPECT_NEAR(static_cast<double>(found.segments[1].first), static_cast<double>(at), 2);
  }
}

TEST(ScanLines, EndsTwoLinesWhereTheyMeet) {
  constexpr unsigned seed = 115;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  const Surface left = on_line(polar_line(1, 1.85));
  const Surface right = on_line(polar_line(1, 1.3));
  ScanOf scan;
  scan.origin_x = scan.origin_z = 0;
  int elsewhere = 0;
  for (int run = 0; run < 300; ++run) {
    const auto readings = scan.on(
        [&](std::size_t i) -> const Surface& {
          RangeReading r;
          r.bearing = scan.from + (scan.to - scan.from) * static_cast<double>(i) / 127;
          return left(r) > right(r) ? left : right;  // the nearer one: a concave corner hides none
        },
        random);
    const Found found(readings);
    ASSERT_EQ(found.segments.size(), 2u) << "run " << run;
    const double corner = (1.85 + 1.3) / 2;
    const bool here = found.segments[1].meets_before &&
                      found.segments[0].last + 1 == found.segments[1].first &&
                      std::abs(readings[found.segments[1].first].bearing - corner) < 0.025;
    elsewhere += here ? 0 : 1;
  }
  // Where noise follows the other line for some readings, or is an outlier there.
  EXPECT_LE(elsewhere, 6);
}

// Also for a beam of no width, which has no mixed readings to leave out.
TEST(ScanLines, AJumpIsNoCorner) {
  std::mt19937_64 random(120);
  const Surface near = on_line(polar_line(1, 1.57));
  const Surface behind = on_line(polar_line(2, 1.6));
  for (const double beam_width : {0.0, 0.003}) {
    const Found found(
        ScanOf{}.on([&](std::size_t i) -> const Surface& { return i < 64 ? near : behind; },
                    random),
        beam_width);
    ASSERT_EQ(found.segments.size(), 2u);
    EXPECT_FALSE(found.segments[1].meets_before);
  }
}

TEST(ScanLines, LinesDoNotMeetAcrossAGap) {
  std::mt19937_64 random(121);
  const Surface left = on_line(polar_line(1, 1.85));
  const Surface right = on_line(polar_line(1, 1.3));
  ScanOf scan;
  scan.origin_x = scan.origin_z = 0;
  auto readings =
      scan.on([&](std::size_t i) -> const Surface& { return i < 64 ? left : right; }, random);
  readings.erase(readings.begin() + 40, readings.begin() + 88);
  const Found found(readings);
  ASSERT_EQ(found.segments.size(), 2u);
  EXPECT_FALSE(found.segments[1].meets_before);
  EXPECT_EQ(found.segments[0].last, 39u);
  EXPECT_EQ(found.segments[1].first, 40u);
}

TEST(ScanLines, LeavesOutWhatTheBeamMayMixAtAJump) {
  std::mt19937_64 random(116);
  const Surface near = on_line(polar_line(1, 1.57));
  const Surface behind = on_line(polar_line(2, 1.57));
  ScanOf scan;
  scan.deviation = 0.003;
  const auto readings =
      scan.on([&](std::size_t i) -> const Surface& { return i < 64 ? near : behind; }, random);
  // A step of 5.5 mrad; 12 mm at 1 m are 12 mrad and so up to 3 readings.
  const Found found(readings, 0.012);
  ASSERT_EQ(found.segments.size(), 2u);
  EXPECT_EQ(found.segments[0].mixed_after, 3u);
  EXPECT_EQ(found.segments[1].mixed_before, 3u);
  EXPECT_EQ(found.segments[0].last, 60u);
  EXPECT_EQ(found.segments[1].first, 67u);
}

TEST(ScanLines, FindsAnArcWhereNoTwoLinesExplainTheReadings) {
  constexpr unsigned seed = 117;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  const Surface pillar = on_circle(0, 1, 0.25);
  ScanOf scan;
  scan.from = (90 + 12) * std::numbers::pi / 180;
  scan.to = (90 - 12) * std::numbers::pi / 180;
  scan.origin_x = scan.origin_z = 0;
  scan.deviation = 0.003;
  for (int run = 0; run < 100; ++run) {
    const auto readings = scan.on(pillar, random);
    const Found found(readings);
    ASSERT_EQ(found.segments.size(), 1u) << "run " << run;
    ASSERT_TRUE(found.segments[0].arc) << "run " << run;
    EXPECT_NEAR(found.segments[0].arc->circle[2], 0.25, 0.03);
    ScanLinesRule no_arcs;
    no_arcs.arc.largest_radius = 0;
    for (const FittedSegment& s : Found(readings, 0, no_arcs).segments) EXPECT_FALSE(s.arc);
  }
}

TEST(ScanLines, GivesTheSameAfterAnotherScan) {
  std::mt19937_64 random(118);
  const Surface a = on_line(polar_line(1, 1.5));
  const Surface b = on_line(polar_line(1.5, 1.5));
  const auto first =
      ScanOf{}.on([&](std::size_t i) -> const Surface& { return i % 40 < 20 ? a : b; }, random);
  const auto second = ScanOf{}.on(a, random);
  ScanLines lines{ScanLinesRule{}};
  for (const auto* scan : {&second, &first, &second}) {
    lines.begin(0, 0.003);
    for (const RangeReading& r : *scan) lines.add(r);
    lines.finish();
  }
  const Found fresh(second, 0.003);
  ASSERT_EQ(lines.segments().size(), fresh.segments.size());
  EXPECT_EQ(lines.segments()[0].fit.line.x, fresh.segments[0].fit.line.x);
  EXPECT_EQ(lines.segments()[0].runs, fresh.segments[0].runs);
}

TEST(ScanLines, FindsNothingInNothing) {
  EXPECT_TRUE(Found({}).segments.empty());
  std::mt19937_64 random(119);
  auto readings = ScanOf{}.on(on_line(polar_line(1, 1.5)), random);
  readings.resize(4);
  EXPECT_TRUE(Found(readings).segments.empty());
}

}  // namespace
}  // namespace ilss
