#include "framework/graph/schema.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "framework/estimate/units.h"

namespace ilss {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* number_pattern = R"(^\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?)";
constexpr const char* name_pattern = "^[^. /$]+$";
constexpr const char* command_name_pattern = "^[^. /$=@]+$";

Json reference(const std::string& definition) { return {{"$ref", "#/$defs/" + definition}}; }

Json one_of_these(std::vector<Json> forms) { return {{"anyOf", std::move(forms)}}; }

/// A map with these keys and no others.
Json map_of(Json properties, const std::vector<std::string>& required) {
  Json schema = {
      {"type", "object"}, {"properties", std::move(properties)}, {"additionalProperties", false}};
  if (!required.empty()) schema["required"] = required;
  return schema;
}

/// A number with a unit; a bare one where it is a pure number, or 0.
Json bare_quantity(const std::string& unit) {
  const bool pure = unit == "1";
  const std::string pattern =
      std::string(number_pattern) + (pure ? R"((\s*\S.*)?$)" : R"(\s*\S.*$)");
  return one_of_these({{{"type", "string"}, {"pattern", pattern}},
                       pure ? Json{{"type", "number"}} : Json{{"const", 0}},
                       {{"type", "string"}, {"pattern", R"(^\s*[+-]?0+\.?0*\s*$)"}}});
}

/// As `bare_quantity` where the unit is not known beforehand.
Json any_quantity() {
  return one_of_these(
      {{{"type", "string"}, {"pattern", std::string(number_pattern) + R"((\s*\S.*)?$)"}},
       {{"type", "number"}}});
}

/// `{value, std}` and what else may be said of an error.
Json with_error(const Json& quantity) {
  const Json samples = map_of({{"samples", {{"type", "string"}}},
                               {"column", {{"type", Json::array({"string", "integer"})}}}},
                              {"samples"});
  const Json shape = {{"enum", Json::array({"normal", "uniform", "triangular", "arcsine", "t"})}};
  return map_of({{"value", quantity},
                 {"std", quantity},
                 {"half_width", quantity},
                 {"distribution", one_of_these({shape, samples})},
                 {"degrees_of_freedom", {{"type", "number"}, {"exclusiveMinimum", 0}}}},
                {"value"});
}

/// A parameter's quantity: `11 deg`, `{value, std}` or `$constant`.
Json uncertain_quantity(const std::string& unit) {
  return one_of_these({bare_quantity(unit),
                       with_error(bare_quantity(unit)),
                       {{"type", "string"}, {"pattern", R"(^\$.+$)"}}});
}

std::string explain(const ParameterDeclaration& d) {
  std::string text = d.documentation;
  const auto add = [&text](const std::string& more) { text += (text.empty() ? "" : "; ") + more; };
  if (d.kind == ParameterDeclaration::Kind::quantity) add(dimension_name(d.unit));
  if (!d.default_text.empty()) add("default " + d.default_text);
  return text;
}

Json schema_of(const ParameterDeclaration& d);

/// Whether a map must have the key: a group must where a quantity in it has no default.
bool is_required(const ParameterDeclaration& d) {
  if (d.kind != ParameterDeclaration::Kind::group || d.required) return d.required;
  return std::any_of(d.children.begin(), d.children.end(), [](const ParameterDeclaration& child) {
    return is_required(child) &&
           (child.uncertain || child.kind == ParameterDeclaration::Kind::group);
  });
}

Json schema_of(const std::vector<ParameterDeclaration>& declarations, Json properties,
               std::vector<std::string> required) {
  for (const ParameterDeclaration& d : declarations) {
    properties[d.name] = schema_of(d);
    if (is_required(d)) required.push_back(d.name);
  }
  return map_of(std::move(properties), required);
}

Json schema_without_words(const ParameterDeclaration& d) {
  using Kind = ParameterDeclaration::Kind;
  switch (d.kind) {
    case Kind::quantity:
      if (d.unit.empty())
        return one_of_these({any_quantity(),
                             with_error(any_quantity()),
                             {{"type", "string"}, {"pattern", R"(^\$.+$)"}}});
      return d.uncertain ? uncertain_quantity(d.unit) : bare_quantity(d.unit);
    case Kind::number:
      return bare_quantity("1");
    case Kind::integer:
      return {{"type", "integer"}};
    case Kind::boolean:
      return {{"type", "boolean"}};
    case Kind::text:  // YAML takes a bare 1 or true for something else
    case Kind::path:
      return {{"type", Json::array({"string", "number", "boolean"})}};
    case Kind::choice:
      return {{"enum", d.choices}};
    case Kind::list:
      return {{"type", "array"}, {"items", schema_of(d.children.front())}};
    case Kind::group:
      return schema_of(d.children, Json::object(), {});
    case Kind::map:
      return {{"type", "object"}, {"additionalProperties", schema_of(d.children.front())}};
  }
  return true;
}

Json schema_of(const ParameterDeclaration& d) {
  Json schema = schema_without_words(d);
  // A key without a value stands for its default.
  if (!d.name.empty() && !d.required) schema = one_of_these({schema, {{"type", "null"}}});
  const std::string text = explain(d);
  if (!text.empty()) schema["description"] = text;
  return schema;
}

Json time_schema() {
  const Json seconds = bare_quantity("s");
  Json schema = one_of_these(
      {seconds, map_of({{"typical", seconds}, {"worst", seconds}}, {"typical", "worst"})});
  schema["description"] = "how long the module takes, or {typical, worst}";
  return schema;
}

Json module_schema(const Registry& registry) {
  Json names = Json::array();
  Json rules = Json::array();
  for (const ModuleType* type : registry.types()) {
    names.push_back({{"const", type->name}, {"description", type->description}});
    Json properties = {{"type", {{"const", type->name}}}, {"time", reference("time")}};
    Json then = schema_of(type->declarations, std::move(properties), {"type"});
    then["description"] = type->description;
    rules.push_back(
        {{"if", {{"properties", {{"type", {{"const", type->name}}}}}}}, {"then", std::move(then)}});
  }
  Json system =
      map_of({{"ilss", {{"type", "string"}, {"description", "a graph's file"}}}}, {"ilss"});
  Json nested = map_of({{"type", Json::object()},
                        {"set",
                         {{"type", "object"},
                          {"description", "MODULE.PARAMETER or constants.NAME: its value here"}}}},
                       {"type"});
  rules.push_back(
      {{"if", {{"properties", {{"type", {{"type", "object"}}}}}}}, {"then", std::move(nested)}});
  names.push_back(std::move(system));
  return {{"type", "object"},
          {"required", {"type"}},
          {"properties",
           {{"type", {{"description", "the module's type, or {ilss: FILE}"}, {"anyOf", names}}}}},
          {"allOf", std::move(rules)}};
}

Json expression_schema() {
  const Json list = {{"type", "array"}, {"minItems", 1}, {"items", reference("expression")}};
  const Json aligned = map_of(
      {{"of", list}, {"align", {{"enum", {"latest"}}}}, {"max_age", bare_quantity("s")}}, {"of"});
  Json serial = map_of({{"serial", list}}, {"serial"});
  serial["description"] = "one after another: each feeds the next";
  Json combine = map_of({{"combine", one_of_these({list, aligned})}}, {"combine"});
  combine["description"] = "side by side: outputs in order";
  return one_of_these(
      {{{"type", Json::array({"string", "number"})}, {"description", "a module's name"}},
       serial,
       combine});
}

Json constant_schema() {
  const Json quantity = any_quantity();
  const Json one = with_error(quantity);
  const Json row = {{"type", "array"}, {"items", any_quantity()}};
  const Json vector = map_of({{"value",
                               {{"type", "object"},
                                {"minProperties", 1},
                                {"propertyNames", {{"pattern", name_pattern}}},
                                {"additionalProperties", one_of_these({quantity, one})}}},
                              {"covariance", {{"type", "array"}, {"items", row}}}},
                             {"value"});
  const Json file = map_of({{"file", {{"type", "string"}}}}, {"file"});
  return one_of_these({quantity, one, vector, file});
}

Json command_schema() {
  const Json to = {{"type", "string"},
                   {"pattern", R"(^[^.]+\..+$)"},
                   {"description", "MODULE.COMMAND: the module that follows it"}};
  const Json from = {{"type", Json::array({"string", "number"})},
                     {"description", "MODULE.COMPONENT: sent after every tick that gives it"}};
  return one_of_these({to, map_of({{"to", to}, {"from", from}}, {"to"})});
}

}  // namespace

std::string graph_schema(const Registry& registry) {
  const Json named = {{"pattern", name_pattern}};
  Json schema = map_of(
      {{"ilss",
        {{"type", Json::array({"string", "number"})}, {"description", "the system's name"}}},
       {"description", {{"type", "string"}}},
       {"constants",
        {{"type", "object"},
         {"description", "named values; one name is one source of error, wherever it is used"},
         {"propertyNames", named},
         {"additionalProperties", reference("constant")}}},
       {"modules",
        {{"type", "object"},
         {"description", "named instances; each is evaluated at most once a tick"},
         {"propertyNames", named},
         {"additionalProperties", reference("module")}}},
       {"network", reference("expression")},
       {"commands",
        {{"type", "object"},
         {"description", "the system's commands, and the modules' that they are"},
         {"propertyNames", {{"pattern", command_name_pattern}}},
         {"additionalProperties", reference("command")}}}},
      {"modules", "network"});
  Json result = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                 {"title", "ilss graph"}};
  result.update(schema);
  result["$defs"] = {{"module", module_schema(registry)},
                     {"expression", expression_schema()},
                     {"constant", constant_schema()},
                     {"command", command_schema()},
                     {"time", time_schema()}};
  return result.dump(2);
}

}  // namespace ilss
