#include "framework/report/tick_text.h"

#include <fmt/format.h>

#include "framework/report/command_text.h"
#include "framework/report/estimate_text.h"
#include "framework/report/set_text.h"

namespace ilss {
namespace {

/// The elements of an output that is a set, below its line.
std::string elements_below(const CharacteristicOutput& output, std::size_t indent) {
  if (output.output == nullptr || output.output->estimate.type->element.empty()) return {};
  return elements_text(output.output->elements, std::string(indent, ' '));
}

/// "22 of 24 outputs (3 second_order)".
std::string output_counts_text(const TickView& tick) {
  std::size_t given = 0;
  VerdictCounts counts = {};
  for (std::size_t o = 0; o < tick.outputs(); ++o) {
    const CharacteristicOutput output = tick.output(o);
    if (output.output == nullptr) continue;
    ++given;
    if (output.verdict != nullptr) ++counts[static_cast<std::size_t>(output.verdict->verdict)];
  }
  const std::string not_linear = verdict_counts_text(counts);
  return fmt::format("{} of {} outputs{}", given, tick.outputs(),
                     not_linear.empty() ? "" : fmt::format(" ({})", not_linear));
}

std::string commands_text(const TickView& tick) {
  std::string text;
  for (const GivenCommand& given : tick.commands())
    text += fmt::format("{:>16.3f} s  {}\n", seconds(tick.time()),
                        given_command_text(given, tick.plan()));
  return text;
}

}  // namespace

std::string verdict_counts_text(const VerdictCounts& counts) {
  std::string text;
  for (std::size_t verdict = 0; verdict < counts.size(); ++verdict)
    if (counts[verdict] != 0 && static_cast<Verdict>(verdict) != Verdict::linear_ok)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counts[verdict],
                          verdict_name(static_cast<Verdict>(verdict)));
  return text;
}

std::string output_text(const CharacteristicOutput& output) {
  if (output.outcome.is_fault())
    return fmt::format("{} in {}: {}", fault_name(output.outcome.fault().kind), output.origin->name,
                       output.outcome.fault().message);
  if (output.output == nullptr) return "pending";
  const Estimate& estimate = output.output->estimate;
  std::string text = samples_text(*output.output);
  if (has_parts(*estimate.type)) {
    text += (text.empty() ? "" : "  ") + component_line(estimate);
  } else {
    for (std::size_t i = 0; i < estimate.dimension(); ++i) {
      const Component& component = estimate.type->components[i];
      text += fmt::format(
          "{}{} {}", i == 0 ? "" : " ", component.name,
          quantity_text(estimate.value[i], estimate.lineage.standard_deviation(i), component.unit));
    }
  }
  if (output.verdict != nullptr && output.verdict->verdict != Verdict::linear_ok)
    text += fmt::format("  {} {}", output.verdict->verdict == Verdict::invalid ? '!' : '~',
                        verdict_name(output.verdict->verdict));
  return text;
}

std::string tick_text(const TickView& tick) {
  std::string text = commands_text(tick);
  text += fmt::format("{:>6} {:>9.3f} s", tick.tick(), seconds(tick.time()));
  if (tick.outputs() == 1) {
    const CharacteristicOutput output = tick.output(0);
    return text + fmt::format("  {}\n", output_text(output)) + elements_below(output, 20);
  }
  if (tick.outputs() > most_outputs_shown)
    return text + fmt::format("  {}\n", output_counts_text(tick));
  text += "\n";
  for (std::size_t o = 0; o < tick.outputs(); ++o) {
    const CharacteristicOutput output = tick.output(o);
    text += fmt::format("         {:<20} {}\n", output.module.name, output_text(output));
    text += elements_below(output, 30);
  }
  return text;
}

}  // namespace ilss
