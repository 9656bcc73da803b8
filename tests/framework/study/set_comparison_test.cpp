// Studies of sets: scores by hand, and of errors whose law is known.
#include "framework/study/set_comparison.h"

#include "tests/framework/graph/read_graph.h"
#include "tests/framework/study/set_modules.h"

namespace ilss {
namespace {

using test::Folder;
using test::messages;

struct ReadStudy {
  std::optional<Study> study;
  std::string errors;
};

ReadStudy read(const std::string& text) {
  const Folder folder;
  folder.write("study.yaml", text);
  Diagnostics diagnostics;
  ReadStudy result;
  result.study = read_study(folder.path() / "study.yaml", test::set_registry(), diagnostics);
  result.errors = messages(diagnostics);
  const std::string prefix = folder.path().string() + "/";
  for (std::size_t at = 0; (at = result.errors.find(prefix)) != std::string::npos;)
    result.errors.erase(at, prefix.size());
  return result;
}

/// A study of one case whose sides are single modules named `m`, given by their keys.
std::string study_text(const std::string& truth, const std::string& alternative,
                       const std::string& more = "") {
  const auto side = [](const std::string& keys) {
    return "{graph: {modules: {m: {type: set_reading, " + keys + "}}, network: m}}\n";
  };
  return "study: s\npayload: findings\nruns: 1\ntruth: " + side(truth) +
         "alternatives: {a: " + side(alternative) + "}\ncases: [{name: one}]\n" + more;
}

const std::string judge = "judge: {piece: [position, slope], spot: {components: [x, z]}}\n";

SetAlternative compared(const std::string& text) {
  ReadStudy result = read(text);
  EXPECT_EQ(result.errors, "");
  return compare_sets(result.study.value()).at(0).alternatives.at(0);
}

TEST(SetComparison, CountsWhatIsFoundMissedAndFalse) {
  const SetAlternative alternative =
      compared(study_text("pieces: [{first: 0, last: 9}, {first: 10, last: 19}, "
                          "{first: 30, last: 49}, {first: 60, last: 69}]",
                          "pieces: [{first: 0, last: 8}, {first: 11, last: 18}, "
                          "{first: 30, last: 39}, {first: 40, last: 49}, {first: 80, last: 89}]",
                          judge));
  const ElementScore& pieces = alternative.scores[0];
  EXPECT_EQ(pieces.truth, 4);
  EXPECT_EQ(pieces.found, 5);
  EXPECT_EQ(pieces.matched, 2);  // overlaps of 0.9 and 0.8; halves are no match
  EXPECT_DOUBLE_EQ(pieces.true_positive(), 0.5);
  EXPECT_DOUBLE_EQ(pieces.false_positive(), 0.6);
  EXPECT_EQ(alternative.scores[1].truth, 0);
  EXPECT_EQ(alternative.scores[1].true_positive(), 0);
}

TEST(SetComparison, WhatIsToleratedIsNeitherTrueNorFalse) {
  const SetAlternative alternative = compared(
      study_text("pieces: [{first: 0, last: 9}]",
                 "pieces: [{first: 0, last: 9}, {first: 20, last: 23}, "
                 "{first: 40, last: 49}]",
                 judge + "tolerated: {graph: {modules: {m: {type: set_reading, pieces: "
                         "[{first: 20, last: 24}, {first: 0, last: 9}]}}, network: m}}\n"));
  EXPECT_EQ(alternative.scores[0].matched, 1);
  EXPECT_EQ(alternative.scores[0].tolerated, 1);
  EXPECT_DOUBLE_EQ(alternative.scores[0].false_positive(), 1.0 / 3);
}

TEST(SetComparison, ErrorsAreThoseOfTheJudgedComponentsOnTheCircle) {
  const SetAlternative alternative = compared(
      study_text("pieces: [{position: 1 m, slope: 179 deg, last: 9}, {position: 2 m, first: 20, "
                 "last: 29}]",
                 "pieces: [{position: 1.1 m, slope: -179 deg, last: 9}, {position: 2.3 m, first: "
                 "20, last: 29}]",
                 judge));
  const std::vector<MatchedErrors>& errors = alternative.scores[0].errors;
  ASSERT_EQ(errors.size(), 2u);
  EXPECT_NEAR(errors[0].bias, 0.2, 1e-12);
  EXPECT_NEAR(errors[0].median, 0.2, 1e-12);
  EXPECT_NEAR(errors[0].standard_deviation, std::sqrt(0.02), 1e-12);
  EXPECT_NEAR(errors[1].bias, std::numbers::pi / 180, 1e-12);
}

TEST(SetComparison, MedianDistanceIsOfPlaces) {
  const SetAlternative alternative = compared(
      study_text("spots: [{x: 0 m}, {x: 1 m}, {x: 2 m}]",
                 "spots: [{x: 0.03 m, z: 0.04 m}, {x: 1 m, z: 1 mm}, {x: 2.02 m}]", judge));
  EXPECT_EQ(alternative.scores[1].matched, 3);
  EXPECT_NEAR(alternative.scores[1].median_distance, 0.02, 1e-12);
}

const std::string ten_spots =
    "spots: [{x: 1 m}, {x: 2 m}, {x: 3 m}, {x: 4 m}, {x: 5 m}, {x: 6 m}, {x: 7 m}, {x: 8 m}, "
    "{x: 9 m}, {x: 10 m}]";

TEST(SetComparison, HonestErrorsHaveANeesOfTheirDimensionAndCoverIt) {
  ReadStudy many = read(study_text(ten_spots, ten_spots + ", scatter: 2 mm, std: 2 mm",
                                   judge + "validation_gate: 2.7726\nseed: 4\n"));
  many.study->runs = 400;
  const ElementScore score = compare_sets(*many.study)[0].alternatives[0].scores[1];
  EXPECT_EQ(score.matched, 4000);
  EXPECT_TRUE(score.nees_bounds(0.999).contains(score.mean_nees()));
  EXPECT_NEAR(score.mean_nees(), 2, 0.15);
  EXPECT_NEAR(score.inside_95_share(), 0.95, 4 * std::sqrt(0.95 * 0.05 / 4000));
  EXPECT_NEAR(score.inside_gate_share(), 0.75, 4 * std::sqrt(0.75 * 0.25 / 4000));
  EXPECT_NEAR(score.errors[0].standard_deviation, 0.002, 0.0001);
}

TEST(SetComparison, ErrorsOfTwiceTheStatedSizeHaveFourTimesTheNees) {
  ReadStudy study =
      read(study_text(ten_spots, ten_spots + ", scatter: 4 mm, std: 2 mm", judge + "seed: 4\n"));
  study.study->runs = 400;
  const ElementScore score = compare_sets(*study.study)[0].alternatives[0].scores[1];
  EXPECT_NEAR(score.mean_nees(), 8, 0.6);
  EXPECT_FALSE(score.consistency.consistent(consistency_probability));
}

TEST(SetComparison, AnExactElementThatIsWrongIsOutsideEveryEllipse) {
  const SetAlternative alternative = compared(
      study_text("spots: [{x: 1 m}]", "spots: [{x: 1.001 m}]", judge + "validation_gate: 3\n"));
  EXPECT_EQ(alternative.scores[1].matched, 1);
  EXPECT_EQ(alternative.scores[1].inside_95, 0);
  EXPECT_EQ(alternative.scores[1].inside_gate, 0);
}

TEST(SetComparison, ModulesOfOneNameDrawTheSameInTruthAndAlternatives) {
  // Both are off by the same large error, which none states.
  const SetAlternative alternative = compared(study_text(
      "spots: [{x: 1 m}], shared_shift: 10 m", "spots: [{x: 1 m}], shared_shift: 10 m", judge));
  EXPECT_EQ(alternative.scores[1].matched, 1);
  EXPECT_EQ(alternative.scores[1].errors[0].bias, 0);
}

TEST(SetComparison, FaultOfAnAlternativeMissesTheTicksTruthAndOneOfTheTruthLeavesItOut) {
  ReadStudy study = read(
      study_text("spots: [{x: 1 m}], lost: [1, 2, 5]", "spots: [{x: 1 m}], lost: [2, 3]", judge));
  study.study->runs = 10;
  const SetCase one = compare_sets(*study.study)[0];
  EXPECT_EQ(one.ticks, 7);
  EXPECT_EQ(one.truth_faults.at(FaultKind::no_detection).count, 3);
  EXPECT_EQ(one.alternatives[0].outputs, 8);
  EXPECT_EQ(one.alternatives[0].faults.at(FaultKind::no_detection).message, "lost");
  EXPECT_EQ(one.alternatives[0].scores[1].truth, 7);
  EXPECT_EQ(one.alternatives[0].scores[1].matched, 6);
}

TEST(SetComparison, DeviationsAreRelatedToTheReferencesOnCommonMatches) {
  // Modules of one name draw the same, so twice the scatter is exactly twice the deviation.
  const auto graph = [](const std::string& keys) {
    return "{graph: {modules: {m: {type: set_reading, " + keys + "}}, network: m}}\n";
  };
  ReadStudy study =
      read("study: s\npayload: findings\nruns: 20\ntruth: " + graph("spots: [{x: 1 m}]") +
           "alternatives:\n  best: " + graph("spots: [{x: 1 m}], scatter: 1 mm, lost: [3]") +
           "  other: " + graph("spots: [{x: 1 m}], scatter: 2 mm, lost: [4]") +
           "cases: [{name: one}]\nreference: best\njudge: {spot: [z, x]}\n");
  ASSERT_EQ(study.errors, "");
  const SetCase one = compare_sets(*study.study)[0];
  EXPECT_EQ(one.alternatives[1].scores[0].matched, 19);
  const std::vector<double>& ratios = one.alternatives[1].scores[0].relative_deviation;
  ASSERT_EQ(ratios.size(), 2u);
  EXPECT_NEAR(ratios[0], 2, 1e-9);
  EXPECT_NEAR(one.alternatives[0].scores[0].relative_deviation[1], 1, 1e-12);
}

TEST(SetStudy, ReportsEveryMistakeOfItsOwnKeysInOneGo) {
  EXPECT_EQ(read(R"(study: s
payload: findings
requirement: {count: 1}
draw_systematic_errors: true
truth: {graph: {modules: {m: {type: set_reading}}, network: m}}
alternatives: {a: {graph: {modules: {m: {type: set_reading}}, network: m}}}
cases: [{name: one}]
judge:
  piece: {components: [positon, slope, slope], overlap: 1.5, gate: 1 m}
  spot: {components: [x], gate: 10 deg, only: {colour: green, size: big}}
  mood: [level]
  peice: [x]
validation_gate: much
reference: b
)")
                .errors,
            "study.yaml:3:14: 'requirement' is for studies of single estimates; findings is a set\n"
            "study.yaml:4:25: 'draw_systematic_errors' is for studies of single estimates; "
            "findings is a set\n"
            "study.yaml:9:24: piece has no component 'positon'; did you mean 'position'?\n"
            "study.yaml:9:40: 'slope' is judged twice\n"
            "study.yaml:9:57: must be above 0 and at most 1, got '1.5'\n"
            "study.yaml:9:62: piece has no key 'gate'\n"
            "study.yaml:10:33: 'deg' is not a length (m)\n"
            "study.yaml:10:56: expected one of red, blue, got 'green'\n"
            "study.yaml:10:63: spot has no key 'size'\n"
            "study.yaml:11:9: mood cannot be matched: it has neither first_reading and "
            "last_reading nor a place x, z\n"
            "study.yaml:12:3: findings has no key 'peice'; did you mean 'piece'?\n"
            "study.yaml:13:18: expected a chi-square value above 0, got 'much'\n"
            "study.yaml:14:12: no alternative is named 'b'\n");
}

TEST(SetStudy, NeedsToBeToldWhatIsJudged) {
  EXPECT_EQ(read(study_text("frame: here", "frame: here")).errors,
            "study.yaml:1:1: a study of sets needs judge: a map of piece, spot or mood to the "
            "components that are judged\n");
}

TEST(SetStudy, RefusesRecordings) {
  const std::string errors = read(R"(study: s
payload: findings
truth: {recorded: none.csv, columns: {count: {column: count}}}
alternatives: {a: {recorded: none.csv, columns: {count: {column: count}}}}
judge: {spot: [x]}
)")
                                 .errors;
  EXPECT_NE(
      errors.find("study.yaml:3:8: a study of sets compares graphs; recordings hold no sets\n"),
      std::string::npos)
      << errors;
}

TEST(SetStudy, ToleratedGraphIsCheckedLikeTheOthers) {
  EXPECT_EQ(read(study_text("frame: here", "frame: here",
                            judge + "tolerated: {graph: {modules: {m: {type: set_reading, frame: "
                                    "there}}, network: m}}\n"))
                .errors,
            "study.yaml:9:12: 'tolerated' gives findings in frame 'there', but the truth is in "
            "frame 'here'; put a transform at its end\n");
}

}  // namespace
}  // namespace ilss
