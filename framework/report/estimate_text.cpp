#include "framework/report/estimate_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "framework/estimate/budget.h"

namespace ilss {
namespace {

constexpr double least_shown = 1e-6;
constexpr double most_shown = 1e9;

/// A variance's share in percent; "-" where there is no variance to share.
std::string share_text(double part, double whole) {
  return whole > 0 ? fmt::format("{:.1f} %", 100 * part / whole) : "-";
}

std::vector<std::string> names_of(const Plan& plan, const std::vector<std::size_t>& nodes) {
  std::vector<std::string> names;
  names.reserve(nodes.size());
  for (const std::size_t node : nodes) names.push_back(plan.nodes[node].name);
  return names;
}

std::string correlations_text(const Estimate& estimate) {
  const Eigen::MatrixXd covariance = estimate.lineage.covariance();
  std::string text;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i)
    for (Eigen::Index j = i + 1; j < covariance.cols(); ++j) {
      const double scale = std::sqrt(covariance(i, i) * covariance(j, j));
      constexpr double least_shown_correlation = 0.005;
      if (scale <= 0 || std::abs(covariance(i, j)) < least_shown_correlation * scale) continue;
      const auto& components = estimate.type->components;
      text += fmt::format("{}{},{} {:+.2f}", text.empty() ? "  correlation  " : "   ",
                          components[static_cast<std::size_t>(i)].name,
                          components[static_cast<std::size_t>(j)].name, covariance(i, j) / scale);
    }
  if (!text.empty()) text += "\n";
  if (estimate.correlation_unknown) text += "  correlation  with other estimates unknown\n";
  return text;
}

std::string heading_text(const Estimate& estimate) {
  return estimate.type->name + (estimate.frame.empty() ? "" : " in frame " + estimate.frame);
}

std::string labels_text(const Estimate& estimate) {
  std::string text;
  for (std::size_t i = 0; i < estimate.type->labels.size(); ++i) {
    const Label& label = estimate.type->labels[i];
    text += fmt::format("  {:<12} {}\n", label.name,
                        label.values[static_cast<std::size_t>(estimate.labels[i])]);
  }
  return text;
}

}  // namespace

ReadingUnit reading_unit(const std::string& si_unit) {
  if (si_unit == "m") return {"mm", 1e3};
  if (si_unit == "rad") return {"deg", 180 / std::numbers::pi};
  if (si_unit == "1") return {"", 1};
  return {si_unit, 1};
}

std::string decimal_text(double value, int places) {
  std::string number = fmt::format("{:.{}f}", value, places);
  if (number.starts_with('-') && number.find_first_not_of("-0.") == std::string::npos)
    number.erase(0, 1);
  return number;
}

int decimal_places(double standard_deviation) {
  if (standard_deviation <= 0) return 3;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(standard_deviation))), 0, 12);
}

std::string quantity_text(double value, const std::string& si_unit) {
  const auto [unit, factor] = reading_unit(si_unit);
  return fmt::format("{:.3g}{}{}", value * factor, unit.empty() ? "" : " ", unit);
}

std::string quantity_text(double value, double standard_deviation, const std::string& si_unit) {
  const auto [unit, factor] = reading_unit(si_unit);
  // The value to the same place as its standard deviation.
  const double shown = standard_deviation * factor;
  const int digits = decimal_places(shown);
  const double size = std::max(std::abs(value * factor), shown);
  // Numbers too small or large for places after the point: (5.00 ± 0.10)e-12.
  if (size > 0 &&
      ((shown > 0 && shown < least_shown) || size < least_shown || size >= most_shown)) {
    const double power = std::floor(std::log10(size));
    const double scale = std::pow(10.0, -power);
    const int places = decimal_places(shown * scale);
    return fmt::format("({} ± {:.{}f})e{:+03d}{}{}", decimal_text(value * factor * scale, places),
                       shown * scale, places, static_cast<int>(power), unit.empty() ? "" : " ",
                       unit);
  }
  return fmt::format("{} ± {:.{}f}{}{}", decimal_text(value * factor, digits), shown, digits,
                     unit.empty() ? "" : " ", unit);
}

double corrected_deviation(const Estimate& estimate, const VerdictReport& verdict,
                           std::size_t component) {
  return std::sqrt(
      std::max(0.0, estimate.lineage.variance(component) + verdict.extra_variance[component]));
}

bool has_parts(const PayloadDescriptor& payload) {
  return !payload.element.empty() || payload.samples.has_value();
}

