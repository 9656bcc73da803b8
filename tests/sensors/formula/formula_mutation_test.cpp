// Whatever a formula says, it is read or refused, and evaluates to finite numbers or a fault.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/sensors/formula/graph_of_formulas.h"

namespace ilss {
namespace {

std::string mutated(std::mt19937& random) {
  static const std::vector<std::string> formulas = {"ls + d - ls * (a * t + b * t)",
                                                    "sqrt(ls^2 + d^2) * cos(phi) / max(1, n)",
                                                    "ls * exp(-n) + d * log10(n + 2)",
                                                    "hypot(ls, d) - min(ls, d, ls * sin(phi)) ^ 1",
                                                    "ls * atan2(d, ls) / rad + -d * tanh(n / 3)",
                                                    "ls / (n - 4) + d * asin(n / 8) / rad"};
  static const std::vector<std::string> pieces = {
      "+",      "-",  "*", "/",   "^",  "(",        ")",     ",",      ".",   "..", "1e9",  "0",
      "1e-300", "ls", "d", "phi", "n",  "sqrt",     "sqrt(", "atan2(", "rad", "pi", "min(", " ",
      "?",      ":",  "=", "<",   "\\", "\xc3\xa9", "e",     "1e",     "0x1", "--", "**",   "sin"};
  const auto pick = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  std::string text = formulas[pick(formulas.size())];
  for (std::size_t mutations = 1 + pick(4); mutations > 0; --mutations) {
    const std::size_t at = pick(text.size() + 1);
    const std::size_t length = std::min(pick(4), text.size() - at);
    text.replace(at, length, pick(4) == 0 ? "" : pieces[pick(pieces.size())]);
  }
  return text;
}

/// As it stands between double quotes in YAML.
std::string escaped(std::string text) {
  for (std::size_t at = 0; (at = text.find('\\', at)) != std::string::npos; at += 2)
    text.insert(at, "\\");
  return text;
}

/// The quantities that a formula uses, by what was said of the others.
std::string used_quantities(const std::string& errors) {
  static const std::vector<std::pair<std::string, std::string>> all = {
      {"ls", "{value: 5 m, std: 1 mm}"},
      {"d", "{value: 0 m, std: 2 mm}"},
      {"a", "1e-6 1/K"},
      {"b", "2e-6 1/K"},
      {"t", "3 K"},
      {"phi", "{value: 30 deg, std: 1 deg}"},
      {"n", "{value: 4, std: 0.1}"}};
  std::string used;
  for (const auto& [name, value] : all)
    if (errors.find(fmt::format("'{}' is not used", name)) == std::string::npos)
      used += fmt::format("{}: {}, ", name, value);
  return used;
}

TEST(FormulaMutation, FormulasAreReadOrRefusedAndNeverGiveNonsense) {
  int plans = 0;
  int outputs = 0;
  int refused = 0;
  for (unsigned seed = 1; seed <= 5000; ++seed) {
    std::mt19937 random(seed);
    const std::string formula = mutated(random);
    SCOPED_TRACE(fmt::format("seed {}: {}", seed, formula));
    const std::string quoted = escaped(formula);
    const test::FormulaGraph read = test::read_expression(
        used_quantities(""), fmt::format("q: {{unit: m, formula: \"{}\"}}", quoted));
    // Most mutants leave some quantity unused, which is an error of its own, and no more.
    const bool sound = read.errors.find("formula of 'q'") == std::string::npos;
    ASSERT_EQ(read.plan.has_value(), read.errors.empty());
    refused += sound ? 0 : 1;
    if (!sound) continue;
    ++plans;
    const std::string quantities = used_quantities(read.errors);
    const test::Evaluated evaluated(
        test::read_expression(quantities, fmt::format("q: {{unit: m, formula: \"{}\"}}", quoted)));
    if (evaluated.state().outcome.is_fault()) {
      EXPECT_EQ(evaluated.state().outcome.fault().kind, FaultKind::not_finite);
      continue;
    }
    ++outputs;
    EXPECT_TRUE(std::isfinite(evaluated.value()));
    EXPECT_TRUE(std::isfinite(evaluated.estimate().lineage.variance(0)));
  }
  // Mutants of both kinds must have been tried.
  EXPECT_GT(plans, 100);
  EXPECT_GT(outputs, 50);
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace ilss
