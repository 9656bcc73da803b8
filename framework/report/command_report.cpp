#include "framework/report/command_report.h"

#include <fmt/format.h>

#include "framework/report/estimate_text.h"

namespace ilss {
namespace {

Json value_json(const CommandValue& value) {
  return std::visit(
      [](const auto& held) -> Json {
        if constexpr (std::is_same_v<std::decay_t<decltype(held)>, std::monostate>)
          return nullptr;
        else
          return held;
      },
      value);
}

std::string value_text(const CommandValue& value, const std::string& si_unit) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  if (const auto* number = std::get_if<double>(&value)) {
    const auto [unit, factor] = reading_unit(si_unit.empty() ? "1" : si_unit);
    return fmt::format("{:.6g}{}{}", *number * factor, unit.empty() ? "" : " ", unit);
  }
  return value_json(value).dump();
}

}  // namespace

Json command_json(const CommandDeclaration& declaration) {
  Json json = {{"name", declaration.name},
               {"type", kind_name(declaration.value.kind)},
               {"unit", declaration.value.unit}};
  if (!declaration.value.choices.empty()) json["choices"] = declaration.value.choices;
  json["documentation"] = declaration.documentation;
  return json;
}

Json command_json(const PlanCommand& command, const Plan& plan) {
  Json json = command_json(*command.declaration);
  json["name"] = command.name;
  json["module"] = plan.nodes[command.node].name;
  json["command"] = command.declaration->name;
  if (command.driver) {
    const PlanNode& from = plan.nodes[command.driver->node];
    json["from"] = {
        {"module", from.name},
        {"component", from.interface.output->components[command.driver->component].name}};
  }
  return json;
}

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

Json given_command_json(const GivenCommand& given, const Plan& plan) {
  const PlanCommand& command = plan.commands[given.command];
  Json json = {{"name", command.name}, {"value", value_json(given.value)}};
  if (!command.declaration->value.unit.empty()) json["unit"] = command.declaration->value.unit;
  json["outcome"] = given.outcome.is_fault() ? "refused" : "done";
  if (given.outcome.is_fault())
    json["fault"] = fault_json(given.outcome.fault(), plan.nodes[command.node].name);
  return json;
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
