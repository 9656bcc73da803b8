// The module `linear`: matrices, least squares, and what is said of wrong ones.
#include "sensors/formula/linear.h"

#include <random>

#include "tests/sensors/formula/graph_of_formulas.h"

namespace ilss {
namespace {

using test::Evaluated;
using test::read_formulas;

/// A graph of one linear module over quantities of 1 m, 2 m and 4 m with stds of 0.1 m; `keys` are
/// the module's further lines.
test::FormulaGraph read_linear(const std::vector<std::string>& keys) {
  std::string text =
      "modules:\n  f:\n    type: linear\n    quantities:\n      a: {value: 1 m, std: 0.1 m}\n      "
      "b: "
      "{value: 2 m, std: 0.1 m}\n      c: {value: 4 m, std: 0.1 m}\n";
  for (const std::string& key : keys) text += "    " + key + "\n";
  return read_formulas(text + "network: f\n");
}

TEST(Linear, IsTheMatrixTimesTheArgumentsPlusTheOffset) {
  const Evaluated map(read_linear(
      {"matrix: [[1, 1, 1], [1, 0, -1]]", "offset: [10, 20]", "output: {sum: m, difference: mm}"}));
  EXPECT_EQ(map.estimate().type->name, "sum_difference");
  EXPECT_EQ(map.estimate().value, (std::vector<double>{17, 17}));
  Eigen::Matrix2d covariance;
  covariance << 0.03, 0, 0, 0.02;
  EXPECT_TRUE(map.estimate().lineage.covariance().isApprox(covariance, 1e-12));
}

TEST(Linear, DesignIsSolvedByLeastSquares) {
  // A mean and a slope through three points at -1, 0 and 1.
  const Evaluated fit(
      read_linear({"design: [[1, -1], [1, 0], [1, 1]]", "output: {mean: m, slope: m}"}));
  EXPECT_NEAR(fit.estimate().value[0], 7.0 / 3, 1e-12);
  EXPECT_NEAR(fit.estimate().value[1], 1.5, 1e-12);
  EXPECT_NEAR(fit.estimate().lineage.variance(0), 0.01 / 3, 1e-12);
  EXPECT_NEAR(fit.estimate().lineage.variance(1), 0.01 / 2, 1e-12);
}

TEST(Linear, DesignOfVeryUnequalColumnsIsNotTakenForSingular) {
  const Evaluated fit(
      read_linear({"design: [[1, -1e-18], [1, 0], [1, 1e-18]]", "output: {mean: m, slope: m}"}));
  EXPECT_NEAR(fit.estimate().value[1], 1.5e18, 1e6);
}

TEST(Linear, TakesInputsBeforeQuantities) {
  const Evaluated map(read_formulas(R"(
modules:
  a: {type: expression, quantities: {k: {value: 2 m, std: 1 m}}, output: {x: {unit: m, formula: k}, y: {unit: m, formula: 3 * k}}}
  f: {type: linear, inputs: [in], quantities: {b: 5 m}, matrix: [[1, 10, 100]], output: {q: m}}
network: {serial: [a, f]}
)"));
  EXPECT_EQ(map.value(), 562);
  EXPECT_EQ(map.estimate().lineage.standard_deviation(0), 31);
}

TEST(Linear, SingularDesignIsAnErrorOfTheGraph) {
  EXPECT_EQ(read_linear({"design: [[1, 2], [2, 4], [3, 6]]", "output: {p: m, q: m}"}).errors,
            "graph.yaml:8:13: the design does not determine p, q: 3 rows of rank 1; it needs rank "
            "2\n");
  EXPECT_EQ(read_linear({"design: [[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0]]",
                         "output: {p: m, q: m, r: m, s: m}"})
                .errors,
            "graph.yaml:8:13: the design does not determine p, q, r, s: 3 rows of rank 3; it needs "
            "rank 4\n");
}

TEST(Linear, WrongSizesSayWhatRowsAndColumnsAre) {
  EXPECT_EQ(read_linear({"matrix: [[1, 2]]", "output: {p: m, q: m}"}).errors,
            "graph.yaml:8:13: expected 2 rows of 3 numbers, got 1 of 2; rows are p, q, columns a, "
            "b, c\n");
  EXPECT_EQ(read_linear({"design: [[1, 2]]", "output: {p: m}"}).errors,
            "graph.yaml:8:13: expected 3 rows of 1 number, got 1 of 2; rows are a, b, c, columns "
            "p\n");
  EXPECT_EQ(read_linear({"matrix: [[1, 2, 3]]", "offset: [1, 2]", "output: {p: m}"}).errors,
            "graph.yaml:9:13: expected 1 numbers, one for each output, got 2\n");
}

TEST(Linear, WhatIsNoMatrixIsAnError) {
  EXPECT_EQ(read_linear({"matrix: [[1, x, 3 m], [1]]", "output: {p: m}"}).errors,
            "graph.yaml:8:18: expected a number, in SI units, got 'x'\n"
            "graph.yaml:8:21: expected a number, in SI units, got '3 m'\n"
            "graph.yaml:8:27: expected a list of 3 numbers, got 1\n");
  EXPECT_EQ(read_linear({"output: {p: m}"}).errors,
            "graph.yaml:2:3: a linear map needs either a matrix or a design\n");
  EXPECT_EQ(read_linear({"matrix: [[1, 2, .nan]]", "output: {p: m}"}).errors,
            "graph.yaml:8:21: expected a number, in SI units, got '.nan'\n");
}

TEST(Linear, ArgumentsWithoutInfluenceAreErrors) {
  EXPECT_EQ(read_linear({"matrix: [[1, 0, 2]]", "output: {p: m}"}).errors,
            "graph.yaml:6:7: 'b' is not used\n");
}

TEST(Linear, ResultTooLargeIsAFault) {
  const Evaluated map(read_linear({"matrix: [[1e308, 1e308, 1e308]]", "output: {p: m}"}));
  ASSERT_TRUE(map.state().outcome.is_fault());
  EXPECT_EQ(map.state().outcome.fault().kind, FaultKind::not_finite);
}

}  // namespace
}  // namespace ilss
