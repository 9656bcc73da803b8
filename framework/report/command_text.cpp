#include "framework/report/command_text.h"

#include <fmt/format.h>

#include "framework/report/estimate_text.h"

namespace ilss {
namespace {

std::string value_text(const CommandValue& value, const std::string& si_unit) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  if (const auto* number = std::get_if<double>(&value)) {
    const auto [unit, factor] = reading_unit(si_unit.empty() ? "1" : si_unit);
    return fmt::format("{:.6g}{}{}", *number * factor, unit.empty() ? "" : " ", unit);
  }
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return fmt::format("{}", *whole);
  return "null";
}

}  // namespace

std::string command_text(const PlanCommand& command, const Plan& plan) {
  std::string text = fmt::format("{} -> {}.{}, {}", command.name, plan.nodes[command.node].name,
                                 command.declaration->name, expectation(*command.declaration));
  if (command.driver) {
    const PlanNode& from = plan.nodes[command.driver->node];
    text += fmt::format(", driven by {}.{}", from.name,
                        from.interface.output->components[command.driver->component].name);
  }
  return text;
}

std::string given_command_text(const GivenCommand& given, const Plan& plan) {
  const PlanCommand& command = plan.commands[given.command];
  std::string text = fmt::format("command {} = {}", command.name,
                                 value_text(given.value, command.declaration->value.unit));
  if (given.outcome.is_fault())
    text += fmt::format(": {}: {}", fault_name(given.outcome.fault().kind),
                        given.outcome.fault().message);
  return text;
}

}  // namespace ilss
