// Commands as JSON: what modules and systems declare, what came of them.
#pragma once

#include "framework/report/estimate_json.h"
#include "framework/runtime/commander.h"

namespace ilss {

/// What is declared of a command: name, type, unit, choices, documentation.
Json command_json(const CommandDeclaration& declaration);

/// A system's command: the module and command that it is, and what drives it.
Json command_json(const PlanCommand& command, const Plan& plan);

/// What came of a command: {name, value, unit?, outcome, fault?}; the outcome is "done" or
/// "refused".
Json given_command_json(const GivenCommand& given, const Plan& plan);

}  // namespace ilss
