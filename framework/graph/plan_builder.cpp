// From a graph's document to a plan: constants, modules and their parameters, nested systems.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "framework/estimate/units.h"
#include "framework/graph/commands.h"
#include "framework/graph/constants.h"
#include "framework/graph/correlation.h"
#include "framework/graph/plan.h"
#include "framework/graph/profile.h"
#include "framework/graph/wiring.h"

namespace ilss {
namespace {

/// An override on its way down to the scope it belongs to. `$names` in it mean the constants of the
/// graph that states it.
struct PlacedOverride {
  std::vector<std::string> path;
  const Override* origin;
  const Constants* constants;
};

std::vector<std::string> split_path(std::string_view text) {
  std::vector<std::string> parts;
  while (true) {
    const std::size_t dot = text.find('.');
    parts.emplace_back(text.substr(0, dot));
    if (dot == std::string_view::npos) return parts;
    text.remove_prefix(dot + 1);
  }
}

/// Puts `value` at `path` below `map`, making maps on the way; `x.std` keeps the value of `x: 11
/// deg`.
void set_value(Node& map, std::span<const std::string> path, const Node& value) {
  if (!map.is_map()) {
    Node made{Node::Kind::map, value.position};
    if (map.is_scalar() && path.size() == 1 && path.front() == "std") {
      made.keys.push_back({Node::Kind::scalar, map.position, false, "value"});
      made.values.push_back(map);
    }
    map = std::move(made);
  }
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    if (map.keys[i].text != path.front()) continue;
    if (path.size() == 1)
      map.values[i] = value;
    else
      set_value(map.values[i], path.subspan(1), value);
    return;
  }
  map.keys.push_back({Node::Kind::scalar, value.position, false, path.front()});
  map.values.emplace_back(path.size() == 1 ? value : Node{Node::Kind::map, value.position});
  if (path.size() > 1) set_value(map.values.back(), path.subspan(1), value);
}

constexpr std::size_t deepest_nesting = 32;
constexpr std::size_t most_systems = 10'000;

std::filesystem::path canonical_path(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path result = std::filesystem::weakly_canonical(path, error);
  return error ? path : result;
}

/// Whether `name` is `path` or one of its members: "mount.x" of "mount".
bool is_at_or_below(std::string_view name, std::string_view path) {
  return name.starts_with(path) && (name.size() == path.size() || name[path.size()] == '.');
}

/// A parameter's value in a module's map, or null: "mount.x" lies in the map `mount`.
const Node* find_parameter(const Node& module, std::string_view name, Diagnostics& diagnostics) {
  const Node* value = &module;
  while (true) {
    const std::size_t dot = name.find('.');
    value = value->find(name.substr(0, dot));
    if (dot == std::string_view::npos || value == nullptr || value->is_null()) return value;
    if (!value->is_map()) {
      diagnostics.add(value->position, "expected a map, got " + value->description());
      return nullptr;
    }
    name.remove_prefix(dot + 1);
  }
}

const PayloadDescriptor& parameters_of(const PlanNode& node) {
  return node.settings.quantities != nullptr ? *node.settings.quantities : *node.type->parameters;
}

/// Whose constants the `$names` in a parameter's value mean: those of the graph that overrides it,
/// or of the graph that the module stands in.
const Constants* constants_of(std::string_view parameter, const Constants& own,
                              const std::map<std::string, const Constants*>& of_overrides) {
  const Constants* names = &own;
  for (const auto& [path, theirs] : of_overrides)
    if (theirs != nullptr && is_at_or_below(parameter, path)) names = theirs;
  return names;
}

class PlanBuilder {
 public:
  PlanBuilder(const Registry& registry, Diagnostics& diagnostics)
      : registry_(registry),
        diagnostics_(diagnostics),
        wiring_(nodes_, registry, diagnostics),
        commands_(nodes_, diagnostics) {}

