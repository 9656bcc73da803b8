// Derivatives of random formulas against dual numbers carried through and against differences.
#include "sensors/formula/tape.h"

#include <ceres/jet.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "sensors/formula/formula_parser.h"

namespace ilss {
namespace {

constexpr std::size_t variables = 4;
using Dual = ceres::Jet<double, variables>;

/// A formula that knows its text and its value over any scalar, apart from the tape.
struct Tree {
  std::string operation;  ///< "x0", "2.5", "+", "sqrt"
  double number = 0;
  std::vector<Tree> parts = {};

  std::string text() const {
    if (parts.empty()) return operation;
    if (!std::isalpha(static_cast<unsigned char>(operation[0])))
      return parts.size() == 1
                 ? fmt::format("({}{})", operation, parts[0].text())
                 : fmt::format("({} {} {})", parts[0].text(), operation, parts[1].text());
    std::string list = parts[0].text();
    for (std::size_t i = 1; i < parts.size(); ++i) list += ", " + parts[i].text();
    return fmt::format("{}({})", operation, list);
  }

  bool all_finite(const Dual* x) const {
    const Dual own = value(x);
    return std::isfinite(own.a) && own.v.allFinite() &&
           std::all_of(parts.begin(), parts.end(),
                       [x](const Tree& part) { return part.all_finite(x); });
  }