std::string exact_or_quantity_text(const Estimate& estimate, std::size_t component) {
  const std::string& unit = estimate.type->components[component].unit;
  const double deviation = estimate.lineage.standard_deviation(component);
  if (deviation > 0) return quantity_text(estimate.value[component], deviation, unit);
  const ReadingUnit reading = reading_unit(unit);
  return fmt::format("{:.6g}{}{}", estimate.value[component] * reading.factor,
                     reading.name.empty() ? "" : " ", reading.name);
}

std::string estimate_text(const Estimate& estimate, const VerdictReport& verdict) {
  std::string text = heading_text(estimate);
  text += fmt::format(", {}{}{}\n", verdict_name(verdict.verdict),
                      verdict.reason.empty() ? "" : ": ", verdict.reason);
  const bool plain_if_exact = has_parts(*estimate.type);
  for (std::size_t i = 0; i < estimate.dimension(); ++i) {
    const Component& component = estimate.type->components[i];
    text += fmt::format(
        "  {:<12} {}", component.name,
        plain_if_exact ? exact_or_quantity_text(estimate, i)
                       : quantity_text(estimate.value[i], estimate.lineage.standard_deviation(i),
                                       component.unit));
    if (i < verdict.components.size() && verdict.components[i] != Verdict::linear_ok)
      text += fmt::format("   ({}{} {})", verdict_name(verdict.components[i]),
                          verdict.components[i] == Verdict::second_order ? ":" : ": second order",
                          quantity_text(estimate.value[i] + verdict.bias[i],
                                        corrected_deviation(estimate, verdict, i), component.unit));
    text += "\n";
  }
  return text + labels_text(estimate) + correlations_text(estimate);
}

std::string element_text(const Estimate& element) {
  std::string text = heading_text(element) + "\n";
  for (std::size_t i = 0; i < element.dimension(); ++i)
    text += fmt::format("  {:<12} {}\n", element.type->components[i].name,
                        exact_or_quantity_text(element, i));
  return text + labels_text(element) + correlations_text(element);
}

std::string budget_text(const Estimate& estimate, const SourceOwners& owners) {
  std::vector<BudgetEntry> entries = budget(estimate.lineage);
  std::erase_if(entries, [](const BudgetEntry& entry) {
    return std::all_of(entry.variance.begin(), entry.variance.end(),
                       [](double variance) { return variance == 0; });
  });
  if (entries.empty()) return {};
  const auto largest_share = [&](const BudgetEntry& entry) {
    double share = 0;
    for (std::size_t i = 0; i < entry.variance.size(); ++i) {
      const double variance = estimate.lineage.variance(i);
      if (variance > 0) share = std::max(share, entry.variance[i] / variance);
    }
    return share;
  };
  std::stable_sort(entries.begin(), entries.end(), [&](const auto& a, const auto& b) {
    return largest_share(a) > largest_share(b);
  });
  std::size_t width = 6;
  for (const BudgetEntry& entry : entries) width = std::max(width, owners[entry.owner].name.size());
  std::string text = fmt::format("  {:<{}}  {:<10}", "source", width, "kind");
  for (const Component& component : estimate.type->components)
    text += fmt::format(" {:>10}", component.name);
  text += "\n";
  for (const BudgetEntry& entry : entries) {
    text += fmt::format("  {:<{}}  {:<10}", owners[entry.owner].name, width,
                        entry.persistent ? "systematic" : "random");
    for (std::size_t i = 0; i < entry.variance.size(); ++i)
      text += fmt::format(" {:>10}", share_text(entry.variance[i], estimate.lineage.variance(i)));
    text += "\n";
  }
  return text;
}

std::string duration_text(double seconds) {
  if (seconds >= 1) return fmt::format("{:.3g} s", seconds);
  if (seconds >= 1e-3) return fmt::format("{:.3g} ms", seconds * 1e3);
  if (seconds >= 1e-6) return fmt::format("{:.3g} us", seconds * 1e6);
  return fmt::format("{:.3g} ns", seconds * 1e9);
}

std::string time_text(const TimePrediction& time, const Plan& plan) {
  if (time.unknown.size() == plan.nodes.size())
    return "time         unknown: no module declares one; see time: in graphs, or --profile\n";
  std::string text = fmt::format("time         typical {}, worst {}\n", duration_text(time.typical),
                                 duration_text(time.worst));
  text += fmt::format("  path       {}\n", fmt::join(names_of(plan, time.critical_path), " -> "));
  if (!time.unknown.empty())
    text += fmt::format("  not known  {} (taken as 0)\n",
                        fmt::join(names_of(plan, time.unknown), ", "));
  return text;
}

}  // namespace ilss
