#include "framework/graph/commands.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/estimate/dimension.h"
#include "framework/estimate/units.h"

namespace ilss {
namespace {

/// "head" of "head.rotate_to".
std::string first_part(const std::string& path) { return path.substr(0, path.find('.')); }

/// "rotate_to" of "head.rotate_to"; empty where there is no dot.
std::string after_first_part(const std::string& path) {
  const std::size_t dot = path.find('.');
  return dot == std::string::npos ? "" : path.substr(dot + 1);
}

/// "; it has rotate_to, rotate_at; did you mean 'rotate_to'?"
std::string choice_text(const std::string& name, const std::vector<std::string>& names) {
  return fmt::format("; it has {}{}", fmt::join(names, ", "), suggestion(name, names));
}

std::vector<std::string> component_names(const PayloadDescriptor& payload) {
  std::vector<std::string> names;
  for (const Component& component : payload.components) names.push_back(component.name);
  return names;
}

}  // namespace

void CommandReader::read(const Node& commands, const std::string& prefix, const Scope& scope) {
  if (!commands.is_map())
    return diagnostics_.add(
        commands.position,
        "expected a map of names to modules' commands, got " + commands.description());
  for (std::size_t i = 0; i < commands.size(); ++i)
    read_command(commands.keys[i], commands.values[i], prefix, scope);
}

void CommandReader::read_command(const Node& key, const Node& value, const std::string& prefix,
                                 const Scope& scope) {
  if (!can_name_command(key.text))
    diagnostics_.add(key.position,
                     fmt::format("'{}' cannot name a command: names have no dots, spaces, slashes, "
                                 "$, = or @",
                                 key.text));
  const Node* to = &value;
  const Node* from = nullptr;
  if (value.is_map()) {
    to = value.find("to");
    from = value.find("from");
    for (const Node& k : value.keys)
      if (k.text != "to" && k.text != "from")
        diagnostics_.add(k.position, fmt::format("a command has no key '{}'{}", k.text,
                                                 suggestion(k.text, {"to", "from"})));
  }
  PlanCommand command{.name = prefix + key.text, .node = unknown_node};
  if (to == nullptr)
    diagnostics_.add(value.position,
                     fmt::format("command '{}' needs to: MODULE.COMMAND", key.text));
  else if (!to->is_scalar())
    diagnostics_.add(to->is_null() ? key.position : to->position,
                     "expected MODULE.COMMAND, or {to: MODULE.COMMAND, from: MODULE.COMPONENT}, "
                     "got " +
                         to->description());
  else
    find_target(*to, prefix, scope, command);
  commands_.push_back(std::move(command));
  if (from == nullptr) return;
  if (!from->is_scalar())
    diagnostics_.add(from->is_null() ? value.position : from->position,
                     "expected from: MODULE.COMPONENT, got " + from->description());
  else
    find_driver(*from, prefix, scope);
}

const Instance* CommandReader::find_instance(const Node& path, const Scope& scope) {
  const std::string module = first_part(path.text);
  const auto found = scope.find(module);
  if (found != scope.end()) return &found->second;
  std::vector<std::string> names;
  for (const auto& [name, instance] : scope) names.push_back(name);
  diagnostics_.add(path.position,
                   fmt::format("there is no module '{}'{}", module, suggestion(module, names)));
  return nullptr;
}

void CommandReader::find_target(const Node& to, const std::string& prefix, const Scope& scope,
                                PlanCommand& command) {
  const Instance* instance = find_instance(to, scope);
  if (instance == nullptr) return;
  if (instance->nested) {
    if (instance->counted) find_target_in_system(to, prefix, command);
    return;
  }
  if (instance->outputs.front() == unknown_node) return;
  const PlanNode& node = nodes_[instance->outputs.front()];
  const std::string module = fmt::format("'{}' ({})", first_part(to.text), node.type->name);
  const std::string name = after_first_part(to.text);
  std::vector<std::string> names;
  for (const CommandDeclaration& declared : node.type->commands) {
    names.push_back(declared.name);
    if (declared.name != name) continue;
    command.node = instance->outputs.front();
    command.declaration = &declared;
    return;
  }
  if (names.empty())
    diagnostics_.add(to.position, module + " follows no commands");
  else if (name.empty())
    diagnostics_.add(to.position, fmt::format("expected MODULE.COMMAND, got '{}'; {} has {}",
                                              to.text, module, fmt::join(names, ", ")));
  else
    diagnostics_.add(to.position, fmt::format("{} has no command '{}'{}", module, name,
                                              choice_text(name, names)));
}

/// A nested system's commands are named after it: "inner.look_at".
void CommandReader::find_target_in_system(const Node& to, const std::string& prefix,
                                          PlanCommand& command) {
  const std::string system = prefix + first_part(to.text) + ".";
  const std::string name = after_first_part(to.text);
  std::vector<std::string> names;
  for (const PlanCommand& inner : commands_) {
    if (!inner.name.starts_with(system)) continue;
    names.push_back(inner.name.substr(system.size()));
    if (names.back() != name) continue;
    command.node = inner.node;
    command.declaration = inner.declaration;
    return;
  }
  const std::string named = first_part(to.text);
  if (names.empty())
    diagnostics_.add(to.position, fmt::format("the system '{}' has no commands", named));
  else
    diagnostics_.add(to.position, fmt::format("the system '{}' has no command '{}'{}", named, name,
                                              choice_text(name, names)));
}

void CommandReader::find_driver(const Node& from, const std::string& prefix, const Scope& scope) {
  const Instance* instance = find_instance(from, scope);
  if (instance == nullptr) return;
  if (instance->nested) return find_driver_in_system(from, prefix, *instance);
  if (instance->outputs.front() != unknown_node)
    drivers_.push_back({commands_.size() - 1, instance->outputs.front(),
                        after_first_part(from.text), from.position});
}

/// One of the system's modules by its name from outside, "inner.tracker.angle", or the system's
/// only output: "inner.angle".
void CommandReader::find_driver_in_system(const Node& from, const std::string& prefix,
                                          const Instance& system) {
  const std::string path = prefix + from.text;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const std::string& name = nodes_[i].name;
    if (!path.starts_with(name)) continue;
    if (path.size() != name.size() && path[name.size()] != '.') continue;
    const std::string component = path.size() == name.size() ? "" : path.substr(name.size() + 1);
    drivers_.push_back({commands_.size() - 1, i, component, from.position});
    return;
  }
  if (!system.counted) return;
  if (system.outputs.size() != 1)
    diagnostics_.add(from.position,
                     fmt::format("the system '{0}' has {1} outputs; expected {0}.MODULE.COMPONENT",
                                 first_part(from.text), system.outputs.size()));
  else if (system.outputs.front() != unknown_node)
    drivers_.push_back(
        {commands_.size() - 1, system.outputs.front(), after_first_part(from.text), from.position});
}

