// Reading formulas: precedence, and what is said of those that are wrong.
#include "sensors/formula/formula_parser.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ilss {
namespace {

const ArgumentNames names = {{"x", 0}, {"y", 1}, {"rows.y_l", 2}};

double value_of(const std::string& text, double x = 0, double y = 0, double y_l = 0) {
  Tape tape(3);
  Tape::Index result = 0;
  for (const FormulaError& error : parse_formula(text, names, tape, result))
    ADD_FAILURE() << text << ": " << error.offset << ": " << error.message;
  tape.end_formula(result);
  Tape::Workspace workspace(tape);
  const double arguments[] = {x, y, y_l};
  double value = 0;
  EXPECT_FALSE(tape.evaluate(arguments, {&value, 1}, workspace)) << text;
  return value;
}

/// "offset: message", a line each.
std::string errors_of(const std::string& text) {
  Tape tape(3);
  Tape::Index result = 0;
  std::string lines;
  for (const FormulaError& error : parse_formula(text, names, tape, result))
    lines += std::to_string(error.offset) + ": " + error.message + "\n";
  return lines;
}

TEST(FormulaParser, PowerBindsBeforeSignAndToTheRight) {
  EXPECT_EQ(value_of("-2^2"), -4);
  EXPECT_EQ(value_of("(-2)^2"), 4);
  EXPECT_EQ(value_of("2^-1"), 0.5);
  EXPECT_EQ(value_of("2^3^2"), 512);
  EXPECT_EQ(value_of("2^-x^2", 2), 0.0625);
  EXPECT_EQ(value_of("-x^2", 3), -9);
  EXPECT_EQ(value_of("2*-x^2", 3), -18);
}

TEST(FormulaParser, EqualOperatorsBindToTheLeft) {
  EXPECT_EQ(value_of("10-3-2"), 5);
  EXPECT_EQ(value_of("12/2*3"), 18);
  EXPECT_EQ(value_of("12/2/3"), 2);
  EXPECT_EQ(value_of("2+3*4-5"), 9);
  EXPECT_EQ(value_of("x - -y", 1, 2), 3);
  EXPECT_EQ(value_of("x + +y", 1, 2), 3);
  EXPECT_EQ(value_of("-x*y", 3, 2), -6);
  EXPECT_EQ(value_of("6/-x", 3), -2);
}

TEST(FormulaParser, CallsNest) {
  EXPECT_EQ(value_of("max(min(x, y), 1, abs(-y))", 3, 2), 2);
  EXPECT_DOUBLE_EQ(value_of("sqrt(hypot(x, y) + 11)", 3, 4), 4);
  EXPECT_DOUBLE_EQ(value_of("atan2(y, x)", 1, 1), std::numbers::pi / 4);
  EXPECT_DOUBLE_EQ(value_of("log(exp(x)) + log10(100)", 0.25), 2.25);
}

TEST(FormulaParser, NumbersConstantsAndDottedNames) {
  EXPECT_EQ(value_of("1.5e-3 + .5 + 2."), 2.5015);
  EXPECT_EQ(value_of("pi * rad"), std::numbers::pi);
  EXPECT_EQ(value_of("rows.y_l*2", 0, 0, 21), 42);
  EXPECT_EQ(value_of("x\n  + y", 1, 2), 3);
  EXPECT_EQ(value_of("x", 7), 7);
}

TEST(FormulaParser, UnknownNamesAreReportedAllAtOnceWithSuggestions) {
  EXPECT_EQ(errors_of("x + rows.y_L * zz + squrt(y)"),
            "4: unknown name 'rows.y_L'; did you mean 'rows.y_l'?\n"
            "15: unknown name 'zz'\n"
            "20: there is no function 'squrt'; did you mean 'sqrt'?\n");
}

TEST(FormulaParser, MistakesInGrammarStandWhereTheyAre) {
  EXPECT_EQ(errors_of("x +"), "3: the formula ends too soon\n");
  EXPECT_EQ(errors_of("(x + y"), "6: a ')' is missing\n");
  EXPECT_EQ(errors_of("x + y)"), "5: unexpected ')'\n");
  EXPECT_EQ(errors_of("x * * y"), "4: unexpected '*'\n");
  EXPECT_EQ(errors_of("x y"), "2: unexpected 'y'; is an operator missing before it?\n");
  EXPECT_EQ(errors_of("x 2"), "2: unexpected '2'; is an operator missing before it?\n");
  EXPECT_EQ(errors_of("2x"), "1: unexpected 'x'; is an operator missing before it?\n");
  EXPECT_EQ(errors_of("x, y"), "1: a ',' can stand between a function's arguments only\n");
  EXPECT_EQ(errors_of("hypot(x)"), "7: 'hypot' needs more arguments\n");
  EXPECT_EQ(errors_of("hypot(x, y, x)"), "13: 'hypot' has too many arguments\n");
  EXPECT_EQ(errors_of("sin x"), "0: 'sin' is a function; expected sin(...)\n");
  EXPECT_EQ(errors_of("  "), "0: the formula is empty\n");
  EXPECT_EQ(errors_of("x + 1e999"), "4: '1e999' is not a number\n");
}

TEST(FormulaParser, WhatATapeCannotHoldIsRefused) {
  const std::string refused = ": a formula has no conditions, comparisons or assignments\n";
  EXPECT_EQ(errors_of("x ? y : x"), "2: '?'" + refused + "6: ':'" + refused);
  EXPECT_EQ(errors_of("x == y"), "2: '='" + refused);
  EXPECT_EQ(errors_of("x = y"), "2: '='" + refused);
  EXPECT_EQ(errors_of("x < y"), "2: '<'" + refused);
  EXPECT_EQ(errors_of("x ** 2"), "2: '**' is written '^' in a formula\n");
  EXPECT_EQ(errors_of("\"x\""),
            "0: '\"' cannot stand in a formula\n2: '\"' cannot stand in a formula\n");
  EXPECT_EQ(errors_of("x + µ"), "4: 'µ' cannot stand in a formula\n");
}

TEST(FormulaParser, UnitsOfNumbersBelongToQuantities) {
  EXPECT_EQ(errors_of("x + 215 nm"),
            "8: numbers in a formula have no unit; make '215 nm' one of the quantities\n");
}

TEST(FormulaParser, DeepNestingAndLongFormulasEnd) {
  const std::string deep = std::string(3000, '(') + "x" + std::string(3000, ')');
  EXPECT_EQ(value_of(deep, 5), 5);
  std::string calls = "x";
  for (int i = 0; i < 1000; ++i) calls.insert(0, "abs(").append(")");
  EXPECT_EQ(value_of(calls, -5), 5);
  EXPECT_EQ(errors_of(std::string(20'000, 'x')), "0: a formula has at most 10000 characters\n");
}

}  // namespace
}  // namespace ilss
