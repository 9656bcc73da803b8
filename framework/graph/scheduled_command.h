// Commands from outside: a value for one of a plan's commands, and when to give it.
#pragma once

#include <optional>
#include <string>

#include "framework/graph/plan.h"

namespace ilss {

/// A command to be given before the first tick whose time is not before `time`.
struct ScheduledCommand {
  std::size_t command = 0;  ///< which of the plan's
  CommandValue value;       ///< of the declared kind
  Time time = {};
};

/// A command's value as users write it, in YAML: checked against what is declared, in SI. What is
/// wrong goes to `diagnostics`.
std::optional<CommandValue> read_command_value(const CommandDeclaration& declaration,
                                               const Node& value, Diagnostics& diagnostics);

/// Reads "NAME=VALUE" or "NAME=VALUE@TIME" as users write it on a command line: split at the first
/// '=' and the last '@'; without a time it is 0. `origin` is what to call it in messages.
std::optional<ScheduledCommand> parse_command(const std::string& text, const Plan& plan,
                                              const std::string& origin, Diagnostics& diagnostics);

/// What a command takes, for people: "an angle (rad)", "one of near, far", "true or false".
std::string expectation(const CommandDeclaration& declaration);

}  // namespace ilss