void CommandReader::check_drivers() {
  for (std::size_t i = 0; i < drivers_.size(); ++i) {
    const Driver& driver = drivers_[i];
    const PayloadDescriptor* payload = nodes_[driver.node].interface.output;
    if (payload != nullptr && payload != &any_payload())
      if (const auto component = find_component(driver)) check_fit(driver, *component);
    check_driven_once(i);
  }
}

std::optional<std::size_t> CommandReader::find_component(const Driver& driver) {
  const PlanNode& node = nodes_[driver.node];
  const PayloadDescriptor& payload = *node.interface.output;
  const bool only = driver.component.empty() && payload.dimension() == 1;
  if (const auto found = only ? 0 : payload.find(driver.component)) return found;
  if (payload.components.empty())
    diagnostics_.add(driver.position, fmt::format("'{}' gives {}, which has no components",
                                                  node.name, payload.name));
  else if (driver.component.empty())
    diagnostics_.add(
        driver.position,
        fmt::format("expected MODULE.COMPONENT, got '{}', which gives {}; it has {}", node.name,
                    payload.name, fmt::join(component_names(payload), ", ")));
  else
    diagnostics_.add(
        driver.position,
        fmt::format("'{}' gives {}, which has no component '{}'{}", node.name, payload.name,
                    driver.component, choice_text(driver.component, component_names(payload))));
  return std::nullopt;
}

void CommandReader::check_fit(const Driver& driver, std::size_t component) {
  using Kind = ParameterDeclaration::Kind;
  PlanCommand& command = commands_[driver.command];
  if (command.declaration == nullptr) return;
  const ParameterDeclaration& value = command.declaration->value;
  if (value.kind != Kind::quantity && value.kind != Kind::number)
    return diagnostics_.add(driver.position,
                            fmt::format("only a quantity or number can be driven; '{}' takes a {}",
                                        command.declaration->name, kind_name(value.kind)));
  const std::string unit = value.kind == Kind::number ? "1" : value.unit;
  const PlanNode& node = nodes_[driver.node];
  const Component& given = node.interface.output->components[component];
  if (Dimension::of(given.unit) != Dimension::of(unit))
    return diagnostics_.add(
        driver.position,
        fmt::format("'{}' of '{}' is {}, but '{}' takes {}", given.name, node.name,
                    dimension_name(given.unit), command.declaration->name, dimension_name(unit)));
  command.driver = {driver.node, component};
}

void CommandReader::check_driven_once(std::size_t driver) {
  const PlanCommand& command = commands_[drivers_[driver].command];
  if (command.declaration == nullptr) return;
  for (std::size_t i = 0; i < driver; ++i) {
    const PlanCommand& other = commands_[drivers_[i].command];
    if (other.node != command.node || other.declaration != command.declaration) continue;
    return diagnostics_.add(
        drivers_[driver].position,
        fmt::format("'{}.{}' is driven already, by the command '{}'", nodes_[command.node].name,
                    command.declaration->name, other.name));
  }
}

std::vector<PlanCommand> CommandReader::finish(const std::vector<std::size_t>& place) {
  for (PlanCommand& command : commands_) {
    command.node = place[command.node];
    if (command.driver) command.driver->node = place[command.driver->node];
  }
  return std::move(commands_);
}

}  // namespace ilss
