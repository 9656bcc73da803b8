#include "framework/report/command_json.h"

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

Json given_command_json(const GivenCommand& given, const Plan& plan) {
  const PlanCommand& command = plan.commands[given.command];
  Json json = {{"name", command.name}, {"value", value_json(given.value)}};
  if (!command.declaration->value.unit.empty()) json["unit"] = command.declaration->value.unit;
  json["outcome"] = given.outcome.is_fault() ? "refused" : "done";
  if (given.outcome.is_fault())
    json["fault"] = fault_json(given.outcome.fault(), plan.nodes[command.node].name);
  return json;
}

}  // namespace ilss