  std::optional<Plan> build(const Node& graph, const std::filesystem::path& directory,
                            const std::vector<Override>& overrides) {
    const std::size_t errors = diagnostics_.size();
    std::vector<PlacedOverride> placed;
    for (const Override& o : overrides) place(o, nullptr, placed);
    if (graph.position.file != nullptr) open_files_.push_back(canonical_path(*graph.position.file));
    const Instance system = read_system(graph, "", directory, placed);
    const std::vector<std::size_t> order = wiring_.evaluation_order();
    wiring_.check_connections(order);
    commands_.check_drivers();
    if (diagnostics_.size() != errors) return std::nullopt;
    return finish(graph, order, system.outputs);
  }

 private:
  void place(const Override& override, const Constants* constants,
             std::vector<PlacedOverride>& placed);
  Instance read_system(const Node& graph, const std::string& prefix,
                       const std::filesystem::path& directory,
                       const std::vector<PlacedOverride>& overrides);
  void read_constants(const Node* constants_node, const std::string& prefix,
                      const std::filesystem::path& directory,
                      const std::vector<PlacedOverride>& overrides, Constants& constants);
  Instance read_module(const Node& key, Node module, const std::string& prefix,
                       const std::filesystem::path& directory, const Constants& constants,
                       const std::vector<PlacedOverride>& overrides);
  Instance read_nested(const Node& key, const Node& module, const std::string& prefix,
                       const std::filesystem::path& directory, const Constants& constants,
                       const std::vector<PlacedOverride>& overrides);
  Instance read_system_file(const Node& key, const Node& file, const std::filesystem::path& path,
                            const std::string& prefix,
                            const std::vector<PlacedOverride>& overrides);
  const PayloadDescriptor* declare_quantities(
      const Node& module, const Constants& constants,
      const std::map<std::string, const Constants*>& override_constants, bool& readable);
  void read_parameters(const Node& module, const Constants& constants,
                       const std::map<std::string, const Constants*>& override_constants,
                       PlanNode& node);
  void read_parameter(const Node& value, std::size_t component, const Constants& constants,
                      PlanNode& node);
  std::optional<Plan> finish(const Node& graph, const std::vector<std::size_t>& order,
                             const std::vector<std::size_t>& outputs);

