// Commands as people read them: what systems declare, what came of them.
#pragma once

#include <string>

#include "framework/runtime/commander.h"

namespace ilss {

/// "look_at -> head.rotate_to, an angle (rad), driven by tracker.bearing"
std::string command_text(const PlanCommand& command, const Plan& plan);

/// "command look_at = 30 deg", and ": refused: reason" where it was not done.
std::string given_command_text(const GivenCommand& given, const Plan& plan);

}  // namespace ilss
