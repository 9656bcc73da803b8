#include "framework/graph/profile.h"

#include <fmt/format.h>

#include <iomanip>
#include <ostream>
#include <unordered_map>

#include "framework/estimate/units.h"

namespace ilss {
namespace {

std::optional<double> read_seconds(const Node& node, Diagnostics& diagnostics) {
  if (!node.is_scalar()) {
    diagnostics.add(node.position, "expected a time (s), got " + node.description());
    return std::nullopt;
  }
  const auto seconds = parse_quantity(node.text, "s");
  if (const auto* error = std::get_if<std::string>(&seconds)) {
    diagnostics.add(node.position, *error);
    return std::nullopt;
  }
  if (std::get<double>(seconds) < 0) {
    diagnostics.add(node.position, "a time cannot be negative");
    return std::nullopt;
  }
  return std::get<double>(seconds);
}

void read_entries(const Node& map, Profile& profile, Diagnostics& diagnostics) {
  if (!map.is_map()) {
    diagnostics.add(map.position, "expected a map of names to times, got " + map.description());
    return;
  }
  for (std::size_t i = 0; i < map.size(); ++i)
    if (const auto time = read_module_time(map.values[i], diagnostics))
      profile.modules.push_back({map.keys[i].text, *time, map.keys[i].position});
}

}  // namespace

std::optional<ModuleTime> read_module_time(const Node& node, Diagnostics& diagnostics) {
  if (node.is_scalar()) {
    const auto seconds = read_seconds(node, diagnostics);
    if (!seconds) return std::nullopt;
    return ModuleTime{*seconds, *seconds};
  }
  const Node* typical = node.is_map() ? node.find("typical") : nullptr;
  const Node* worst = node.is_map() ? node.find("worst") : nullptr;
  if (typical == nullptr || worst == nullptr || node.size() != 2) {
    diagnostics.add(node.position, "expected a time, or {typical: TIME, worst: TIME}");
    return std::nullopt;
  }
  const auto a = read_seconds(*typical, diagnostics);
  const auto b = read_seconds(*worst, diagnostics);
  if (!a || !b) return std::nullopt;
  if (*b < *a) diagnostics.add(worst->position, "the worst time is shorter than the typical one");
  return ModuleTime{*a, *b};
}

void write_profile(const Profile& profile, std::ostream& out) {
  // Names in quotes, so that none can be taken for another kind of value.
  out << "# Module times as measured by a run; `ilss predict --profile` takes them.\n";
  out << "profile: " << std::quoted(profile.plan) << "\nmodules:";
  out << (profile.modules.empty() ? " {}\n" : "\n");
  for (const ProfileEntry& entry : profile.modules)
    out << "  " << std::quoted(entry.module)
        << fmt::format(": {{typical: {} s, worst: {} s}}\n", entry.time.typical, entry.time.worst);
}

Profile read_profile(const std::filesystem::path& file, Diagnostics& diagnostics) {
  Profile profile;
  const std::size_t errors = diagnostics.size();
  const Node root = read_document(file, diagnostics);
  if (diagnostics.size() != errors) return profile;
  const Node* modules = root.is_map() ? root.find("modules") : nullptr;
  if (modules == nullptr) {
    diagnostics.add(root.position,
                    "expected a profile: a map with the keys profile and modules, "
                    "as `ilss run --profile` writes it");
    return profile;
  }
  for (const Node& key : root.keys)
    if (key.text != "profile" && key.text != "modules")
      diagnostics.add(key.position, fmt::format("a profile has no key '{}'{}", key.text,
                                                suggestion(key.text, {"profile", "modules"})));
  if (const Node* plan = root.find("profile")) profile.plan = plan->text;
  read_entries(*modules, profile, diagnostics);
  return profile;
}

void apply_profile(const Profile& profile, Plan& plan, Diagnostics& diagnostics) {
  std::unordered_map<std::string_view, PlanNode*> nodes;
  for (PlanNode& node : plan.nodes) nodes.emplace(node.name, &node);
  for (const ProfileEntry& entry : profile.modules) {
    const auto found = nodes.find(entry.module);
    if (found != nodes.end()) {
      found->second->time = entry.time;
      continue;
    }
    std::vector<std::string> names;
    for (const PlanNode& node : plan.nodes) names.push_back(node.name);
    diagnostics.add(entry.position, fmt::format("'{}' has no module '{}'{}", plan.name,
                                                entry.module, suggestion(entry.module, names)));
  }
}

}  // namespace ilss