  const Registry& registry_;
  Diagnostics& diagnostics_;
  std::vector<PlanNode> nodes_;
  Wiring wiring_;
  CommandReader commands_;
  SourceOwners owners_;  ///< of constants and parameters; node owners come first later
  std::vector<std::filesystem::path> open_files_;
  std::size_t systems_read_ = 0;
};

void PlanBuilder::place(const Override& override, const Constants* constants,
                        std::vector<PlacedOverride>& placed) {
  std::vector<std::string> path = split_path(override.path);
  if (path.size() > 2 * deepest_nesting)
    return diagnostics_.add(override.position, "the name has too many parts");
  placed.push_back({std::move(path), &override, constants});
}

Instance PlanBuilder::read_system(const Node& graph, const std::string& prefix,
                                  const std::filesystem::path& directory,
                                  const std::vector<PlacedOverride>& overrides) {
  Instance unread{.counted = false};
  static const std::vector<std::string> known = {"ilss",    "description", "constants",
                                                 "modules", "network",     "commands"};
  static const std::vector<std::string> later = {"tests", "monitors", "taps", "policy",
                                                 "alternates"};
  if (!graph.is_map()) {
    diagnostics_.add(graph.position,
                     "expected a graph: a map with the keys ilss, modules and "
                     "network, got " +
                         graph.description());
    return unread;
  }
  if (graph.find("study") != nullptr && graph.find("modules") == nullptr) {
    diagnostics_.add(graph.position, "this is a study, not a graph; `ilss compare` takes it");
    return unread;
  }
  for (const Node& key : graph.keys) {
    if (std::find(known.begin(), known.end(), key.text) != known.end()) continue;
    if (std::find(later.begin(), later.end(), key.text) != later.end())
      diagnostics_.add(key.position,
                       fmt::format("'{}' is not available in this version", key.text));
    else
      diagnostics_.add(key.position, fmt::format("a graph has no key '{}'{}", key.text,
                                                 suggestion(key.text, known)));
  }
  for (const char* text_key : {"ilss", "description"}) {
    const Node* text = graph.find(text_key);
    if (text != nullptr && !text->is_scalar())
      diagnostics_.add(text->position, fmt::format("expected a text, got {}", text->description()));
  }
  // The constants outlive the scope: parameters of nested systems may refer to them.
  Constants constants;
  read_constants(graph.find("constants"), prefix, directory, overrides, constants);

  Scope scope;
  const Node* modules = graph.find("modules");
  if (modules == nullptr || !modules->is_map()) {
    diagnostics_.add(modules == nullptr ? graph.position : modules->position,
                     "a graph needs modules: a map of names to modules");
    return unread;
  }
  for (const PlacedOverride& o : overrides)
    if (o.path.front() != "constants" && modules->find(o.path.front()) == nullptr) {
      std::vector<std::string> names = {"constants"};
      for (const Node& key : modules->keys) names.push_back(key.text);
      diagnostics_.add(o.origin->position,
                       fmt::format("there is no module '{}{}'{}", prefix, o.path.front(),
                                   suggestion(o.path.front(), names)));
    }
  for (std::size_t i = 0; i < modules->size(); ++i) {
    const Node& key = modules->keys[i];
    if (key.text.empty() || key.text == "constants" ||
        key.text.find_first_of(". /$") != std::string::npos)
      diagnostics_.add(key.position, fmt::format("'{}' cannot name a module: names have no dots, "
                                                 "spaces, slashes or $",
                                                 key.text));
    std::vector<PlacedOverride> below;
    for (const PlacedOverride& o : overrides) {
      if (o.path.front() != key.text) continue;
      if (o.path.size() == 1)
        diagnostics_.add(o.origin->position, fmt::format("'{}' names a module; expected "
                                                         "MODULE.PARAMETER",
                                                         o.origin->path));
      else
        below.push_back({{o.path.begin() + 1, o.path.end()}, o.origin, o.constants});
    }
    scope[key.text] = read_module(key, modules->values[i], prefix, directory, constants, below);
  }
  if (const Node* commands = graph.find("commands")) commands_.read(*commands, prefix, scope);

  const Node* network = graph.find("network");
  if (network == nullptr) {
    diagnostics_.add(graph.position,
                     "a graph needs a network: a module's name, serial: [...] or "
                     "combine: [...]");
    return unread;
  }
  return wiring_.wire(read_expression(*network, diagnostics_), scope);
}

void PlanBuilder::read_constants(const Node* constants_node, const std::string& prefix,
                                 const std::filesystem::path& directory,
                                 const std::vector<PlacedOverride>& overrides,
                                 Constants& constants) {
  if (constants_node != nullptr && !constants_node->is_map()) {
    diagnostics_.add(constants_node->position,
                     "expected a map of names to values, got " + constants_node->description());
    return;
  }
  Node map = constants_node != nullptr ? *constants_node : Node{Node::Kind::map};
  std::map<std::string, const Constants*> outer_of;
  for (const PlacedOverride& o : overrides) {
    if (o.path.front() != "constants") continue;
    const std::span<const std::string> path = std::span(o.path).subspan(1);
    if (path.empty() || map.find(path.front()) == nullptr) {
      std::vector<std::string> names;
      for (const Node& key : map.keys) names.push_back(key.text);
      const std::string name = path.empty() ? "" : path.front();
      diagnostics_.add(o.origin->position, fmt::format("there is no constant '{}{}'{}", prefix,
                                                       name, suggestion(name, names)));
      continue;
    }
    set_value(map, path, o.origin->value);
    outer_of[path.front()] = o.constants;
  }
  for (std::size_t i = 0; i < map.size(); ++i) {
    Node one{Node::Kind::map, map.position};
    one.keys = {map.keys[i]};
    one.values = {map.values[i]};
    const auto outer = outer_of.find(map.keys[i].text);
    constants.read(one, prefix, directory, outer == outer_of.end() ? nullptr : outer->second,
                   owners_, diagnostics_);
  }
}

Instance PlanBuilder::read_module(const Node& key, Node module, const std::string& prefix,
                                  const std::filesystem::path& directory,
                                  const Constants& constants,
                                  const std::vector<PlacedOverride>& overrides) {
  Instance instance;
  instance.position = key.position;
  const Node* type_node = module.is_map() ? module.find("type") : nullptr;
  if (type_node == nullptr) {
    diagnostics_.add(module.is_null() ? key.position : module.position,
                     fmt::format("module '{}' needs a type", key.text));
    return instance;
  }
  if (type_node->is_map()) return read_nested(key, module, prefix, directory, constants, overrides);
  const ModuleType* type = type_node->is_scalar() ? registry_.find(type_node->text) : nullptr;
  if (type == nullptr) {
    diagnostics_.add(type_node->position,
                     fmt::format("unknown module type {}{}", type_node->description(),
                                 suggestion(type_node->text, registry_.names())));
    return instance;
  }
  std::map<std::string, const Constants*> override_constants;
  for (const PlacedOverride& o : overrides) {
    if (o.path.front() == "type") {
      diagnostics_.add(o.origin->position, "a module's type cannot be set");
      continue;
    }
    set_value(module, o.path, o.origin->value);
    override_constants[fmt::format("{}", fmt::join(o.path, "."))] = o.constants;
  }
  const std::size_t index = nodes_.size();
  PlanNode& node = nodes_.emplace_back();
  node.name = prefix + key.text;
  node.type = type;
  node.position = key.position;
  node.settings.directory = directory;
  if (const Node* time = module.find("time")) node.time = read_module_time(*time, diagnostics_);
  // `type` and `time` belong to every module; the rest is the type's own.
  for (const char* own : {"type", "time"}) {
    const auto found = std::find_if(module.keys.begin(), module.keys.end(),
                                    [&](const Node& k) { return k.text == own; });
    if (found == module.keys.end()) continue;
    module.values.erase(module.values.begin() + (found - module.keys.begin()));
    module.keys.erase(found);
  }
  module.position = key.position;
  check_keys(module, type->declarations, type->name, diagnostics_, type->moved_parameters);
  if (type->takes_quantities)
    node.settings.quantities =
        declare_quantities(module, constants, override_constants, node.readable);
  const std::size_t errors = diagnostics_.size();
  try {
    if (type->read_options)
      node.settings.options = type->read_options(&module, directory, diagnostics_, key.position);
    node.readable &= diagnostics_.size() == errors;
    node.interface = type->interface(node.settings);
  } catch (const std::exception& error) {
    diagnostics_.add(key.position,
                     fmt::format("module type '{}' is defective: {}", type->name, error.what()));
    return instance;
  }
  read_parameters(module, constants, override_constants, node);
  instance.outputs = {index};
  return instance;
}

Instance PlanBuilder::read_nested(const Node& key, const Node& module, const std::string& prefix,
                                  const std::filesystem::path& directory,
                                  const Constants& constants,
                                  const std::vector<PlacedOverride>& overrides) {
  Instance instance{.counted = false, .nested = true, .position = key.position};
  const Node& type = *module.find("type");
  const Node* file = type.find("ilss");
  if (file == nullptr || !file->is_scalar() || type.size() != 1) {
    diagnostics_.add(type.position, "expected a type's name or {ilss: FILE}");
    return instance;
  }
  std::vector<Override> own;
  for (std::size_t i = 0; i < module.size(); ++i) {
    const Node& k = module.keys[i];
    if (k.text == "type") continue;
    if (k.text != "set" || !module.values[i].is_map()) {
      diagnostics_.add(k.position, "a nested system has a type and set: {MODULE.PARAMETER: VALUE}");
      continue;
    }
    const Node& set = module.values[i];
    for (std::size_t j = 0; j < set.size(); ++j)
      own.push_back({set.keys[j].text, set.values[j], set.keys[j].position});
  }
  std::vector<PlacedOverride> below;
  for (const Override& o : own) place(o, &constants, below);
  below.insert(below.end(), overrides.begin(), overrides.end());

  const std::filesystem::path path = directory / file->text;
  open_files_.push_back(canonical_path(path));
  if (std::count(open_files_.begin(), open_files_.end(), open_files_.back()) > 1)
    diagnostics_.add(file->position, fmt::format("'{}' contains itself", file->text));
  else if (open_files_.size() > deepest_nesting || ++systems_read_ > most_systems)
    diagnostics_.add(file->position,
                     fmt::format("a graph holds at most {} systems, nested at most {} deep",
                                 most_systems, deepest_nesting));
  else
    instance = read_system_file(key, *file, path, prefix, below);
  open_files_.pop_back();
  return instance;
}

Instance PlanBuilder::read_system_file(const Node& key, const Node& file,
                                       const std::filesystem::path& path, const std::string& prefix,
                                       const std::vector<PlacedOverride>& overrides) {
  const std::size_t errors = diagnostics_.size();
  const Node graph = read_document(path, diagnostics_);
  Instance instance{.counted = false};
  if (diagnostics_.size() != errors && graph.is_null())
    diagnostics_.add(file.position,
                     fmt::format("the nested system '{}' cannot be read", file.text));
  else
    instance = read_system(graph, prefix + key.text + ".", path.parent_path(), overrides);
  instance.nested = true;
  instance.position = key.position;
  return instance;
}

const PayloadDescriptor* PlanBuilder::declare_quantities(
    const Node& module, const Constants& constants,
    const std::map<std::string, const Constants*>& override_constants, bool& readable) {
  PayloadDescriptor quantities{"quantities", "Named values of a graph.", {}};
  const Node* map = module.find("quantities");
  if (map != nullptr && !map->is_map() && !map->is_null())
    diagnostics_.add(map->position, "expected a map of names to values, got " + map->description());
  // What is wrong with a value is said where it is read as a parameter.
  Diagnostics unreported;
  for (std::size_t i = 0; map != nullptr && i < map->keys.size(); ++i) {
    const Node& value = map->values[i];
    const std::string name = "quantities." + map->keys[i].text;
    const Constants* names = constants_of(name, constants, override_constants);
    std::optional<std::string> unit;
    if (value.is_scalar() && value.text.starts_with('$')) {
      if (const ConstantElement* constant = names->find(value.text.substr(1)))
        unit = constant->quantity.unit;
    } else if (const auto quantity = read_quantity(value, unreported)) {
      unit = quantity->unit;
    }
    if (unit) unit = si_unit(*unit);
    readable &= unit.has_value();
    quantities.components.push_back({name, unit.value_or("1"), "", {}});
  }
  return &intern_payload(std::move(quantities));
}

void PlanBuilder::read_parameters(const Node& module, const Constants& constants,
                                  const std::map<std::string, const Constants*>& override_constants,
                                  PlanNode& node) {
  const PayloadDescriptor& parameters = parameters_of(node);
  node.parameters = Estimate(parameters);
  for (std::size_t i = 0; i < parameters.dimension(); ++i) {
    const Component& component = parameters.components[i];
    const Node* value = find_parameter(module, component.name, diagnostics_);
    if (value == nullptr || value->is_null()) {
      if (!component.default_value)
        diagnostics_.add(module.position,
                         fmt::format("missing parameter '{}' of {}, {}", component.name,
                                     node.type->name, dimension_name(component.unit)));
      continue;
    }
    read_parameter(*value, i, *constants_of(component.name, constants, override_constants), node);
  }
  normalize(parameters, node.parameters.value);
}

void PlanBuilder::read_parameter(const Node& value, std::size_t component,
                                 const Constants& constants, PlanNode& node) {
  const Component& declared = parameters_of(node).components[component];
  const auto store = [&](const WrittenQuantity& quantity) -> std::optional<SiQuantity> {
    const auto si = to_si(quantity, declared.unit, diagnostics_);
    if (si) node.parameters.value[component] = si->value;
    return si;
  };
  if (value.is_scalar() && value.text.starts_with('$')) {
    const ConstantElement* constant = constants.find(value.text.substr(1));
    if (constant == nullptr) return constants.report_unknown(value, diagnostics_);
    WrittenQuantity quantity = constant->quantity;
    quantity.position = value.position;
    const double variance = std::inner_product(constant->factor.begin(), constant->factor.end(),
                                               constant->factor.begin(), 0.0);
    quantity.standard_deviation = std::sqrt(variance);
    const auto si = store(quantity);
    if (!si) return;
    for (std::size_t k = 0; k < constant->factor.size(); ++k)
      if (constant->factor[k] != 0)
        node.parameters.lineage.add(
            {constant->owner, static_cast<std::uint32_t>(k), persistent_tick}, component,
            si->scale * constant->factor[k]);
    return;
  }
  const auto quantity = read_quantity(value, diagnostics_);
  if (!quantity) return;
  const auto si = store(*quantity);
  if (!si || !quantity->standard_deviation || *quantity->standard_deviation == 0) return;
  const auto owner = static_cast<std::uint32_t>(owners_.size());
  owners_.push_back({node.name + "." + declared.name, true, quantity->distribution,
                     quantity->degrees_of_freedom});
  node.parameters.lineage.add({owner, 0, persistent_tick}, component,
                              si->scale * *quantity->standard_deviation);
}

std::optional<Plan> PlanBuilder::finish(const Node& graph, const std::vector<std::size_t>& order,
                                        const std::vector<std::size_t>& outputs) {
  Plan plan;
  if (const Node* name = graph.find("ilss")) plan.name = name->text;
  if (const Node* text = graph.find("description")) plan.description = text->text;
  std::vector<std::size_t> place(nodes_.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = i;
  const auto shift = static_cast<std::uint32_t>(nodes_.size());
  for (const std::size_t index : order) {
    PlanNode& node = plan.nodes.emplace_back(std::move(nodes_[index]));
    for (PlanInput& input : node.inputs) input.node = place[input.node];
    plan.owners.push_back({node.name, false});
    // Owners of constants and parameters now come after those of the nodes.
    Lineage shifted(node.parameters.dimension());
    for (std::size_t k = 0; k < node.parameters.lineage.size(); ++k) {
      Source source = node.parameters.lineage.sources()[k];
      source.owner += shift;
      shifted.add(source, node.parameters.lineage.column(k));
    }
    node.parameters.lineage = std::move(shifted);
  }
  plan.owners.insert(plan.owners.end(), owners_.begin(), owners_.end());
  for (const std::size_t output : outputs) plan.outputs.push_back(place[output]);
  plan.commands = commands_.finish(place);
  plan.unknown_correlations = find_unknown_correlations(plan);
  for (const UnknownCorrelation& unknown : plan.unknown_correlations)
    plan.nodes[unknown.at].correlation_unknown = true;
  return plan;
}

}  // namespace

std::optional<Override> parse_override(const std::string& text, const std::string& origin,
                                       Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.size();
  const std::size_t equals = std::min(text.find('='), text.size());
  const std::string_view path = std::string_view(text).substr(0, equals);
  Node value = parse_document(std::string_view(text).substr(std::min(equals + 1, text.size())),
                              origin, diagnostics);
  if (diagnostics.size() != errors) return std::nullopt;
  if (path.empty() || value.is_null()) {
    diagnostics.add({value.position.file, 0, 0},
                    fmt::format("expected MODULE.PARAMETER=VALUE, got '{}'", text));
    return std::nullopt;
  }
  const Position position = value.position;
  return Override{std::string(path), std::move(value), position};
}

std::optional<Plan> build_plan(const Node& graph, const std::filesystem::path& directory,
                               const Registry& registry, const std::vector<Override>& overrides,
                               Diagnostics& diagnostics) {
  PlanBuilder builder(registry, diagnostics);
  return builder.build(graph, directory, overrides);
}

std::optional<Plan> read_plan(const std::filesystem::path& file, const Registry& registry,
                              const std::vector<Override>& overrides, Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.size();
  const Node graph = read_document(file, diagnostics);
  if (graph.is_null() && diagnostics.size() != errors) return std::nullopt;
  auto plan = build_plan(graph, file.parent_path(), registry, overrides, diagnostics);
  if (diagnostics.size() != errors) return std::nullopt;
  return plan;
}

}  // namespace ilss
