#include "framework/graph/scheduled_command.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/estimate/units.h"

namespace ilss {
namespace {

using CommandKind = ParameterDeclaration::Kind;

/// A value of type T, read as an option of it is.
template <typename T>
std::optional<CommandValue> read_as(const CommandDeclaration& declaration, const Node& value,
                                    Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.size();
  const Node map{.kind = Node::Kind::map,
                 .position = value.position,
                 .keys = {{.kind = Node::Kind::scalar, .text = declaration.name}},
                 .values = {value}};
  OptionVisitor visit(&map, ".", diagnostics, value.position);
  T read{};
  visit(declaration.name, read, "", {.unit = declaration.value.unit, .required = true});
  if (diagnostics.size() != errors) return std::nullopt;
  return CommandValue(std::move(read));
}

std::optional<CommandValue> read_choice(const std::vector<std::string>& choices, const Node& value,
                                        Diagnostics& diagnostics) {
  if (value.is_scalar() && std::find(choices.begin(), choices.end(), value.text) != choices.end())
    return CommandValue(value.text);
  diagnostics.add(value.position,
                  fmt::format("expected one of {}, got {}{}", fmt::join(choices, ", "),
                              value.description(), suggestion(value.text, choices)));
  return std::nullopt;
}

/// The plan's command of that name; where there is none, what there is.
std::optional<std::size_t> find_command(const std::string& name, const Plan& plan,
                                        Position position, Diagnostics& diagnostics) {
  std::vector<std::string> names;
  std::vector<std::string> offers;
  for (const PlanCommand& command : plan.commands) {
    if (command.name == name) return names.size();
    names.push_back(command.name);
    offers.push_back(fmt::format("{}, {}", command.name, expectation(*command.declaration)));
  }
  diagnostics.add(position,
                  offers.empty()
                      ? fmt::format("there is no command '{}': the system has no commands", name)
                      : fmt::format("there is no command '{}'{}; the system has {}", name,
                                    suggestion(name, names), fmt::join(offers, "; ")));
  return std::nullopt;
}

std::optional<Time> read_time(const std::string& text, Position position,
                              Diagnostics& diagnostics) {
  const auto time = parse_quantity(text, "s");
  if (const auto* error = std::get_if<std::string>(&time)) {
    diagnostics.add(position, "time: " + *error);
    return std::nullopt;
  }
  if (std::get<double>(time) >= 0) return time_at(std::get<double>(time));
  diagnostics.add(position, "the time of a command cannot be negative");
  return std::nullopt;
}

}  // namespace

std::optional<CommandValue> read_command_value(const CommandDeclaration& declaration,
                                               const Node& value, Diagnostics& diagnostics) {
  if (value.is_null()) {
    diagnostics.add(value.position, fmt::format("expected {}, got nothing",  //
                                                expectation(declaration)));
    return std::nullopt;
  }
  switch (declaration.value.kind) {
    case CommandKind::quantity:
    case CommandKind::number:
      return read_as<double>(declaration, value, diagnostics);
    case CommandKind::integer:
      return read_as<std::int64_t>(declaration, value, diagnostics);
    case CommandKind::boolean:
      return read_as<bool>(declaration, value, diagnostics);
    case CommandKind::choice:
      return read_choice(declaration.value.choices, value, diagnostics);
    default:
      return read_as<std::string>(declaration, value, diagnostics);
  }
}

std::optional<ScheduledCommand> parse_command(const std::string& text, const Plan& plan,
                                              const std::string& origin, Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.size();
  const std::size_t equals = std::min(text.find('='), text.size());
  const std::string name = text.substr(0, equals);
  std::string written = equals == text.size() ? "" : text.substr(equals + 1);
  std::string time_text = "0 s";
  if (const std::size_t at = written.rfind('@'); at != std::string::npos) {
    time_text = written.substr(at + 1);
    written.resize(at);
  }
  Node value = parse_document(written, origin, diagnostics);
  if (diagnostics.size() != errors) return std::nullopt;
  // The text as a whole is shown; a place in it would say little.
  value.position.line = 0;
  if (name.empty() || value.is_null()) {
    diagnostics.add(value.position,
                    fmt::format("expected NAME=VALUE or NAME=VALUE@TIME, got '{}'", text));
    return std::nullopt;
  }
  const auto command = find_command(name, plan, value.position, diagnostics);
  const auto time = read_time(time_text, value.position, diagnostics);
  std::optional<CommandValue> read;
  if (command) read = read_command_value(*plan.commands[*command].declaration, value, diagnostics);
  if (diagnostics.size() != errors) return std::nullopt;
  return ScheduledCommand{*command, std::move(*read), *time};
}

std::string expectation(const CommandDeclaration& declaration) {
  switch (declaration.value.kind) {
    case CommandKind::quantity:
      return dimension_name(declaration.value.unit);
    case CommandKind::integer:
      return "an integer";
    case CommandKind::boolean:
      return "true or false";
    case CommandKind::choice:
      return fmt::format("one of {}", fmt::join(declaration.value.choices, ", "));
    case CommandKind::text:
      return "a text";
    default:
      return "a number";
  }
}

}  // namespace ilss
