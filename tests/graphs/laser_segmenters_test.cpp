// The shipped study of laser segmenters: what the best one finds in rooms that it was not tuned on.
#include <gtest/gtest.h>

#include "framework/study/set_comparison.h"
#include "sensors/register.h"

namespace ilss {
namespace {

#ifdef __SANITIZE_ADDRESS__
constexpr bool is_slow = true;
#else
constexpr bool is_slow = false;
#endif

/// The study's cases on 2,000 scans of 400 rooms of a seed of this test alone; a quarter of them
/// where a sanitizer makes them slow.
const std::vector<SetCase>& cases() {
  static const std::vector<SetCase> made = [] {
    Registry registry;
    register_sensors(registry);
    Diagnostics diagnostics;
    auto study =
        read_study(ILSS_SOURCE_DIR "/graphs/laser_segmenters.study.yaml", registry, diagnostics);
    for (const Diagnostic& d : diagnostics.sorted()) ADD_FAILURE() << format_diagnostic(d);
    study->runs = is_slow ? 500 : 2000;
    study->seed = 7001;
    return compare_sets(*study);
  }();
  return made;
}

/// In the order of the study's `judge`.
enum Judged { lines, arcs, corners, edges };

constexpr std::size_t reference = 0;
constexpr std::size_t first_segmenter = 1;
constexpr std::size_t triangle_area = 7;
constexpr std::size_t best = 8;  ///< maximum_likelihood

const ElementScore& score(std::size_t study_case, std::size_t alternative, Judged what) {
  return cases().at(study_case).alternatives.at(alternative).scores.at(what);
}

TEST(LaserSegmenters, TheBestFindsTheRoomsLinesArcsAndCorners) {
  for (const std::size_t i : {0, 1}) {
    SCOPED_TRACE(cases()[i].name);
    EXPECT_GE(score(i, best, lines).true_positive(), 0.97);
    EXPECT_LE(score(i, best, lines).false_positive(), 0.01);
    EXPECT_GE(score(i, best, arcs).true_positive(), 0.9);
    EXPECT_LE(score(i, best, arcs).false_positive(), 0.02);
    EXPECT_GE(score(i, best, corners).true_positive(), 0.9);
    EXPECT_LE(score(i, best, corners).median_distance, i == 0 ? 0.004 : 0.012);
  }
}

TEST(LaserSegmenters, TheBestIsNearlyAsExactAsWithTheTrueSegments) {
  for (const std::size_t i : {0, 1})
    for (const Judged what : {lines, arcs})
      for (const double relative : score(i, best, what).relative_deviation)
        EXPECT_LE(relative, 1.1) << cases()[i].name << ", " << what;
}

TEST(LaserSegmenters, WhatTheBestFindsIsAsWrongAsItSays) {
  std::int64_t matched = 0;
  std::int64_t inside = 0;
  for (const Judged what : {lines, arcs, corners, edges}) {
    matched += score(0, best, what).matched;
    inside += score(0, best, what).inside_95;
  }
  EXPECT_GT(matched, 1000);
  EXPECT_GE(static_cast<double>(inside), 0.93 * static_cast<double>(matched));
}

TEST(LaserSegmenters, WithTheTrueSegmentsErrorsAreAsStated) {
  if (is_slow) GTEST_SKIP() << "by design: too few scans where a sanitizer makes them slow";
  for (const Judged what : {lines, arcs, corners}) {
    const ElementScore& found = score(0, reference, what);
    EXPECT_TRUE(found.nees_bounds(0.99).contains(found.mean_nees())) << what;
  }
}

// Table 1 of Núñez et al. 2009 has .77 (split and merge), .79 (fuzzy), .78 (iterative end-point
// fit), .93 (curvature scale space), .73 (Hough), .92 (CUBA) and .93 (triangle area).
TEST(LaserSegmenters, EachFindsMoreLinesThanInThePaper) {
  const std::vector<double> paper = {0.77, 0.79, 0.78, 0.93, 0.73, 0.92, 0.93};
  for (std::size_t k = 0; k < paper.size(); ++k)
    EXPECT_GT(score(0, first_segmenter + k, lines).true_positive(), paper[k]) << k;
}

TEST(LaserSegmenters, ThoseByCurvatureFindArcsWhole) {
  for (const std::size_t k : {std::size_t{4}, std::size_t{6}, triangle_area, best})
    EXPECT_GT(score(0, k, arcs).true_positive(), 0.9) << k;
}

}  // namespace
}  // namespace ilss
