#include "framework/study/judge_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/estimate/dimension.h"
#include "framework/estimate/units.h"
#include "framework/study/study_settings.h"

namespace ilss {
namespace {

/// Reads the judged components of one payload.
void read_components(const Node& list, ElementRule& rule, Diagnostics& diagnostics) {
  const PayloadDescriptor& type = *rule.type;
  if (!list.is_list() || list.size() == 0) {
    diagnostics.add(list.position, fmt::format("expected a list of {}'s components, got {}",
                                               type.name, list.description()));
    return;
  }
  std::vector<std::string> names;
  for (const Component& component : type.components) names.push_back(component.name);
  for (const Node& entry : list.values) {
    const auto component = entry.is_scalar() ? type.find(entry.text) : std::nullopt;
    if (!component)
      diagnostics.add(entry.position,
                      fmt::format("{} has no component {}{}", type.name, entry.description(),
                                  suggestion(entry.text, names)));
    else if (std::find(rule.judged.begin(), rule.judged.end(), *component) != rule.judged.end())
      diagnostics.add(entry.position, fmt::format("'{}' is judged twice", entry.text));
    else
      rule.judged.push_back(*component);
  }
}

void read_limit(const Node* node, const std::string& unit, double most, double& limit,
                Diagnostics& diagnostics) {
  if (node == nullptr) return;
  const auto value = parse_quantity(node->is_scalar() ? node->text : "", unit);
  const double* number = std::get_if<double>(&value);
  if (!node->is_scalar())
    diagnostics.add(node->position,
                    fmt::format("expected {}, got {}", dimension_name(unit), node->description()));
  else if (number == nullptr)
    diagnostics.add(node->position, std::get<std::string>(value));
  else if (!(*number > 0 && *number <= most))
    diagnostics.add(node->position, fmt::format("must be above 0{}, got '{}'",
                                                most == 1 ? " and at most 1" : "", node->text));
  else
    limit = *number;
}

/// Reads the labels that elements must have to be judged.
void read_only(const Node& map, ElementRule& rule, Diagnostics& diagnostics) {
  const PayloadDescriptor& type = *rule.type;
  if (!map.is_map()) {
    diagnostics.add(map.position, fmt::format("expected a map of {}'s labels to values, got {}",
                                              type.name, map.description()));
    return;
  }
  std::vector<std::string> names;
  for (const Label& label : type.labels) names.push_back(label.name);
  check_map_keys(map, type.name, names, diagnostics);
  for (std::size_t l = 0; l < type.labels.size(); ++l) {
    const Node* wanted = map.find(type.labels[l].name);
    if (wanted == nullptr) continue;
    const std::vector<std::string>& values = type.labels[l].values;
    const auto value = std::find(values.begin(), values.end(), wanted->text);
    if (!wanted->is_scalar() || value == values.end())
      diagnostics.add(wanted->position,
                      fmt::format("expected one of {}, got {}", fmt::join(values, ", "),
                                  wanted->description()));
    else
      rule.only.emplace_back(l, static_cast<int>(value - values.begin()));
  }
}

ElementRule read_rule(const Node& node, const PayloadDescriptor& type, Diagnostics& diagnostics) {
  ElementRule rule = element_rule(type);
  if (!node.is_map()) {
    read_components(node, rule, diagnostics);
    return rule;
  }
  check_map_keys(node, type.name, {"components", "only", rule.interval ? "overlap" : "gate"},
                 diagnostics);
  if (const Node* components = node.find("components"))
    read_components(*components, rule, diagnostics);
  else
    diagnostics.add(node.position, fmt::format("{} needs components: a list", type.name));
  if (const Node* only = node.find("only")) read_only(*only, rule, diagnostics);
  if (rule.interval)
    read_limit(node.find("overlap"), "1", 1, rule.overlap, diagnostics);
  else
    read_limit(node.find("gate"), "m", std::numeric_limits<double>::infinity(), rule.gate,
               diagnostics);
  return rule;
}

/// Reads the rules of `judge`, in the order of the set's elements.
std::vector<ElementRule> read_judge(const Node& judge, const PayloadDescriptor& set,
                                    Diagnostics& diagnostics) {
  std::vector<ElementRule> rules;
  if (!judge.is_map() || judge.size() == 0) {
    diagnostics.add(
        judge.position,
        "expected a map of elements to the components that are judged, got " + judge.description());
    return rules;
  }
  std::vector<std::string> names;
  for (const PayloadDescriptor* element : set.elements) names.push_back(element->name);
  check_map_keys(judge, set.name, names, diagnostics);
  for (const PayloadDescriptor* element : set.elements) {
    const Node* node = judge.find(element->name);
    if (node == nullptr) continue;
    const ElementRule& rule = rules.emplace_back(read_rule(*node, *element, diagnostics));
    if (!rule.interval && rule.place.empty())
      diagnostics.add(node->position,
                      fmt::format("{} cannot be matched: it has neither first_reading and "
                                  "last_reading nor a place x, z",
                                  element->name));
  }
  return rules;
}

double read_gate(const Node& node, Diagnostics& diagnostics) {
  const auto value = parse_quantity(node.is_scalar() ? node.text : "", "1");
  if (const double* number = std::get_if<double>(&value); number != nullptr && *number > 0)
    return *number;
  diagnostics.add(node.position, "expected a chi-square value above 0, got " + node.description());
  return 0;
}

std::size_t read_reference(const Node& node, const std::vector<std::string>& alternatives,
                           Diagnostics& diagnostics) {
  const auto found = std::find(alternatives.begin(), alternatives.end(), node.text);
  if (node.is_scalar() && found != alternatives.end())
    return static_cast<std::size_t>(found - alternatives.begin());
  diagnostics.add(node.position, fmt::format("no alternative is named {}{}", node.description(),
                                             suggestion(node.text, alternatives)));
  return 0;
}

}  // namespace

void read_set_keys(const Node& file, Study& study, Diagnostics& diagnostics) {
  const bool sets = study.compares_sets();
  const std::vector<const char*> misplaced =
      sets ? std::vector{"requirement", "draw_systematic_errors"}
           : std::vector{"judge", "validation_gate", "reference", "tolerated"};
  for (const char* key : misplaced)
    if (const Node* node = file.find(key))
      diagnostics.add(node->position, fmt::format("'{}' is for studies of {}; {} is {}", key,
                                                  sets ? "single estimates" : "sets",
                                                  study.payload->name, sets ? "a set" : "no set"));
  if (!sets) return;
  if (const Node* judge = file.find("judge"))
    study.judged = read_judge(*judge, *study.payload, diagnostics);
  else
    diagnostics.add(file.position,
                    fmt::format("a study of sets needs judge: a map of {} to the components that "
                                "are judged",
                                study.payload->element));
  if (const Node* gate = file.find("validation_gate"))
    study.validation_gate = read_gate(*gate, diagnostics);
  if (const Node* reference = file.find("reference"))
    study.reference = read_reference(*reference, study.alternatives, diagnostics);
}

}  // namespace ilss
