// `ilss eval`: one module on given estimates.
#include <fmt/format.h>

#include "framework/graph/given_outputs.h"
#include "framework/graph/value_reader.h"
#include "framework/report/estimate_json.h"
#include "framework/report/estimate_text.h"
#include "framework/report/set_text.h"
#include "src/session.h"

namespace ilss {
namespace {

struct EvalArguments {
  std::string type;
  std::vector<std::string> parameters;
  std::vector<std::string> inputs;
  bool json = false;
};

Node scalar(const std::string& text) { return {Node::Kind::scalar, {}, false, text}; }
Node list(std::vector<Node> values) {
  Node node{Node::Kind::list};
  node.values = std::move(values);
  return node;
}
Node map(const std::vector<std::pair<std::string, Node>>& entries) {
  Node node{Node::Kind::map};
  for (const auto& [key, value] : entries) {
    node.keys.push_back(scalar(key));
    node.values.push_back(value);
  }
  return node;
}

/// One `--input`, and where it goes.
struct GivenValue {
  std::size_t input;  ///< of the interface
  std::string node;   ///< what it is called in the graph
  const PayloadDescriptor* payload;
  Node value;
};

/// A graph of the module alone, fed by its given inputs: {inputs..., TYPE}.
Node graph_around(const ModuleType& type, const std::string& name,
                  const std::vector<GivenValue>& given) {
  std::vector<std::pair<std::string, Node>> modules;
  std::vector<Node> fed;
  for (const GivenValue& value : given) {
    modules.emplace_back(value.node, map({{"type", scalar("given " + value.node)}}));
    fed.push_back(scalar(value.node));
  }
  modules.emplace_back(name, map({{"type", scalar(type.name)}}));
  Node network = scalar(name);
  if (!given.empty())
    network = map({{"serial", list({map({{"combine", list(std::move(fed))}}), scalar(name)})}});
  return map({{"modules", map(modules)}, {"network", network}});
}

const ModuleType& find_type(const Session& session, const std::string& name) {
  const ModuleType* type = session.registry.find(name);
  if (type == nullptr)
    fail(exit_bad_input, fmt::format("there is no module type '{}'{}", name,
                                     suggestion(name, session.registry.names())));
  return *type;
}

/// The module's inputs under its parameters, which may name them. What is wrong with the parameters
/// is said when the graph is read.
Interface interface_under(const ModuleType& type, const std::vector<Override>& parameters) {
  std::vector<std::pair<std::string, Node>> entries;
  entries.reserve(parameters.size());
  for (const Override& parameter : parameters)
    entries.emplace_back(parameter.path, parameter.value);
  const Node module = map(entries);
  Settings settings;
  Diagnostics unreported;
  if (type.read_options) settings.options = type.read_options(&module, ".", unreported, {});
  return type.interface(settings);
}

/// Takes the key `type` off a given value; returns the payload that it names, or the input's own.
const PayloadDescriptor* take_payload(const InputDeclaration& input, Node& value,
                                      const Registry& registry, Diagnostics& diagnostics) {
  const bool any = input.payload == &any_payload();
  for (std::size_t k = 0; value.is_map() && k < value.size(); ++k) {
    if (value.keys[k].text != "type") continue;
    const Node name = value.values[k];
    value.keys.erase(value.keys.begin() + static_cast<std::ptrdiff_t>(k));
    value.values.erase(value.values.begin() + static_cast<std::ptrdiff_t>(k));
    const PayloadDescriptor* payload = registry.find_payload(name.text);
    if (payload == nullptr)
      diagnostics.add(name.position, fmt::format("there is no payload '{}'", name.text));
    else if (!any && payload->name != input.payload->name)
      diagnostics.add(name.position, fmt::format("input '{}' takes {}, not {}", input.name,
                                                 input.payload->name, payload->name));
    return any ? payload : input.payload;
  }
  if (!any) return input.payload;
  diagnostics.add(value.position,
                  fmt::format("input '{0}' takes any payload; say which one this is: --input "
                              "'{0}={{type: PAYLOAD, ...}}'",
                              input.name));
  return nullptr;
}

/// What was given for each input, in the interface's order; unknown and missing names are errors.
std::vector<GivenValue> read_inputs(const EvalArguments& arguments, const Interface& interface,
                                    const Registry& registry, Diagnostics& diagnostics) {
  std::vector<GivenValue> given;
  std::vector<std::string> names;
  for (const InputDeclaration& input : interface.inputs) names.push_back(input.name);
  std::vector<std::size_t> count(names.size(), 0);
  for (const std::string& text : arguments.inputs) {
    auto value = parse_override(text, "--input " + text, diagnostics);
    if (!value) continue;
    const auto found = std::find(names.begin(), names.end(), value->path);
    const auto i = static_cast<std::size_t>(found - names.begin());
    if (found == names.end()) {
      diagnostics.add(value->position, fmt::format("{} has no input '{}'{}", arguments.type,
                                                   value->path, suggestion(value->path, names)));
    } else if (++count[i] > 1 && !interface.inputs[i].repeated) {
      diagnostics.add(value->position, fmt::format("input '{}' is given twice", value->path));
    } else {
      const std::string node = count[i] == 1 ? names[i] : fmt::format("{}_{}", names[i], count[i]);
      const auto* payload = take_payload(interface.inputs[i], value->value, registry, diagnostics);
      given.push_back({i, node, payload, std::move(value->value)});
    }
  }
  for (std::size_t i = 0; i < names.size(); ++i)
    if (count[i] == 0 && diagnostics.empty())
      fail(exit_bad_input, fmt::format("{} needs --input '{}=...' ({})", arguments.type, names[i],
                                       interface.inputs[i].payload->name));
  std::stable_sort(given.begin(), given.end(),
                   [](const GivenValue& a, const GivenValue& b) { return a.input < b.input; });
  return given;
}

void print_result(const EvalArguments& arguments, const Plan& plan, const System& system,
                  std::size_t node) {
  const NodeState& state = system.node(node);
  const auto verdicts = state.outcome.has_output() ? judge(system) : std::vector<VerdictReport>(1);
  if (arguments.json) {
    Json json = {{"module", arguments.type}, {"outcome", outcome_name(state.outcome)}};
    if (state.outcome.is_fault()) json["fault"] = fault_json(state.outcome.fault(), arguments.type);
    json["output"] = outputs_json(TickView(system, {.verdicts = verdicts}));
    fmt::print("{}\n", json_text(json));
  } else if (state.outcome.has_output()) {
    const Estimate& estimate = state.output().estimate;
    fmt::print("{}", estimate_text(estimate, verdicts.front()));
    const std::string shares = budget_text(estimate, plan.owners);
    if (!shares.empty()) fmt::print("share of the variance\n{}", shares);
    fmt::print("{}", parts_text(state.output(), plan.nodes[node].name, plan.owners));
  } else if (state.outcome.is_fault()) {
    fmt::print("fault {}: {}\n", fault_name(state.outcome.fault().kind),
               state.outcome.fault().message);
  } else {
    fmt::print("pending\n");
  }
}

void evaluate(const EvalArguments& arguments, Session& session) {
  session.load_modules();
  const ModuleType& type = find_type(session, arguments.type);
  Diagnostics diagnostics;
  std::vector<Override> parameters;
  for (const std::string& text : arguments.parameters)
    if (auto parameter = parse_override(text, "--param " + text, diagnostics))
      parameters.push_back(std::move(*parameter));
  const std::vector<GivenValue> given =
      read_inputs(arguments, interface_under(type, parameters), session.registry, diagnostics);
  std::string name = type.name;
  for (const GivenValue& value : given) {
    if (value.payload == nullptr) report_and_exit(diagnostics);
    session.registry.add(given_type("given " + value.node, *value.payload));
    if (value.node == type.name) name = "module";
  }
  for (Override& parameter : parameters) parameter.path = name + "." + parameter.path;
  auto plan =
      build_plan(graph_around(type, name, given), ".", session.registry, parameters, diagnostics);
  if (!plan) report_and_exit(diagnostics);
  std::map<std::size_t, OperatingPoint> points;
  for (const GivenValue& value : given) {
    const std::size_t node = *plan->find(value.node);
    auto estimate =
        read_estimate(value.value, *value.payload, value.node, plan->owners, diagnostics);
    if (estimate) points[node] = {Output{std::move(estimate->estimate)}, true};
  }
  if (!diagnostics.empty()) report_and_exit(diagnostics);
  System system(*plan, 1,
                {.folding = Folding::none, .stand_ins = given_outputs(std::move(points))});
  system.expect();
  print_result(arguments, *plan, system, *plan->find(name));
}

}  // namespace

void add_eval(Verb command, Session& session) {
  const auto arguments = std::make_shared<EvalArguments>();
  Verb verb = command.add_verb("eval", "One module on given estimates");
  verb.add_option("TYPE", arguments->type, "Module type").required();
  verb.add_option("--param", arguments->parameters, "A parameter: NAME=VALUE, as in YAML")
      .type_name("NAME=VALUE")
      .one_value_each();
  verb.add_option("--input", arguments->inputs,
                  "An input: NAME={COMPONENT: {value, std}, ...}, or NAME={value: {...}, "
                  "covariance: [[...]]}; with type: PAYLOAD where the module takes any")
      .type_name("NAME=VALUE")
      .one_value_each();
  verb.add_flag("--json", arguments->json, "Print JSON");
  verb.on_call([arguments, &session] { evaluate(*arguments, session); });
}

}  // namespace ilss
