// What is particular to the segmenters by curvature: supports, areas, scales.
#include <gtest/gtest.h>

#include "sensors/laser/segment/cuba.h"
#include "sensors/laser/segment/curvature_scale_space.h"
#include "sensors/laser/segment/triangle_area.h"
#include "tests/sensors/laser/segment/cluster_points.h"

namespace ilss {
namespace {

constexpr LaserNoise usual_noise{0.005 * 0.005, 1.7e-3 * 1.7e-3};

/// The area between a polyline and its chord, from the shoelace formula about the first point.
double polygon_area(const std::vector<ScanPoint>& points, std::size_t from, std::size_t to) {
  double sum = 0;
  for (std::size_t j = from + 1; j < to; ++j) {
    const double ax = points[j].x - points[from].x;
    const double ay = points[j].y - points[from].y;
    const double bx = points[j + 1].x - points[from].x;
    const double by = points[j + 1].y - points[from].y;
    sum += (ax * by - ay * bx) / 2;
  }
  return sum;
}

TEST(TriangleArea, SumsAreasInConstantTimeAsDirectlySummed) {
  const auto points = points_of(corner_beams(), 0.02, 3);
  TriangleArea algorithm({});
  algorithm.update(points, usual_noise);
  for (std::size_t from = 0; from < points.size(); from += 7)
    for (std::size_t to = from + 1; to < points.size(); to += 5)
      EXPECT_NEAR(algorithm.area(from, to), polygon_area(points, from, to), 1e-12);
}

TEST(TriangleArea, OppositeBumpsCancelUnlessAreasAreAbsolute) {
  // A wave about the line x = 2: as much before it as behind.
  const auto points = points_of(beams_to(-0.2, 0.2, 81, [](double bearing) {
    return (2 + 0.05 * std::sin(bearing * std::numbers::pi / 0.2)) / std::cos(bearing);
  }));
  TriangleArea algorithm({});
  algorithm.update(points, usual_noise);
  EXPECT_NEAR(algorithm.area(0, 80), 0, 1e-3);
  // Each half wave of 0.4 m has the mean height 2/pi of 5 cm.
  EXPECT_NEAR(algorithm.absolute_area(0, 80), 2 * 0.4 * 0.05 * 2 / std::numbers::pi, 1e-3);
}

TEST(TriangleArea, AbsoluteAreasFindCornersToo) {
  const auto points = points_of(corner_beams(), 0.005, 5);
  TriangleArea algorithm({.absolute = true});
  std::vector<ReadingRun> runs;
  algorithm.segment(points, usual_noise, runs);
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_NEAR(static_cast<double>(runs[1].begin), corner_reading, 2);
}

/// The end of a reading's support by trying: the last reading up to which the contour has no
/// corner.
std::size_t support_by_trying(const Cuba& cuba, const std::vector<ScanPoint>& points, std::size_t i,
                              const SupportRule& rule) {
  std::size_t end = std::min(i + static_cast<std::size_t>(rule.least_readings), points.size() - 1);
  const auto reaches = [&](std::size_t to) {
    const double chord = std::hypot(points[to].x - points[i].x, points[to].y - points[i].y);
    return chord <= rule.longest && cuba.supports(i, to);
  };
  while (end + 1 < points.size() && reaches(end + 1)) ++end;
  return end;
}

TEST(Cuba, SupportsReachAsFarAsTrialsOneByOne) {
  for (const auto& beams : {corner_beams(), pillar_beams(0.4, 2, 60), pillar_beams(1.5, 4, 120)}) {
    const auto points = points_of(beams);
    const Cuba::Options options;
    Cuba cuba(options);
    std::vector<ReadingRun> runs;
    cuba.segment(points, {}, runs);
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_EQ(cuba.regions().forward()[i], support_by_trying(cuba, points, i, options.support))
          << "reading " << i << " of " << points.size();
  }
}

TEST(Cuba, SupportsOfAMirroredScanAreMirrored) {
  const auto points = points_of(corner_beams());
  auto mirrored = points;
  std::reverse(mirrored.begin(), mirrored.end());
  Cuba cuba({});
  Cuba mirror({});
  std::vector<ReadingRun> runs;
  cuba.segment(points, {}, runs);
  mirror.segment(mirrored, {}, runs);
  // The contour is measured in steps from its first reading on, so an end may differ by one.
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_NEAR(
        static_cast<double>(cuba.regions().forward()[i]),
        static_cast<double>(points.size() - 1 - mirror.regions().backward()[points.size() - 1 - i]),
        1);
}

TEST(RegionsOfSupport, AskFewQuestionsAReadingHoweverLongTheyAre) {
  const auto points = points_of(
      beams_to(-1, 1, 20000, [](double bearing) { return range_to_line(bearing, 2, 0); }));
  std::size_t questions = 0;
  RegionsOfSupport regions({.most_readings = 100000});
  regions.update(points, [&](std::size_t, std::size_t) {
    ++questions;
    return true;
  });
  EXPECT_GT(regions.forward()[10000] - 10000, 4000U) << "a metre of it";
  EXPECT_LT(questions, 6 * points.size());
}

TEST(RegionsOfSupport, EndAtTheLongestAndAtTheMostReadings) {
  const auto points = points_of(
      beams_to(-0.5, 0.5, 1001, [](double bearing) { return range_to_line(bearing, 2, 0); }));
  const auto always = [](std::size_t, std::size_t) { return true; };
  RegionsOfSupport few({.most_readings = 20});
  few.update(points, always);
  EXPECT_EQ(few.forward()[500], 520U);
  EXPECT_EQ(few.backward()[500], 480U);
  RegionsOfSupport near({.longest = 0.1});
  near.update(points, always);
  EXPECT_NEAR(points[near.forward()[500]].y, 0.1, 0.003);
}

TEST(ContourLength, IsThatOfTheSurfaceInSpiteOfNoise) {
  // 400 readings on 3.1 m, 8 mm apart; noise of 2 cm makes the polyline several times as long.
  const auto points = points_of(
      beams_to(-0.66, 0.66, 400, [](double bearing) { return range_to_line(bearing, 2, 0); }), 0.02,
      7);
  ContourLength length(4);
  length.update(points, {0.02 * 0.02, 0});
  const double surface = 4 * std::tan(0.66);
  EXPECT_GT(length.lengths().back(), surface - 0.05);
  EXPECT_LT(length.lengths().back(), 1.2 * surface);
  EXPECT_NEAR(length.lengths().back() - length.excess().back(), surface, 0.1 * surface);
}

TEST(SmoothedContour, CurvesAsACircleDoes) {
  for (const double radius : {0.4, 1.0, 3.0})
    for (const double scale : {0.05, 0.1}) {
      SCOPED_TRACE(testing::Message() << "radius " << radius << ", scale " << scale);
      SmoothedContour contour(0.02);
      contour.update(points_of(pillar_beams(radius, 5, 400)), {});
      contour.set_scale(scale);
      // Smoothing shrinks a circle by exp(-scale² / (2 radius²)).
      const double curvature = std::exp(scale * scale / (2 * radius * radius)) / radius;
      EXPECT_NEAR(contour.curvature(contour.size() / 2), -curvature, 0.02 * curvature)
          << "bulging towards the laser";
    }
}

TEST(SmoothedContour, IsStraightOnAWallToItsEnds) {
  SmoothedContour contour(0.025);
  contour.update(points_of(beams_to(0.3, 1.2, 200,
                                    [](double bearing) { return range_to_line(bearing, 2, 0); })),
                 {});
  contour.set_scale(0.15);
  for (std::size_t k = 0; k < contour.size(); ++k) EXPECT_NEAR(contour.curvature(k), 0, 0.02);
}

TEST(SmoothedContour, KnowsTheNoiseOfItsCurvature) {
  const double range_std = 0.01;
  double square = 0;
  double stated = 0;
  constexpr std::uint64_t scans = 300;
  SmoothedContour contour(0.02);
  for (std::uint64_t seed = 1; seed <= scans; ++seed) {
    contour.update(points_of(beams_to(-0.4, 0.4, 60,
                                      [](double bearing) { return range_to_line(bearing, 2, 0); }),
                             range_std, seed),
                   {range_std * range_std, 0});
    contour.set_scale(0.12);
    const double curvature = contour.curvature(contour.size() / 2);
    square += curvature * curvature / scans;
    stated += contour.curvature_deviation(contour.size() / 2) / scans;
  }
  EXPECT_NEAR(std::sqrt(square) / stated, 1, 0.3);
}

TEST(CurvatureScaleSpace, PlacesAtAFineScaleWhatItFindsAtACoarseOne) {
  // Two corners of 40 degrees, 60 cm apart: at the coarse scale they hardly part.
  const auto beams = beams_to(-0.7, 0.7, 280, [](double bearing) {
    double range = range_to_line(bearing, 2, 0);
    for (const double side : {-0.7, 0.7}) {
      const double shift = 2 * std::cos(side) + 0.3 * std::sin(0.7);
      range = std::min(range, range_to_line(bearing, shift, side));
    }
    return range;
  });
  const auto points = points_of(beams, 0.005, 9);
  for (const double coarse : {0.1, 0.15, 0.2}) {
    SCOPED_TRACE(coarse);
    CurvatureScaleSpace algorithm({.coarse = coarse});
    std::vector<ReadingRun> runs;
    algorithm.segment(points, usual_noise, runs);
    ASSERT_EQ(runs.size(), 3U);
    EXPECT_NEAR(points[runs[1].begin].y, -0.3, 0.03);
    EXPECT_NEAR(points[runs[2].begin].y, 0.3, 0.03);
  }
}

}  // namespace
}  // namespace ilss
