// `ilss modules`: what module types there are, and all that is declared of one.
#include <fmt/format.h>

#include "framework/report/command_json.h"
#include "framework/report/estimate_json.h"
#include "src/session.h"

namespace ilss {
namespace {

std::string inputs_text(const Interface& interface) {
  std::vector<std::string> inputs;
  for (const InputDeclaration& input : interface.inputs)
    inputs.push_back(fmt::format("{}{}", input.name, input.repeated ? "..." : ""));
  return fmt::format("{}", fmt::join(inputs, ", "));
}

std::string unit_text(const std::string& unit) { return unit.empty() ? "" : " in " + unit; }

/// "samples by beam: bearing [rad], range [m]".
std::string samples_declaration_text(const SamplesDescriptor& samples) {
  std::vector<std::string> columns;
  for (const SampleColumn& column : samples.columns) {
    const std::string count = column.count == 1 ? "" : fmt::format(" x {}", column.count);
    const std::string type =
        column.type == SampleType::float64 ? "" : fmt::format(" {}", sample_type_name(column.type));
    columns.push_back(fmt::format("{} [{}]{}{}", column.name, column.unit, count, type));
  }
  return fmt::format("samples by {}: {}", fmt::join(samples.axes, ", "), fmt::join(columns, ", "));
}

std::string payload_text(const PayloadDescriptor& payload) {
  std::vector<std::string> parts;
  for (const Component& component : payload.components)
    parts.push_back(fmt::format(
        "{} [{}]{}", component.name, component.unit,
        component.default_value ? fmt::format(" = {:g}", *component.default_value) : ""));
  for (const Label& label : payload.labels)
    parts.push_back(fmt::format("{}: {}", label.name, fmt::join(label.values, " | ")));
  if (payload.samples) parts.push_back(samples_declaration_text(*payload.samples));
  return fmt::format("{}", fmt::join(parts, ", "));
}

/// A text between two others; nothing where there is none.
std::string preceded(const char* before, const std::string& text, const char* after = "") {
  return text.empty() ? "" : before + text + after;
}

std::string kind_text(const ParameterDeclaration& parameter) {
  using Kind = ParameterDeclaration::Kind;
  if (parameter.kind == Kind::choice) return fmt::format("{}", fmt::join(parameter.choices, " | "));
  if (parameter.kind == Kind::list)
    return fmt::format("list of {}", kind_name(parameter.children.front().kind));
  return fmt::format("{}{}", kind_name(parameter.kind), unit_text(parameter.unit));
}

std::string default_text(const ParameterDeclaration& parameter) {
  if (parameter.required) return "required";
  return parameter.default_text.empty() ? "none" : parameter.default_text;
}

/// Calls `print(full name, declaration)` for each parameter; groups and lists of groups unfold.
template <typename Print>
void for_each_parameter(const std::vector<ParameterDeclaration>& parameters,
                        const std::string& prefix, const Print& print) {
  using Kind = ParameterDeclaration::Kind;
  for (const ParameterDeclaration& parameter : parameters) {
    const std::string name = prefix + parameter.name;
    const bool list_of_groups =
        parameter.kind == Kind::list && parameter.children.front().kind == Kind::group;
    if (parameter.kind != Kind::group) print(name, parameter);
    if (parameter.kind == Kind::group) for_each_parameter(parameter.children, name + ".", print);
    if (list_of_groups)
      for_each_parameter(parameter.children.front().children, name + "[].", print);
  }
}

std::string faults_text(const ModuleType& type) {
  std::vector<std::string_view> names;
  for (const FaultKind fault : type.faults) names.push_back(fault_name(fault));
  return fmt::format("{}", fmt::join(names, ", "));
}

void print_list(const Registry& registry) {
  std::size_t width = 0;
  for (const ModuleType* type : registry.types()) width = std::max(width, type->name.size());
  for (const ModuleType* type : registry.types()) {
    const Interface interface = type->interface(Settings{});
    fmt::print("{:<{}}  {:<9}  {}\n", type->name, width, kind_name(type->kind), type->description);
    fmt::print("{:<{}}  {:<9}  {}{}{}\n", "", width, "", inputs_text(interface),
               interface.inputs.empty() ? "-> " : " -> ", interface.output->name);
  }
}

void print_type(const ModuleType& type) {
  const Interface interface = type.interface(Settings{});
  fmt::print("{} ({}): {}\n", type.name, kind_name(type.kind), type.description);
  if (!type.reference.empty()) fmt::print("source: {}\n", type.reference);
  for (const InputDeclaration& input : interface.inputs)
    fmt::print("input {}{}: {}{}\n{}", input.name, input.repeated ? "..." : "", input.payload->name,
               input.frame.empty() ? "" : " in frame " + input.frame,
               preceded("  ", payload_text(*input.payload), "\n"));
  fmt::print("output: {}{}\n{}", interface.output->name,
             interface.frame.empty() ? "" : " in frame " + interface.frame,
             preceded("  ", payload_text(*interface.output), "\n"));
  if (!type.declarations.empty()) fmt::print("parameters\n");
  for_each_parameter(
      type.declarations, "  ", [](const std::string& name, const ParameterDeclaration& parameter) {
        fmt::print("{}: {}, default {}{}\n", name, kind_text(parameter), default_text(parameter),
                   parameter.uncertain ? "; may be {value, std}" : "");
        if (!parameter.documentation.empty()) fmt::print("      {}\n", parameter.documentation);
      });
  if (!type.commands.empty()) fmt::print("commands\n");
  for (const CommandDeclaration& command : type.commands)
    fmt::print("  {}: {}\n      {}\n", command.name, kind_text(command.value),
               command.documentation);
  if (!type.faults.empty()) fmt::print("faults: {}\n", faults_text(type));
}

void print_markdown(const ModuleType& type) {
  const Interface interface = type.interface(Settings{});
  fmt::print("## {}\n\n{} ({}).", type.name, type.description, kind_name(type.kind));
  if (!type.reference.empty()) fmt::print(" Source: {}.", type.reference);
  fmt::print("\n\n");
  for (const InputDeclaration& input : interface.inputs)
    fmt::print("- input `{}`{}: `{}`{}{}\n", input.name, input.repeated ? " (one or more)" : "",
               input.payload->name,
               input.frame.empty() ? "" : fmt::format(" in frame `{}`", input.frame),
               preceded(": ", payload_text(*input.payload)));
  fmt::print("- output: `{}`{}{}\n", interface.output->name,
             interface.frame.empty() ? "" : fmt::format(" in frame `{}`", interface.frame),
             preceded(": ", payload_text(*interface.output)));
  for (const CommandDeclaration& command : type.commands)
    fmt::print("- command `{}` ({}): {}\n", command.name, kind_text(command.value),
               command.documentation);
  if (!type.faults.empty()) fmt::print("- faults: {}\n", faults_text(type));
  if (!type.declarations.empty())
    fmt::print("\n| parameter | type | default | meaning |\n|---|---|---|---|\n");
  for_each_parameter(
      type.declarations, "", [](const std::string& name, const ParameterDeclaration& parameter) {
        std::string kind = kind_text(parameter);
        for (std::size_t at = kind.find('|'); at != std::string::npos; at = kind.find('|', at + 2))
          kind.insert(at, "\\");
        fmt::print("| `{}` | {}{} | {} | {} |\n", name, kind,
                   parameter.uncertain ? ", may be uncertain" : "", default_text(parameter),
                   parameter.documentation);
      });
  fmt::print("\n");
}

Json payload_json(const PayloadDescriptor& payload) {
  Json components = Json::array();
  for (const Component& component : payload.components) {
    Json entry = {{"name", component.name},
                  {"unit", component.unit},
                  {"documentation", component.documentation}};
    if (component.default_value) entry["default"] = *component.default_value;
    components.push_back(std::move(entry));
  }
  Json json = {{"type", payload.name}, {"components", std::move(components)}};
  for (const Label& label : payload.labels) json["labels"][label.name] = label.values;
  if (payload.samples) {
    Json columns = Json::array();
    for (const SampleColumn& column : payload.samples->columns)
      columns.push_back({{"name", column.name},
                         {"unit", column.unit},
                         {"documentation", column.documentation},
                         {"type", sample_type_name(column.type)},
                         {"count", column.count}});
    json["samples"] = {{"axes", payload.samples->axes}, {"columns", std::move(columns)}};
  }
  for (const PayloadDescriptor* element : payload.elements)
    json["elements"].push_back(payload_json(*element));
  return json;
}

/// An output that is in the frame of one of its inputs names that input instead.
Json output_json(const Interface& interface) {
  Json json = payload_json(*interface.output);
  json["frame"] = interface.frame;
  if (interface.frame_of_input)
    json["frame_of_input"] = interface.inputs[*interface.frame_of_input].name;
  return json;
}

Json type_json(const ModuleType& type) {
  const Interface interface = type.interface(Settings{});
  Json inputs = Json::array();
  for (const InputDeclaration& input : interface.inputs)
    inputs.push_back(
        {{"name", input.name}, {"payload", payload_json(*input.payload)}, {"frame", input.frame}});
  Json parameters = Json::array();
  for_each_parameter(type.declarations, "",
                     [&](const std::string& name, const ParameterDeclaration& parameter) {
                       parameters.push_back({{"name", name},
                                             {"type", kind_name(parameter.kind)},
                                             {"unit", parameter.unit},
                                             {"default", default_text(parameter)},
                                             {"uncertain", parameter.uncertain},
                                             {"documentation", parameter.documentation}});
                     });
  Json commands = Json::array();
  for (const CommandDeclaration& command : type.commands) commands.push_back(command_json(command));
  Json faults = Json::array();
  for (const FaultKind fault : type.faults) faults.push_back(fault_name(fault));
  return {{"name", type.name},
          {"kind", kind_name(type.kind)},
          {"description", type.description},
          {"reference", type.reference},
          {"inputs", std::move(inputs)},
          {"output", output_json(interface)},
          {"parameters", std::move(parameters)},
          {"commands", std::move(commands)},
          {"faults", std::move(faults)}};
}

struct ModulesArguments {
  std::string type;
  bool json = false;
  bool markdown = false;
};

void list_modules(const ModulesArguments& arguments, Session& session) {
  session.load_modules();
  const Registry& registry = session.registry;
  std::vector<const ModuleType*> types = registry.types();
  if (!arguments.type.empty()) {
    const ModuleType* type = registry.find(arguments.type);
    if (type == nullptr)
      fail(exit_bad_input, fmt::format("there is no module type '{}'{}", arguments.type,
                                       suggestion(arguments.type, registry.names())));
    types = {type};
  }
  if (arguments.json) {
    Json json = Json::array();
    for (const ModuleType* type : types) json.push_back(type_json(*type));
    fmt::print("{}\n", json_text(arguments.type.empty() ? json : json.front()));
  } else if (arguments.markdown) {
    for (const ModuleType* type : types) print_markdown(*type);
  } else if (arguments.type.empty()) {
    print_list(registry);
  } else {
    print_type(*types.front());
  }
}

}  // namespace

void add_modules(Verb command, Session& session) {
  const auto arguments = std::make_shared<ModulesArguments>();
  Verb verb = command.add_verb("modules", "List module types, or all that one declares");
  verb.add_option("TYPE", arguments->type, "Module type");
  const Option json = verb.add_flag("--json", arguments->json, "Print JSON");
  verb.add_flag("--markdown", arguments->markdown, "Print the reference page").excludes(json);
  verb.on_call([arguments, &session] { list_modules(*arguments, session); });
}

}  // namespace ilss
