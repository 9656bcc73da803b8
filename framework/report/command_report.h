// Commands as people and programs read them: what modules and systems declare, what came of them.
#pragma once

#include <string>

#include "framework/report/estimate_json.h"
#include "framework/runtime/commander.h"

namespace ilss {

/// What is declared of a command: name, type, unit, choices, documentation.
Json command_json(const CommandDeclaration& declaration);

/// A system's command: the module and command that it is, and what drives it.
Json command_json(const PlanCommand& command, const Plan& plan);

/// "look_at -> head.rotate_to, an angle (rad), driven by tracker.bearing"
std::string command_text(const PlanCommand& command, const Plan& plan);

/// What came of a command: {name, value, unit?, outcome, fault?}; the outcome is "done" or
/// "refused".
Json given_command_json(const GivenCommand& given, const Plan& plan);

/// "command look_at = 30 deg", and ": refused: reason" where it was not done.
std::string given_command_text(const GivenCommand& given, const Plan& plan);

}  // namespace ilss