  template <typename T>
  T value(const T* x) const {
    using std::abs, std::atan, std::atan2, std::cos, std::exp, std::hypot, std::log, std::sin,
        std::sqrt, std::tanh;
    if (parts.empty()) return operation[0] == 'x' ? x[operation[1] - '0'] : T(number);
    const T a = parts[0].value(x);
    if (operation == "-" && parts.size() == 1) return -a;
    if (operation == "sqrt") return sqrt(a);
    if (operation == "exp") return exp(a);
    if (operation == "log") return log(a);
    if (operation == "sin") return sin(a);
    if (operation == "cos") return cos(a);
    if (operation == "atan") return atan(a);
    if (operation == "tanh") return tanh(a);
    if (operation == "abs") return abs(a);
    const T b = parts[1].value(x);
    if (operation == "+") return a + b;
    if (operation == "-") return a - b;
    if (operation == "*") return a * b;
    if (operation == "/") return a / b;
    if (operation == "^") return pow(a, parts[1].number);
    if (operation == "min") return b < a ? b : a;
    if (operation == "max") return a < b ? b : a;
    if (operation == "hypot") return hypot(a, b);
    if (operation == "atan2") return atan2(a, b);
    throw std::logic_error(operation);
  }
};

Tree random_tree(std::mt19937& random, int depth) {
  const auto pick = [&](int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); };
  if (depth == 0 || pick(6) == 0) {
    if (pick(4) != 0) return {fmt::format("x{}", pick(variables))};
    const double number = std::round(std::uniform_real_distribution<>(0.1, 9)(random) * 10) / 10;
    return {fmt::format("{}", number), number};
  }
  static const std::vector<std::string> unary = {"-",   "sqrt", "exp",  "log", "sin",
                                                 "cos", "atan", "tanh", "abs"};
  static const std::vector<std::string> binary = {"+", "-",   "*",   "/",     "+",
                                                  "*", "min", "max", "hypot", "atan2"};
  if (pick(3) == 0)
    return {unary[static_cast<std::size_t>(pick(9))], 0, {random_tree(random, depth - 1)}};
  if (pick(8) == 0) {
    const double exponents[] = {2, 3, -1, 0.5, -2};
    const double exponent = exponents[pick(5)];
    Tree number{fmt::format("{}", exponent), exponent};
    return {"^", 0, {random_tree(random, depth - 1), std::move(number)}};
  }
  Tree left = random_tree(random, depth - 1);
  Tree right = random_tree(random, depth - 1);
  return {binary[static_cast<std::size_t>(pick(10))], 0, {std::move(left), std::move(right)}};
}

/// A tape of one formula over x0 ... x3.
Tape tape_of(const std::string& text) {
  ArgumentNames names;
  for (Tape::Index i = 0; i < variables; ++i) names[fmt::format("x{}", i)] = i;
  Tape tape(variables);
  Tape::Index result = 0;
  for (const FormulaError& error : parse_formula(text, names, tape, result))
    ADD_FAILURE() << text << ": " << error.message;
  tape.end_formula(result);
  return tape;
}

struct Point {
  std::array<double, variables> x;
  double value = 0;
  std::array<double, variables> gradient = {};
  bool finite = false;
};

Point linearized(const Tape& tape, const std::array<double, variables>& x) {
  Tape::Workspace workspace(tape);
  Point point{x};
  point.finite = !tape.linearize(x, {&point.value, 1}, point.gradient, workspace);
  for (const double derivative : point.gradient) point.finite &= std::isfinite(derivative);
  return point;
}

TEST(Tape, DerivativesOfRandomFormulasAreThoseOfDualNumbers) {
  int compared = 0;
  for (unsigned seed = 1; seed <= 4000; ++seed) {
    std::mt19937 random(seed);
    const Tree tree = random_tree(random, 5);
    SCOPED_TRACE(fmt::format("seed {}: {}", seed, tree.text()));
    std::array<double, variables> x{};
    std::array<Dual, variables> duals;
    for (std::size_t i = 0; i < variables; ++i) {
      x[i] = std::uniform_real_distribution<>(-3, 3)(random);
      duals[i] = Dual(x[i], static_cast<int>(i));
    }
    const Dual expected = tree.value(duals.data());
    const Point point = linearized(tape_of(tree.text()), x);
    if (!std::isfinite(expected.a) || !expected.v.allFinite()) continue;
    if (!point.finite) {  // a part without a finite value that the whole hides: 1 / exp(exp(9))
      EXPECT_FALSE(tree.all_finite(duals.data()));
      continue;
    }
    ASSERT_NEAR(point.value, expected.a, 1e-12 * std::abs(expected.a));
    const double size = 1 + expected.v.norm();
    for (std::size_t i = 0; i < variables; ++i)
      ASSERT_NEAR(point.gradient[i], expected.v[static_cast<Eigen::Index>(i)], 1e-9 * size) << i;
    ++compared;
  }
  EXPECT_GE(compared, 1500);
}

TEST(Tape, DerivativesOfRandomFormulasAreLimitsOfDifferences) {
  int compared = 0;
  for (unsigned seed = 1; seed <= 4000; ++seed) {
    std::mt19937 random(seed);
    const Tree tree = random_tree(random, 3);
    SCOPED_TRACE(fmt::format("seed {}: {}", seed, tree.text()));
    std::array<double, variables> x{};
    for (double& value : x) value = std::uniform_real_distribution<>(0.3, 3)(random);
    const Point point = linearized(tape_of(tree.text()), x);
    const auto difference = [&](std::size_t i, double step) {
      auto above = x;
      auto below = x;
      above[i] += step;
      below[i] -= step;
      return (tree.value(above.data()) - tree.value(below.data())) / (2 * step);
    };
    if (!point.finite || std::abs(point.value) > 1e3) continue;
    for (std::size_t i = 0; i < variables; ++i) {
      const double wide = difference(i, 2e-4);
      const double narrow = difference(i, 1e-4);
      // Where the difference depends on its step, the formula bends or kinks here.
      if (!(std::abs(wide - narrow) < 1e-6 * (1 + std::abs(narrow)))) continue;
      ASSERT_NEAR(point.gradient[i], narrow, 2e-6 * (1 + std::abs(narrow))) << i;
      ++compared;
    }
  }
  EXPECT_GE(compared, 5000);
}

TEST(Tape, NodesThatAMaximumDidNotChooseTakeNoPart) {
  const Point point = linearized(tape_of("max(sqrt(x0), x1)"), {0, 2, 0, 0});
  EXPECT_TRUE(point.finite);
  EXPECT_EQ(point.gradient[0], 0);
  EXPECT_EQ(point.gradient[1], 1);
}

TEST(Tape, InfiniteDerivativeIsNotHiddenByAZeroFactor) {
  EXPECT_FALSE(linearized(tape_of("x0 * sqrt(x1)"), {0, 0, 0, 0}).finite);
}

TEST(Tape, WholePowersOfNegativeNumbersHaveDerivatives) {
  const Point point = linearized(tape_of("x0^3 + x1^2 + x2^-1"), {-2, 0, -1, 0});
  EXPECT_TRUE(point.finite);
  EXPECT_EQ(point.gradient[0], 12);
  EXPECT_EQ(point.gradient[1], 0);
  EXPECT_EQ(point.gradient[2], -1);
}

}  // namespace
}  // namespace ilss
