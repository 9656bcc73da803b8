// Comparisons: figures of recorded values by hand, of systems by what their noise must give.
#include "framework/study/comparison.h"

#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

using test::Folder;
using test::messages;

constexpr double degree = std::numbers::pi / 180;

Study study_of(const Folder& folder, const std::string& text) {
  folder.write("study.yaml", text);
  Diagnostics diagnostics;
  auto study = read_study(folder.path() / "study.yaml", test::registry(), diagnostics);
  EXPECT_EQ(messages(diagnostics), "");
  return std::move(study.value());
}

Comparison comparison_of(const std::string& text) {
  const Folder folder;
  return compare(study_of(folder, text));
}

std::string system_study(const std::string& alternative, const std::string& more = "") {
  return "study: s\npayload: scalar\n"
         "truth: {graph: {modules: {t: {type: reading, value: 1 m}}, network: t}}\n"
         "alternatives: {a: {graph: " +
         alternative + "}}\ncases: [{name: one}]\n" + more;
}

const std::string noisy =
    "{modules: {r: {type: reading, value: 1.003 m, value_std: 2 mm, noise: normal}}, network: r}";

const CaseAlternative& first(const Comparison& comparison) {
  return comparison.cases.at(0).alternatives.at(0);
}

Comparison compare_turns(const std::string& turns) {
  const Folder folder;
  folder.write("turns.csv", turns);
  return compare(study_of(folder, R"(study: turns
payload: turn
requirement: {angle: 3 deg}
truth: {recorded: turns.csv, columns: {angle: {column: truth, unit: deg}, ratio: {column: ratio}}}
alternatives:
  a: {recorded: turns.csv, columns: {angle: {column: a, unit: deg}, ratio: {column: ratio}}}
)"));
}

TEST(Comparison, ErrorsOfAnglesAreTakenOnTheCircle) {
  const Comparison comparison = compare_turns("truth,a,ratio\n179,-179,1\n");
  EXPECT_NEAR(first(comparison).measurement.errors[0].bias, 2 * degree, 1e-12);
  EXPECT_TRUE(first(comparison).meets_requirement);
}

TEST(Comparison, StatesByHowMuchARequirementIsMissed) {
  const Comparison comparison = compare_turns("truth,a,ratio\n10,6,1\n0,1,1\n");
  const CaseAlternative& missing = first(comparison);
  EXPECT_FALSE(missing.meets_requirement);
  ASSERT_EQ(missing.misses.size(), 1u);
  EXPECT_NEAR(missing.misses[0].error, -4 * degree, 1e-12);
  EXPECT_NEAR(missing.misses[0].excess(), 1 * degree, 1e-12);
  EXPECT_EQ(comparison.summary[0].met, 1);
  EXPECT_FALSE(comparison.requirement_met);
  EXPECT_NEAR(comparison.summary[0].rms[0], std::sqrt((16.0 + 1.0) / 2) * degree, 1e-12);
}

TEST(Comparison, MissingValueMissesTheRequirementButNotTheRms) {
  const Comparison comparison = compare_turns("truth,a,ratio\n0,,1\n0,1,1\n");
  EXPECT_FALSE(first(comparison).meets_requirement);
  EXPECT_EQ(first(comparison).measurement.faults.at(FaultKind::no_detection).count, 1);
  EXPECT_EQ(comparison.summary[0].cases, 1);
  EXPECT_NEAR(comparison.summary[0].rms[0], 1 * degree, 1e-12);
}

TEST(Comparison, CaseWithoutTruthSaysSoAndIsNotJudged) {
  const Comparison comparison = compare_turns("truth,a,ratio\n,1,1\n0,1,1\n");
  ASSERT_TRUE(comparison.cases[0].truth_fault.has_value());
  EXPECT_FALSE(first(comparison).judged);
  EXPECT_TRUE(first(comparison).measurement.errors.empty());
  EXPECT_EQ(comparison.summary[0].judged, 1);
  EXPECT_FALSE(comparison.requirement_met) << "what was not judged is not met";
}

TEST(Comparison, BiasSdAndRmsAreThoseOfTheNoise) {
  const Comparison comparison = comparison_of(system_study(noisy, "runs: 4000\n"));
  const ComponentErrors& errors = first(comparison).measurement.errors.at(0);
  // Within five standard errors: 2 mm / sqrt(4000), and 2 mm / sqrt(8000).
  EXPECT_NEAR(errors.bias, 3e-3, 5 * 3.2e-5);
  EXPECT_NEAR(errors.standard_deviation, 2e-3, 5 * 2.3e-5);
  EXPECT_NEAR(errors.rms, std::sqrt(errors.bias * errors.bias + 4e-6), 1e-4);
}

TEST(Comparison, HonestErrorHasNeesInsideItsBoundsAndABiasedOneNot) {
  const std::string honest =
      "{modules: {r: {type: reading, value: 1 m, value_std: 2 mm, noise: normal}}, network: r}";
  const Comparison fair = comparison_of(system_study(honest, "runs: 2000\n"));
  EXPECT_TRUE(first(fair).measurement.consistency.consistent(consistency_probability))
      << first(fair).measurement.consistency.mean();
  EXPECT_NEAR(first(fair).measurement.errors[0].coverage, 0.95, 0.025);
  const Comparison biased = comparison_of(system_study(noisy, "runs: 2000\n"));
  EXPECT_FALSE(first(biased).measurement.consistency.consistent(consistency_probability));
}

TEST(Comparison, PredictsTheErrorAndJudgesIt) {
  const Comparison comparison = comparison_of(system_study(noisy));
  const CasePrediction& prediction = *first(comparison).prediction;
  EXPECT_FALSE(prediction.fault);
  EXPECT_NEAR(prediction.standard_deviation.at(0), 2e-3, 1e-12);
  EXPECT_EQ(prediction.verdict->verdict, Verdict::linear_ok);
}

TEST(Comparison, UndeclaredTimeIsUnknownAndDeclaredOneIsTheSum) {
  const Comparison unknown = comparison_of(system_study(noisy));
  EXPECT_FALSE(first(unknown).prediction->time_known());
  EXPECT_EQ(first(unknown).prediction->unknown, std::vector<std::string>{"r"});
  const Comparison known = comparison_of(system_study(
      "{modules: {r: {type: reading, time: {typical: 2 ms, worst: 5 ms}}}, network: r}"));
  EXPECT_TRUE(first(known).prediction->time_known());
  EXPECT_DOUBLE_EQ(first(known).prediction->time.worst, 5e-3);
}

TEST(Comparison, FaultsAndPendingTicksAreCountedAndEndNothing) {
  const Comparison comparison = comparison_of(
      system_study("{modules: {r: {type: reading, period: 2, skipped: [2, 4]}}, network: r}",
                   "runs: 10\nrequirement: {x: 1 mm}\n"));
  const CaseMeasurement& measured = first(comparison).measurement;
  EXPECT_EQ(measured.runs, 10);
  EXPECT_EQ(measured.pending, 5);
  EXPECT_EQ(measured.outputs, 3);
  EXPECT_EQ(measured.faults.at(FaultKind::no_detection).count, 2);
  EXPECT_EQ(measured.inside, 3) << "a run without output is not inside the requirement";
}

TEST(Comparison, ErrorsOfConstantsAreDrawnInEachRunUnlessToldNotTo) {
  const std::string systematic =
      "{modules: {r: {type: reading}, g: {type: gain, gain: {value: 1, std: 0.01}}}, "
      "network: {serial: [r, g]}}";
  const Comparison drawn = comparison_of(system_study(systematic, "runs: 2000\n"));
  EXPECT_NEAR(first(drawn).measurement.errors[0].standard_deviation, 0.01, 5 * 1.6e-4);
  EXPECT_TRUE(first(drawn).measurement.consistency.consistent(consistency_probability))
      << first(drawn).measurement.consistency.mean();
  const Comparison exact =
      comparison_of(system_study(systematic, "runs: 20\ndraw_systematic_errors: false\n"));
  EXPECT_EQ(first(exact).measurement.errors[0].rms, 0);
}

TEST(Comparison, OneConstantsErrorIsDrawnAlikeWhereverItIsUsed) {
  // (1 + k) reading / (what a gain of the same constant made of it) has no error.
  const Comparison comparison = comparison_of(system_study(
      "{constants: {k: {value: 2, std: 0.1}}, modules: {r: {type: reading, value: 1 m}, "
      "g: {type: gain, gain: $k}, h: {type: gain, gain: $k}, zero: {type: subtract}, "
      "one: {type: reading, value: 1 m}, sum: {type: add}}, network: {serial: [{combine: "
      "[{serial: [{combine: [{serial: [r, g]}, {serial: [r, h]}]}, zero]}, one]}, sum]}}",
      "runs: 50\n"));
  EXPECT_EQ(first(comparison).measurement.outputs, 50);
  EXPECT_EQ(first(comparison).measurement.errors.at(0).rms, 0);
}

TEST(Comparison, SameSeedGivesTheSameFiguresAndAnotherSeedOthers) {
  const auto bias = [](const std::string& seed) {
    return first(comparison_of(system_study(noisy, "runs: 10\nseed: " + seed + "\n")))
        .measurement.errors[0]
        .bias;
  };
  EXPECT_EQ(bias("7"), bias("7"));
  EXPECT_NE(bias("7"), bias("8"));
}

}  // namespace
}  // namespace ilss
