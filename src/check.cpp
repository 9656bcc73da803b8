// `ilss check`: every error of a graph at once, or its plan.
#include <fmt/format.h>

#include "framework/graph/correlation.h"
#include "framework/report/command_json.h"
#include "framework/report/command_text.h"
#include "framework/runtime/run.h"
#include "src/session.h"

namespace ilss {
namespace {

std::vector<std::string> input_names(const Plan& plan, const PlanNode& node) {
  std::vector<std::string> names;
  for (const PlanInput& input : node.inputs) names.push_back(plan.nodes[input.node].name);
  return names;
}

/// Where estimates of unknown correlation meet, a sentence each.
std::vector<std::string> correlation_notes(const Plan& plan) {
  std::vector<std::string> notes;
  for (const UnknownCorrelation& unknown : plan.unknown_correlations)
    notes.push_back(describe(unknown, plan));
  return notes;
}

void print_text(const Plan& plan) {
  fmt::print("{}: {} module{}, fine\n", plan.name.empty() ? "graph" : plan.name, plan.nodes.size(),
             plan.nodes.size() == 1 ? "" : "s");
  std::size_t width = 0;
  for (const PlanNode& node : plan.nodes) width = std::max(width, node.name.size());
  for (const PlanNode& node : plan.nodes) {
    const std::vector<std::string> inputs = input_names(plan, node);
    fmt::print("  {:<{}}  {:<20} {}{} -> {}{}\n", node.name, width, node.type->name,
               fmt::join(inputs, ", "), inputs.empty() ? "source" : "", node.interface.output->name,
               node.frame.empty() ? "" : fmt::format(" in {}", node.frame));
  }
  for (const std::size_t output : plan.outputs) fmt::print("output: {}\n", plan.nodes[output].name);
  for (const PlanCommand& command : plan.commands)
    fmt::print("command: {}\n", command_text(command, plan));
  for (const std::string& note : correlation_notes(plan)) fmt::print("note: {}\n", note);
}

void print_json(const Plan& plan) {
  Json nodes = Json::array();
  for (const PlanNode& node : plan.nodes)
    nodes.push_back({{"name", node.name},
                     {"type", node.type->name},
                     {"inputs", input_names(plan, node)},
                     {"output", node.interface.output->name},
                     {"frame", node.frame}});
  Json outputs = Json::array();
  for (const std::size_t output : plan.outputs) outputs.push_back(plan.nodes[output].name);
  Json commands = Json::array();
  for (const PlanCommand& command : plan.commands) commands.push_back(command_json(command, plan));
  const Json plan_json = {{"ilss", plan.name},
                          {"modules", nodes},
                          {"outputs", outputs},
                          {"commands", commands},
                          {"unknown_correlations", correlation_notes(plan)}};
  fmt::print("{}\n", json_text(plan_json));
}

/// Opens all files and devices that the graph's modules read, or says which cannot be opened.
void open_all(const Plan& plan) {
  Run run(plan, {});
  Diagnostics diagnostics;
  if (!run.open(diagnostics)) report_and_exit(diagnostics);
}

}  // namespace

void add_check(Verb command, Session& session) {
  struct CheckArguments {
    std::string graph;
    std::vector<std::string> sets;
    bool open = false;
    bool json = false;
  };
  const auto arguments = std::make_shared<CheckArguments>();
  Verb verb = command.add_verb("check", "Report all errors of a graph, or print its plan");
  verb.add_option("GRAPH", arguments->graph, "Graph file").required();
  verb.add_set_option(arguments->sets);
  verb.add_flag("--open", arguments->open, "Open the files and devices that its modules read, too");
  verb.add_flag("--json", arguments->json, "Print JSON");
  verb.on_call([arguments, &session] {
    session.load_modules();
    const Plan plan = session.read_graph(arguments->graph, arguments->sets);
    if (arguments->open) open_all(plan);
    arguments->json ? print_json(plan) : print_text(plan);
  });
}

}  // namespace ilss
