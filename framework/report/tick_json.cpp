#include "framework/report/tick_json.h"

#include "framework/report/command_json.h"

namespace ilss {
namespace {

/// Adds what a module came to, but for its output.
void add_outcome(const CharacteristicOutput& output, Json& json) {
  json["outcome"] = outcome_name(output.outcome);
  if (output.outcome.is_fault())
    json["fault"] = fault_json(output.outcome.fault(), output.origin->name);
}

Json module_json(const CharacteristicOutput& output) {
  Json json = {{"outcome", outcome_name(output.outcome)},
               {"compute_ns", output.compute_time.count()},
               {"age_ns", nullptr},
               {"acquired_ns", nullptr}};
  if (const auto age = output.age()) json["age_ns"] = age->count();
  if (const auto acquired = output.acquired())
    json["acquired_ns"] = {acquired->oldest.time_since_epoch().count(),
                           acquired->newest.time_since_epoch().count()};
  add_outcome(output, json);
  return json;
}

}  // namespace

Json tick_json(const TickView& tick) {
  Json json = {{"tick", tick.tick()}, {"time", seconds(tick.time())}};
  add_outcome(tick.deciding_output(), json);
  json["output"] = outputs_json(tick);
  Json modules = Json::object();
  for (std::size_t i = 0; i < tick.size(); ++i)
    modules[tick.plan().nodes[i].name] = module_json(tick[i]);
  json["modules"] = std::move(modules);
  for (const GivenCommand& given : tick.commands())
    json["commands"].push_back(given_command_json(given, tick.plan()));
  return json;
}

}  // namespace ilss
