#include "framework/report/prediction_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "framework/estimate/budget.h"
#include "framework/report/estimate_text.h"
#include "framework/report/text_table.h"

namespace ilss {
namespace {

/// A share that is what rounding leaves where errors cancel.
constexpr double rounding = 1e-12;

/// A number to as many places as its standard deviation has two digits.
std::string to_places_of(double value, double standard_deviation) {
  return decimal_text(value, decimal_places(standard_deviation));
}

std::string percent(double share) {
  return std::isnan(share) ? "-" : fmt::format("{:.1f} %", 100 * share);
}

std::string budget_table_text(const std::vector<BudgetEntry>& entries, const SourceOwners& owners,
                              std::size_t component, const std::string& si_unit) {
  const ReadingUnit reading = reading_unit(si_unit);
  const double factor = reading.factor;
  double variance = 0;
  double systematic = 0;
  for (const BudgetEntry& entry : entries) {
    variance += entry.variance[component];
    if (entry.persistent) systematic += entry.variance[component];
  }
  if (variance <= 0) return "";
  std::vector<std::size_t> order(entries.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return entries[a].variance[component] > entries[b].variance[component];
  });
  const std::string in_unit = reading.name.empty() ? "" : "\n" + reading.name;
  TextTable table;
  table.column("source", Align::left);
  table.column("kind", Align::left);
  table.column("std" + in_unit);
  table.column("share");
  table.column("if halved" + in_unit);
  table.column("change");
  for (const std::size_t e : order) {
    const double part = entries[e].variance[component];
    if (part <= rounding * variance) continue;
    const double halved = deviation_if_halved(entries, e, component);
    table.row({owners[entries[e].owner].name, entries[e].persistent ? "systematic" : "random",
               fmt::format("{:.3g}", std::sqrt(part) * factor), percent(part / variance),
               fmt::format("{:.3g}", halved * factor),
               fmt::format("{:+.1f} %", 100 * (halved / std::sqrt(variance) - 1))});
  }
  table.line();
  const auto total = [&](const char* kind, double part) {
    table.row(
        {"all", kind, fmt::format("{:.3g}", std::sqrt(part) * factor), percent(part / variance)});
  };
  if (systematic > 0 && systematic < variance) {
    total("random", variance - systematic);
    total("systematic", systematic);
  }
  total("", variance);
  return table.text();
}

}  // namespace

std::string budget_tables_text(const Estimate& estimate, const SourceOwners& owners) {
  const std::vector<BudgetEntry> entries = budget(estimate.lineage);
  std::string text;
  for (std::size_t c = 0; c < estimate.dimension(); ++c) {
    const Component& component = estimate.type->components[c];
    const std::string table = budget_table_text(entries, owners, c, component.unit);
    if (!table.empty()) text += fmt::format("\nwho is to blame for {}\n{}", component.name, table);
  }
  return text;
}

std::string degrees_of_freedom_text(const Estimate& estimate, const SourceOwners& owners) {
  const std::vector<BudgetEntry> entries = budget(estimate.lineage);
  std::string text;
  for (std::size_t c = 0; c < estimate.dimension(); ++c) {
    const double degrees = effective_degrees_of_freedom(entries, owners, c);
    if (!std::isfinite(degrees)) continue;
    const Component& component = estimate.type->components[c];
    const double factor = coverage_factor(degrees, 0.95);
    text += fmt::format(
        "  95 % of {}: ± {} ({:.2f} std, {:.1f} effective degrees of freedom)\n", component.name,
        quantity_text(factor * estimate.lineage.standard_deviation(c), component.unit), factor,
        degrees);
  }
  return text;
}

std::string monte_carlo_text(const Estimate& estimate, const MonteCarloOutput& result) {
  std::string text;
  if (result.faults > 0)
    text += fmt::format("  {} of {} trials gave no answer: {}\n", result.faults,
                        result.trials + result.faults, result.fault);
  if (result.trials == 0) return text;
  TextTable table;
  table.column("component", Align::left);
  table.column("unit", Align::left);
  table.column("value", Align::right, "first order");
  table.column("std", Align::right, "first order");
  table.column("mean", Align::right, "Monte Carlo");
  table.column("std", Align::right, "Monte Carlo");
  table.column("shortest 95 % interval", Align::right, "Monte Carlo");
  table.column("within\n1.96 std");
  table.column("digits\nagreeing");
  for (std::size_t c = 0; c < estimate.dimension(); ++c) {
    const auto i = static_cast<Eigen::Index>(c);
    const auto [unit, factor] = reading_unit(estimate.type->components[c].unit);
    const double first = estimate.lineage.standard_deviation(c) * factor;
    const double drawn = std::sqrt(result.covariance(i, i)) * factor;
    const auto by_drawn = [&, f = factor](double x) { return to_places_of(x * f, drawn); };
    table.row({estimate.type->components[c].name, unit,
               to_places_of(estimate.value[c] * factor, first > 0 ? first : drawn),
               to_places_of(first, first > 0 ? first : drawn), by_drawn(result.mean[i]),
               to_places_of(drawn, drawn),
               by_drawn(result.interval[c].low) + " .. " + by_drawn(result.interval[c].high),
               percent(result.coverage[c]), std::to_string(result.agreeing_digits[c])});
  }
  text += table.text();
  if (estimate.dimension() > 1 && !std::isnan(result.joint_coverage))
    text += fmt::format("  within the 95 % ellipsoid of the first-order covariance: {}\n",
                        percent(result.joint_coverage));
  return text;
}

}  // namespace ilss
