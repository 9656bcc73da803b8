// Formulas whose first order looks right and is not: no verdict may believe it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "framework/semantics/verdict.h"
#include "sensors/register.h"

namespace ilss {
namespace {

/// The verdict on a formula of x0, x1, ..., each `mean` ± `deviation`.
VerdictReport judged(const std::string& formula, int count, double mean, double deviation,
                     const std::string& law = "") {
  static const Registry& registry = *[] {  // which plans refer to
    auto* made = new Registry;
    register_sensors(*made);
    return made;
  }();
  std::string quantities;
  for (int i = 0; i < count; ++i)
    quantities +=
        fmt::format("{}x{}: {{value: {}, std: {}{}}}", i == 0 ? "" : ", ", i, mean, deviation, law);
  Diagnostics diagnostics;
  const Node graph = parse_document(
      fmt::format("modules: {{f: {{type: expression, quantities: {{{}}}, output: {{y: {{unit: 1, "
                  "formula: '{}'}}}}}}}}\nnetwork: f\n",
                  quantities, formula),
      "formula", diagnostics);
  const auto plan = build_plan(graph, ".", registry, {}, diagnostics);
  for (const Diagnostic& d : diagnostics.sorted()) ADD_FAILURE() << format_diagnostic(d);
  System system(plan.value(), 1);
  system.expect();
  return judge(system).at(0);
}

std::string sum_of(int count) {
  std::string sum = "(x0";
  for (int i = 1; i < count; ++i) sum += fmt::format(" + x{}", i);
  return sum + ")";
}

TEST(DoubtfulFormulas, AnErrorOfZeroIsNotBelievedWhereThereIsOne) {
  for (const char* cubic : {"x0^3", "tanh(x0)^3"})
    EXPECT_EQ(judged(cubic, 1, 0, 1).verdict, Verdict::monte_carlo_required) << cubic;
  EXPECT_EQ(judged("x0*x1*x2", 3, 0, 1).verdict, Verdict::monte_carlo_required);
  EXPECT_EQ(judged("max(x0, 0)", 1, -0.2, 0.1).verdict, Verdict::monte_carlo_required);
  EXPECT_EQ(judged("max(" + sum_of(12) + ", 0)", 12, -0.26, 1).verdict,
            Verdict::monte_carlo_required);
}

TEST(DoubtfulFormulas, LimitsAndKinksBeyondTheMovesAreSeen) {
  EXPECT_NE(judged("min(max(x0, 0), 5)", 1, 2.5, 1.4).verdict, Verdict::linear_ok);
  EXPECT_NE(judged("min(max(" + sum_of(6) + ", -2.06), 2.06)", 6, 0, 1).verdict,
            Verdict::linear_ok);
  EXPECT_NE(judged("x0 + 100 * (max(x0 - 1.76, 0) + min(x0 + 1.76, 0))", 1, 0, 1).verdict,
            Verdict::linear_ok);
  EXPECT_NE(judged(sum_of(12) + " + 5 * max(" + sum_of(12) + " - 2.05, 0)", 12, 0, 1).verdict,
            Verdict::linear_ok);
}

TEST(DoubtfulFormulas, WhatSourcesDoOnlyTogetherIsSeen) {
  EXPECT_NE(judged("x0 + 5 * x1 * x2 * x3", 4, 0, 1).verdict, Verdict::linear_ok);
  EXPECT_NE(judged("0.7 * x0 * x1 * x2 + 0.3 * " + sum_of(14), 14, 0, 1).verdict,
            Verdict::linear_ok);
}

// sqrt(3) standard deviations are a whole turn here.
TEST(DoubtfulFormulas, APeriodThatFitsTheMovesIsSeen) {
  EXPECT_NE(judged("x0 + 10 * cos(x1 * rad)", 2, 0, 3.6276).verdict, Verdict::linear_ok);
}

TEST(DoubtfulFormulas, FaultsInADirectionThatManyShareAreCounted) {
  const std::string sum = sum_of(4);
  EXPECT_EQ(judged(sum + " + 1e-9 * sqrt(" + sum + ")", 4, 0.76, 1).verdict, Verdict::invalid);
}

TEST(DoubtfulFormulas, ALawOfHeavyTailsIsNoNormalOne) {
  EXPECT_EQ(judged("x0", 1, 0, 1, ", distribution: t, degrees_of_freedom: 2.05").verdict,
            Verdict::monte_carlo_required);
  EXPECT_EQ(judged("x0", 1, 0, 1, ", distribution: t, degrees_of_freedom: 8").verdict,
            Verdict::linear_ok);
}

TEST(DoubtfulFormulas, WhatIsStraightIsStillBelieved) {
  EXPECT_EQ(judged("x0^2", 1, 1, 0.02).verdict, Verdict::linear_ok);
  EXPECT_EQ(judged(sum_of(14), 14, 0, 1).verdict, Verdict::linear_ok);
  EXPECT_EQ(judged("max(x0, 0)", 1, 0.5, 0.1).verdict, Verdict::linear_ok);
}

}  // namespace
}  // namespace ilss
