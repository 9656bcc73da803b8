#include "framework/module/command_declaration.h"

#include <fmt/format.h>

#include <algorithm>

namespace ilss {
namespace {

using Kind = ParameterDeclaration::Kind;

CommandDeclaration command_of(Kind kind, std::string name, std::string documentation) {
  CommandDeclaration command;
  command.value.name = name;
  command.value.kind = kind;
  command.value.required = true;
  command.name = std::move(name);
  command.documentation = std::move(documentation);
  return command;
}

bool is_one_value(Kind kind) {
  return kind == Kind::quantity || kind == Kind::number || kind == Kind::integer ||
         kind == Kind::boolean || kind == Kind::text || kind == Kind::choice;
}

}  // namespace

CommandDeclaration quantity_command(std::string name, std::string si_unit,
                                    std::string documentation) {
  CommandDeclaration command =
      command_of(Kind::quantity, std::move(name), std::move(documentation));
  command.value.unit = std::move(si_unit);
  return command;
}

CommandDeclaration number_command(std::string name, std::string documentation) {
  return command_of(Kind::number, std::move(name), std::move(documentation));
}

CommandDeclaration integer_command(std::string name, std::string documentation) {
  return command_of(Kind::integer, std::move(name), std::move(documentation));
}

CommandDeclaration boolean_command(std::string name, std::string documentation) {
  return command_of(Kind::boolean, std::move(name), std::move(documentation));
}

CommandDeclaration text_command(std::string name, std::string documentation) {
  return command_of(Kind::text, std::move(name), std::move(documentation));
}

CommandDeclaration choice_command(std::string name, std::vector<std::string> choices,
                                  std::string documentation) {
  CommandDeclaration command = command_of(Kind::choice, std::move(name), std::move(documentation));
  command.value.choices = std::move(choices);
  return command;
}

bool can_name_command(std::string_view name) {
  return !name.empty() && name.find_first_of(". /$=@") == std::string_view::npos;
}

std::string mistake_in(const std::vector<CommandDeclaration>& commands) {
  for (auto command = commands.begin(); command != commands.end(); ++command) {
    if (!can_name_command(command->name))
      return fmt::format("'{}' cannot name a command", command->name);
    if (std::any_of(commands.begin(), command, [&](const CommandDeclaration& earlier) {
          return earlier.name == command->name;
        }))
      return fmt::format("command '{}' is declared twice", command->name);
    const ParameterDeclaration& value = command->value;
    if (!is_one_value(value.kind))
      return fmt::format("command '{}' cannot take a {}", command->name, kind_name(value.kind));
    if (value.kind == Kind::quantity && value.unit.empty())
      return fmt::format("command '{}' takes a quantity without a unit", command->name);
  }
  return {};
}

}  // namespace ilss
