#include "framework/runtime/commander.h"

#include <algorithm>

namespace ilss {

Commander::Commander(const Plan& plan) : plan_(&plan) {
  for (std::size_t i = 0; i < plan.commands.size(); ++i) {
    const PlanCommand& command = plan.commands[i];
    if (command.driver)
      drives_.push_back({i, *command.driver, {.name = command.declaration->name, .value = {}}});
  }
  given_.reserve(drives_.size());
}

void Commander::schedule(ScheduledCommand command) {
  scheduled_.erase(scheduled_.begin(), scheduled_.begin() + static_cast<std::ptrdiff_t>(next_));
  next_ = 0;
  const auto place =
      std::upper_bound(scheduled_.begin(), scheduled_.end(), command.time,
                       [](Time time, const ScheduledCommand& later) { return time < later.time; });
  scheduled_.insert(place, std::move(command));
}

void Commander::give_due(System& system, Time time) {
  given_.clear();
  give_driven(system);
  for (; next_ < scheduled_.size() && scheduled_[next_].time <= time; ++next_) {
    ScheduledCommand& due = scheduled_[next_];
    give_instruction(system, due.command,
                     {.name = plan_->commands[due.command].declaration->name,
                      .value = std::move(due.value),
                      .time = std::min(std::max(due.time, last_tick_), time)});
  }
}

void Commander::give_driven(System& system) {
  for (Drive& drive : drives_) {
    const NodeState& driver = system.node(drive.from.node);
    if (!driver.fresh) continue;
    drive.instruction.time = last_tick_;
    drive.instruction.value = driver.output().estimate.value[drive.from.component];
    give_instruction(system, drive.command, drive.instruction);
  }
}

void Commander::give_instruction(System& system, std::size_t command, const Command& instruction) {
  Outcome<> outcome = system.command(plan_->commands[command].node, instruction);
  if (outcome.is_fault()) ++refused_;
  given_.push_back({command, instruction.value, std::move(outcome)});
}

}  // namespace ilss
