// Verdicts: when may a first-order error be believed?
#include "framework/semantics/verdict.h"

#include <gtest/gtest.h>

#include "framework/graph/given_outputs.h"
#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

using test::output_of;
using test::plan_of;

/// The verdict on `x` (value and sd) through a network of one branch.
struct Judged {
  Plan plan;
  System system;
  VerdictReport report;

  Judged(const std::string& x, const std::string& modules, const std::string& network)
      : plan(plan_of("modules: {x: {type: reading, " + x + "}, " + modules +
                     "}\nnetwork: {serial: [" + network + "]}\n")),
        system(plan, 1) {
    system.expect();
    report = judge(system).at(0);
  }
  double variance() const { return output_of(system).lineage.variance(0); }
};

TEST(Verdict, LinearFunctionIsLinearOk) {
  const Judged judged("value: 1 m, value_std: 1 m", "g: {type: gain, gain: -3, offset: 1 m}",
                      "x, g");
  EXPECT_EQ(judged.report.verdict, Verdict::linear_ok);
  EXPECT_NEAR(judged.variance(), 9, 1e-12);
  EXPECT_NEAR(judged.report.bias[0], 0, 1e-12);
}

TEST(Verdict, ExactOutputIsLinearOkWithNothingToCorrect) {
  const Judged judged("value: 1 m", "g: {type: gain, gain: 3}", "x, g");
  EXPECT_EQ(judged.report.verdict, Verdict::linear_ok);
  EXPECT_TRUE(judged.report.components.empty());
  EXPECT_TRUE(judged.report.bias.empty());
}

TEST(Verdict, SquareAtZeroIsNotLinear) {
  const Judged judged("value: 0 m, value_std: 1 mm", "p: {type: product}", "combine: [x, x], p");
  EXPECT_EQ(judged.variance(), 0);
  EXPECT_EQ(judged.report.verdict, Verdict::monte_carlo_required);
  // E[x²] = s², Var[x²] = 2 s⁴ of a normal x.
  EXPECT_NEAR(judged.report.bias[0], 1e-6, 1e-15);
  EXPECT_NEAR(judged.report.extra_variance[0], 2e-12, 1e-20);
}

TEST(Verdict, ProductOfTwoAtZeroIsNotLinear) {
  const Plan plan = plan_of(R"(
modules: {x: {type: reading, value: 0 m, value_std: 1 mm}, y: {type: reading, value: 0 m, value_std: 2 mm}, p: {type: product}}
network: {serial: [combine: [x, y], p]}
)");
  System system(plan, 1);
  system.expect();
  const VerdictReport report = judge(system).at(0);
  EXPECT_EQ(output_of(system).lineage.variance(0), 0);
  EXPECT_EQ(report.verdict, Verdict::monte_carlo_required);
  EXPECT_NEAR(report.extra_variance[0], 4e-12, 1e-20);  // Var[x y] = sx² sy²
}

TEST(Verdict, ProductAwayFromZeroIsLinearOk) {
  const Plan plan = plan_of(R"(
modules: {x: {type: reading, value: 1 m, value_std: 1 mm}, y: {type: reading, value: 2 m, value_std: 2 mm}, p: {type: product}}
network: {serial: [combine: [x, y], p]}
)");
  System system(plan, 1);
  system.expect();
  EXPECT_EQ(judge(system).at(0).verdict, Verdict::linear_ok);
}

TEST(Verdict, MildCurvatureIsLinearOkAndStrongIsNot) {
  EXPECT_EQ(Judged("value: 1 m, value_std: 1 cm", "s: {type: sine}", "x, s").report.verdict,
            Verdict::linear_ok);
  EXPECT_EQ(Judged("value: 1 m, value_std: 1 m", "s: {type: sine}", "x, s").report.verdict,
            Verdict::second_order);
}

TEST(Verdict, KinkNearbyIsSecondOrderAndFarAwayIsNot) {
  EXPECT_EQ(Judged("value: 1 mm, value_std: 1 mm", "m: {type: magnitude}", "x, m").report.verdict,
            Verdict::second_order);
  EXPECT_EQ(Judged("value: 5 mm, value_std: 1 mm", "m: {type: magnitude}", "x, m").report.verdict,
            Verdict::linear_ok);
}

TEST(Verdict, ErrorsThatLeadOutOfTheDomainAreInvalid) {
  EXPECT_EQ(Judged("value: 1 mm, value_std: 1 mm", "r: {type: root}", "x, r").report.verdict,
            Verdict::invalid);
  EXPECT_EQ(Judged("value: 1 m, value_std: 1 mm", "r: {type: root}", "x, r").report.verdict,
            Verdict::linear_ok);
}

TEST(Verdict, DifferenceWithItselfIsLinearOkWithErrorZero) {
  const Judged judged("value: 1 m, value_std: 1 m", "s: {type: subtract}", "combine: [x, x], s");
  EXPECT_EQ(judged.report.verdict, Verdict::linear_ok);
  EXPECT_EQ(judged.variance(), 0);
}

TEST(Verdict, RoundingOfWhatCancelsIsNoError) {
  // (3 x - 2 x) - x, in numbers that are not exact.
  const Judged judged("value: 0.7 m, value_std: 0.1 m",
                      "a: {type: gain, gain: 3.3}, b: {type: gain, gain: 2.3}, "
                      "s: {type: subtract}, t: {type: subtract}",
                      "combine: [{serial: [x, combine: [a, b], s]}, x], t");
  EXPECT_EQ(judged.report.verdict, Verdict::linear_ok);
  EXPECT_LT(judged.variance(), 1e-28);
}

TEST(Verdict, ChainsAreJudgedAsAWhole) {
  // Each sine is curved; of their difference nothing is left.
  EXPECT_EQ(Judged("value: 1 m, value_std: 1 m",
                   "a: {type: sine}, b: {type: sine}, s: {type: subtract}", "x, combine: [a, b], s")
                .report.verdict,
            Verdict::linear_ok);
  // Neither the square nor the root is linear here, but the root of the square is.
  EXPECT_EQ(Judged("value: 1 m, value_std: 0.3 m", "p: {type: product}, r: {type: root}",
                   "combine: [x, x], p, r")
                .report.verdict,
            Verdict::linear_ok);
}

TEST(Verdict, ErrorsOfParametersCount) {
  EXPECT_EQ(
      Judged("value: 0 m, bias: {value: 0 m, std: 1 m}", "s: {type: sine}", "x, s").report.verdict,
      Verdict::monte_carlo_required);
}

TEST(Verdict, GivenOutputsAreMovedThemselves) {
  const Plan plan = plan_of(R"(
modules: {x: {type: reading, value: 1 m, value_std: 1 mm}, r: {type: root}, s: {type: sine}}
network: {serial: [x, r, s]}
)");
  const std::size_t r = plan.find("r").value();
  Output given{Estimate(descriptor<test::Scalar>())};
  given.estimate.value = {0.5};
  given.estimate.lineage.add({9, 0, 0}, std::size_t{0}, 2.0);
  System system(plan, 1, {.stand_ins = given_outputs({{r, {given, true}}})});
  system.expect();
  EXPECT_EQ(judge(system, {r}).at(0).verdict, Verdict::monte_carlo_required);
}

}  // namespace
}  // namespace ilss
