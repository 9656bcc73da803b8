#include "framework/module/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "framework/estimate/units.h"

namespace ilss {
namespace {

ParameterDeclaration* find(std::vector<ParameterDeclaration>& declarations, std::string_view name) {
  const auto found = std::find_if(declarations.begin(), declarations.end(),
                                  [&](const ParameterDeclaration& d) { return d.name == name; });
  return found == declarations.end() ? nullptr : &*found;
}

void check_value_keys(const Node& value, const ParameterDeclaration& declaration,
                      std::string_view owner, Diagnostics& diagnostics) {
  using Kind = ParameterDeclaration::Kind;
  if (declaration.kind == Kind::group && value.is_map())
    check_keys(value, declaration.children, owner, diagnostics);
  if (declaration.kind == Kind::list && value.is_list())
    for (const Node& element : value.values)
      check_value_keys(element, declaration.children.front(), owner, diagnostics);
  if (declaration.kind == Kind::map && value.is_map())
    for (const Node& element : value.values)
      check_value_keys(element, declaration.children.front(), owner, diagnostics);
}

}  // namespace

namespace internal {
std::string format_number(double value) { return fmt::format("{}", value); }
}  // namespace internal

std::string_view kind_name(ParameterDeclaration::Kind kind) {
  using Kind = ParameterDeclaration::Kind;
  switch (kind) {
    case Kind::quantity:
      return "quantity";
    case Kind::number:
      return "number";
    case Kind::integer:
      return "integer";
    case Kind::boolean:
      return "boolean";
    case Kind::text:
      return "text";
    case Kind::path:
      return "path";
    case Kind::choice:
      return "choice";
    case Kind::list:
      return "list";
    case Kind::group:
      return "group";
    case Kind::map:
      return "map";
  }
  return "";
}

std::vector<ParameterDeclaration> quantity_declarations(const PayloadDescriptor& parameters) {
  std::vector<ParameterDeclaration> result;
  for (const Component& component : parameters.components) {
    std::vector<ParameterDeclaration>* level = &result;
    std::string_view name = component.name;
    for (std::size_t dot = name.find('.'); dot != std::string_view::npos; dot = name.find('.')) {
      const std::string group(name.substr(0, dot));
      if (find(*level, group) == nullptr) {
        ParameterDeclaration d;
        d.name = group;
        d.kind = ParameterDeclaration::Kind::group;
        level->push_back(std::move(d));
      }
      level = &find(*level, group)->children;
      name.remove_prefix(dot + 1);
    }
    ParameterDeclaration d;
    d.name = name;
    d.kind = ParameterDeclaration::Kind::quantity;
    d.unit = component.unit;
    d.documentation = component.documentation;
    d.required = !component.default_value.has_value();
    d.uncertain = true;
    if (component.default_value)
      d.default_text = component.unit == "1"
                           ? fmt::format("{}", *component.default_value)
                           : fmt::format("{} {}", *component.default_value, component.unit);
    level->push_back(std::move(d));
  }
  return result;
}

void merge_declarations(std::vector<ParameterDeclaration>& declarations,
                        std::vector<ParameterDeclaration> more) {
  for (ParameterDeclaration& d : more) {
    ParameterDeclaration* existing = find(declarations, d.name);
    if (existing != nullptr && existing->kind == ParameterDeclaration::Kind::group)
      merge_declarations(existing->children, std::move(d.children));
    else
      declarations.push_back(std::move(d));
  }
}

void check_keys(const Node& map, const std::vector<ParameterDeclaration>& declarations,
                std::string_view owner, Diagnostics& diagnostics,
                const std::vector<MovedParameter>& moved) {
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const Node& key = map.keys[i];
    const auto found =
        std::find_if(declarations.begin(), declarations.end(),
                     [&](const ParameterDeclaration& d) { return d.name == key.text; });
    if (found == declarations.end()) {
      const auto elsewhere = std::find_if(
          moved.begin(), moved.end(), [&](const MovedParameter& m) { return m.name == key.text; });
      std::vector<std::string> names;
      names.reserve(declarations.size());
      for (const ParameterDeclaration& d : declarations) names.push_back(d.name);
      diagnostics.add(key.position,
                      fmt::format("{} has no parameter '{}'{}", owner, key.text,
                                  elsewhere != moved.end() ? fmt::format(": {}", elsewhere->advice)
                                                           : suggestion(key.text, names)));
      continue;
    }
    check_value_keys(map.values[i], *found, owner, diagnostics);
  }
}

std::string OptionVisitor::full_name(std::string_view name) const {
  if (group_.empty() || name.empty()) return group_ + std::string(name);
  return fmt::format("{}.{}", group_, name);
}

void OptionVisitor::complain(const Node& node, std::string message) {
  diagnostics_->add(node.position, std::move(message));
}

void OptionVisitor::require(bool condition, std::string_view message) {
  if (declarations_ == nullptr && !condition)
    diagnostics_->add(map_ != nullptr ? map_->position : fallback_, std::string(message));
}

void OptionVisitor::read_scalar(const Node& node, bool& value) {
  if (node.is_scalar() && (node.text == "true" || node.text == "false"))
    value = node.text == "true";
  else
    complain(node, "expected true or false, got " + node.description());
}

void OptionVisitor::read_scalar(const Node& node, std::int64_t& value,
                                const OptionAttributes& attributes) {
  const char* end = node.text.data() + node.text.size();
  std::int64_t parsed = 0;
  const auto [stop, error] = std::from_chars(node.text.data(), end, parsed);
  if (!node.is_scalar() || error != std::errc{} || stop != end)
    return complain(node, "expected an integer, got " + node.description());
  if (static_cast<double>(parsed) < attributes.minimum ||
      static_cast<double>(parsed) > attributes.maximum)
    return complain(node, fmt::format("{} is outside [{}, {}]", parsed, attributes.minimum,
                                      attributes.maximum));
  value = parsed;
}

void OptionVisitor::read_scalar(const Node& node, double& value,
                                const OptionAttributes& attributes) {
  const std::string_view unit = attributes.unit.empty() ? "1" : attributes.unit;
  if (!node.is_scalar())
    return complain(node,
                    fmt::format("expected {}, got {}", dimension_name(unit), node.description()));
  const auto parsed = parse_quantity(node.text, unit);
  if (const auto* error = std::get_if<std::string>(&parsed)) return complain(node, *error);
  const double number = std::get<double>(parsed);
  if (number < attributes.minimum || number > attributes.maximum)
    return complain(node, fmt::format("{} is outside [{}, {}] {}", number, attributes.minimum,
                                      attributes.maximum, attributes.unit));
  value = number;
}

void OptionVisitor::read_scalar(const Node& node, std::string& value) {
  if (!node.is_scalar()) return complain(node, "expected a text, got " + node.description());
  value = node.text;
}

void OptionVisitor::read_scalar(const Node& node, std::filesystem::path& value) {
  if (!node.is_scalar()) return complain(node, "expected a path, got " + node.description());
  value = *directory_ / node.text;
}

std::optional<std::size_t> OptionVisitor::read_choice(const Node& node,
                                                      const std::vector<std::string>& choices) {
  if (node.is_scalar()) {
    const auto found = std::find(choices.begin(), choices.end(), node.text);
    if (found != choices.end()) return static_cast<std::size_t>(found - choices.begin());
  }
  complain(node, fmt::format("expected one of {}, got {}{}", fmt::join(choices, ", "),
                             node.description(), suggestion(node.text, choices)));
  return std::nullopt;
}

}  // namespace ilss
