// `ilss eval`: one module on given estimates.
#include <fmt/format.h>

#include "framework/graph/value_reader.h"
#include "src/estimate_json.h"
#include "src/estimate_text.h"
#include "src/session.h"

namespace ilss {
namespace {

struct Arguments {
  std::string type;
  std::vector<std::string> parameters;
  std::vector<std::string> inputs;
  bool json = false;
};

/// Stands for an input whose value is given; never evaluated itself.
class GivenInput final : public Module {
 public:
  Outcome<> evaluate(const Evaluation&, Output&) override {
    return Fault{FaultKind::no_detection, "the input was not given"};
  }
};

ModuleType given_type(const std::string& name, const PayloadDescriptor& payload) {
  ModuleType type;
  type.name = name;
  type.kind = ModuleKind::sensor;
  type.parameters = &no_parameters();
  type.interface = [&payload](const Settings&) { return Interface{{}, &payload, {}, {}}; };
  type.create = [](const Settings&) { return std::make_unique<GivenInput>(); };
  return type;
}

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

/// A graph of the module alone, fed by its given inputs: {inputs..., TYPE}.
Node graph_around(const ModuleType& type, const std::string& name,
                  const std::vector<std::string>& inputs) {
  std::vector<std::pair<std::string, Node>> modules;
  std::vector<Node> fed;
  for (const std::string& input : inputs) {
    modules.emplace_back(input, map({{"type", scalar("given " + input)}}));
    fed.push_back(scalar(input));
  }
  modules.emplace_back(name, map({{"type", scalar(type.name)}}));
  Node network = scalar(name);
  if (!inputs.empty())
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

/// What was given for each input by name; unknown and missing names are errors.
std::map<std::string, Override> read_inputs(const Arguments& arguments, const Interface& interface,
                                            Diagnostics& diagnostics) {
  std::map<std::string, Override> given;
  std::vector<std::string> names;
  for (const InputDeclaration& input : interface.inputs) names.push_back(input.name);
  for (const std::string& text : arguments.inputs) {
    auto input = parse_override(text, "--input " + text, diagnostics);
    if (!input) continue;
    if (std::find(names.begin(), names.end(), input->path) == names.end())
      diagnostics.add(input->position, fmt::format("{} has no input '{}'{}", arguments.type,
                                                   input->path, suggestion(input->path, names)));
    else if (given.contains(input->path))
      diagnostics.add(input->position, fmt::format("input '{}' is given twice", input->path));
    else
      given.emplace(input->path, std::move(*input));
  }
  for (const InputDeclaration& input : interface.inputs)
    if (!given.contains(input.name) && diagnostics.empty())
      fail(exit_bad_input, fmt::format("{} needs --input '{}=...' ({})", arguments.type, input.name,
                                       input.payload->name));
  return given;
}

void print_result(const Arguments& arguments, const Plan& plan, const System& system,
                  std::size_t node) {
  const NodeState& state = system.node(node);
  const auto verdicts = state.outcome.has_output() ? judge(system) : std::vector<VerdictReport>(1);
  if (arguments.json) {
    Json json = {{"module", arguments.type}, {"outcome", outcome_name(state.outcome)}};
    if (state.outcome.is_fault()) json["fault"] = fault_json(state.outcome.fault(), arguments.type);
    json["output"] = outputs_json(system, plan.owners, verdicts);
    fmt::print("{}\n", json.dump(2));
  } else if (state.outcome.has_output()) {
    const Estimate& estimate = state.output.estimate;
    fmt::print("{}", estimate_text(estimate, verdicts.front()));
    const std::string shares = budget_text(estimate, plan.owners);
    if (!shares.empty()) fmt::print("share of the variance\n{}", shares);
  } else if (state.outcome.is_fault()) {
    fmt::print("fault {}: {}\n", fault_name(state.outcome.fault().kind),
               state.outcome.fault().message);
  } else {
    fmt::print("pending\n");
  }
}

void evaluate(const Arguments& arguments, Session& session) {
  session.load_modules();
  const ModuleType& type = find_type(session, arguments.type);
  const Interface interface = type.interface(Settings{});
  Diagnostics diagnostics;
  const auto given = read_inputs(arguments, interface, diagnostics);
  std::vector<std::string> inputs;
  for (const InputDeclaration& input : interface.inputs) {
    inputs.push_back(input.name);
    session.registry.add(given_type("given " + input.name, *input.payload));
  }
  const bool name_taken = std::find(inputs.begin(), inputs.end(), type.name) != inputs.end();
  const std::string name = name_taken ? "module" : type.name;
  std::vector<Override> overrides;
  for (const std::string& text : arguments.parameters)
    if (auto parameter = parse_override(text, "--param " + text, diagnostics)) {
      parameter->path = name + "." + parameter->path;
      overrides.push_back(std::move(*parameter));
    }
  auto plan =
      build_plan(graph_around(type, name, inputs), ".", session.registry, overrides, diagnostics);
  if (!plan) report_and_exit(diagnostics);
  std::map<std::size_t, System::OperatingPoint> points;
  for (const auto& [input, value] : given) {
    const std::size_t node = *plan->find(input);
    auto estimate = read_estimate(value.value, *plan->nodes[node].interface.output, input,
                                  plan->owners, diagnostics);
    if (estimate) points[node] = {Output{std::move(estimate->estimate)}, true};
  }
  if (!diagnostics.empty()) report_and_exit(diagnostics);
  System system(*plan, 1, Folding::none);
  system.expect(points);
  print_result(arguments, *plan, system, *plan->find(name));
}

}  // namespace

void add_eval(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* verb = app.add_subcommand("eval", "One module on given estimates");
  verb->add_option("TYPE", arguments->type, "Module type")->required();
  verb->add_option("--param", arguments->parameters, "A parameter: NAME=VALUE, as in YAML")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  verb->add_option("--input", arguments->inputs,
                   "An input: NAME={COMPONENT: {value, std}, ...}, or "
                   "NAME={value: {...}, covariance: [[...]]}")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  verb->add_flag("--json", arguments->json, "Print JSON");
  verb->callback([arguments, &session] { evaluate(*arguments, session); });
}

}  // namespace ilss
