#include "framework/report/set_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "framework/report/estimate_text.h"

namespace ilss {

std::string component_line(const Estimate& estimate) {
  std::string text;
  for (std::size_t i = 0; i < estimate.dimension(); ++i)
    text += fmt::format("{}{} {}", i == 0 ? "" : "  ", estimate.type->components[i].name,
                        exact_or_quantity_text(estimate, i));
  for (std::size_t i = 0; i < estimate.type->labels.size(); ++i) {
    const Label& label = estimate.type->labels[i];
    text += fmt::format("  {} {}", label.name,
                        label.values[static_cast<std::size_t>(estimate.labels[i])]);
  }
  return text;
}

std::string samples_text(const Output& output) {
  const auto& samples = output.estimate.type->samples;
  if (!samples || output.samples.shape.size() != samples->axes.size()) return "";
  std::string text;
  for (std::size_t axis = 0; axis < samples->axes.size(); ++axis) {
    const std::string& name = samples->axes[axis];
    const std::size_t size = output.samples.shape[axis];
    text += fmt::format("{}{} {}{}", text.empty() ? "" : " x ", size, name, size == 1 ? "" : "s");
  }
  return text;
}

std::string element_counts_text(std::span<const Estimate> elements) {
  SetSummary summary;
  summary.add(elements);
  std::string text;
  for (const SetSummary::Entry& entry : summary.entries())
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", entry.count, entry.type->name);
  return text.empty() ? "no elements" : text;
}

std::string elements_text(std::span<const Estimate> elements, const std::string& indent) {
  if (elements.size() > largest_shown_set)
    return fmt::format("{}{}\n", indent, element_counts_text(elements));
  const auto shown = elements.first(std::min(elements.size(), most_elements_shown));
  std::size_t width = 0;
  for (const Estimate& element : shown) width = std::max(width, element.type->name.size());
  std::string text;
  for (const Estimate& element : shown)
    text +=
        fmt::format("{}{:<{}}  {}\n", indent, element.type->name, width, component_line(element));
  const auto rest = elements.subspan(shown.size());
  if (!rest.empty())
    text += fmt::format("{}... and {} more: {}\n", indent, rest.size(), element_counts_text(rest));
  return text;
}

std::string parts_text(const Output& output, const std::string& name, const SourceOwners& owners) {
  std::string text;
  if (const std::string samples = samples_text(output); !samples.empty())
    text += fmt::format("  {:<12} {}\n", "samples", samples);
  if (output.estimate.type->element.empty()) return text;
  const std::span<const Estimate> elements = output.elements;
  text += fmt::format("  {:<12} {}\n", "elements", element_counts_text(elements));
  if (elements.size() > largest_shown_set) return text;
  const std::size_t shown = std::min(elements.size(), most_elements_shown);
  for (std::size_t i = 0; i < shown; ++i) {
    text += fmt::format("\n{} {}: {}", name, i + 1, element_text(elements[i]));
    const std::string shares = budget_text(elements[i], owners);
    if (!shares.empty()) text += "share of the variance\n" + shares;
  }
  if (shown < elements.size())
    text += fmt::format("\n... and {} more: {}\n", elements.size() - shown,
                        element_counts_text(elements.subspan(shown)));
  return text;
}

void SetSummary::add(std::span<const Estimate> elements) {
  for (const Estimate& element : elements) {
    auto entry = std::find_if(entries_.begin(), entries_.end(),
                              [&](const Entry& e) { return e.type->name == element.type->name; });
    if (entry == entries_.end()) {
      entries_.push_back({element.type});
      entries_.back().variance_sum.resize(element.dimension(), 0.0);
      entry = entries_.end() - 1;
    }
    ++entry->count;
    for (std::size_t i = 0; i < element.dimension(); ++i)
      entry->variance_sum[i] += element.lineage.variance(i);
  }
}

std::string summary_text(const SetSummary::Entry& entry, std::uint64_t ticks) {
  const auto count = static_cast<double>(entry.count);
  std::string text = fmt::format("{:.3g} a tick", count / static_cast<double>(ticks));
  const char* separator = ": ";
  for (std::size_t i = 0; i < entry.variance_sum.size(); ++i) {
    if (entry.variance_sum[i] <= 0) continue;
    const Component& component = entry.type->components[i];
    text += fmt::format("{}{} {}", separator, component.name,
                        quantity_text(std::sqrt(entry.variance_sum[i] / count), component.unit));
    separator = ", ";
  }
  return text;
}

}  // namespace ilss
