// `ilss predict`: how late and how wrong a system's answer will be, without acquiring anything.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <limits>

#include "framework/graph/correlation.h"
#include "framework/graph/given_outputs.h"
#include "framework/graph/value_reader.h"
#include "framework/report/estimate_json.h"
#include "framework/report/estimate_text.h"
#include "framework/report/prediction_text.h"
#include "framework/report/set_text.h"
#include "src/session.h"

namespace ilss {
namespace {

struct PredictArguments {
  std::string graph;
  std::vector<std::string> sets;
  std::vector<std::string> at;
  std::string profile;
  std::size_t trials = 0;  ///< of Monte Carlo; 0: none asked for
  std::uint64_t seed = 1;
  bool budget = false;
  bool parallel = false;
  bool json = false;
};

/// The operating points of `--at NAME=VALUE`; their sources join the plan's owners.
std::map<std::size_t, OperatingPoint> read_operating_points(const std::vector<std::string>& texts,
                                                            Plan& plan) {
  Diagnostics diagnostics;
  std::map<std::size_t, OperatingPoint> points;
  std::vector<std::string> names;
  for (const PlanNode& node : plan.nodes) names.push_back(node.name);
  for (const std::string& text : texts) {
    const auto given = parse_override(text, "--at " + text, diagnostics);
    if (!given) continue;
    const auto node = plan.find(given->path);
    if (!node) {
      diagnostics.add(given->position, fmt::format("there is no module '{}'{}", given->path,
                                                   suggestion(given->path, names)));
      continue;
    }
    auto estimate = read_estimate(given->value, *plan.nodes[*node].interface.output, given->path,
                                  plan.owners, diagnostics, LeftOut::stay_unknown);
    if (!estimate) continue;
    const bool has_error = estimate->has_error;
    points[*node] = {Output{std::move(estimate->estimate)}, has_error};
  }
  if (!diagnostics.empty()) report_and_exit(diagnostics);
  return points;
}

/// Tells why an output is not there, and what would help.
void report_fault(const System& system, std::size_t node) {
  const Plan& plan = system.plan();
  const Outcome<>& outcome = system.node(node).outcome;
  const std::string& module = plan.nodes[system.node(node).origin.value_or(node)].name;
  const Fault fault = outcome.is_fault()
                          ? outcome.fault()
                          : Fault{FaultKind::no_error_known, "nothing is expected of it yet"};
  fmt::print(stderr, "ilss: no prediction of '{}': '{}': {} ({})\n", plan.nodes[node].name, module,
             fault.message, fault_name(fault.kind));
}

/// A bar on stderr while the trials run, where that is a terminal; wiped when they are done.
class ProgressBar {
 public:
  ProgressBar() : shown_(isatty(STDERR_FILENO) == 1) {}
  ~ProgressBar() {
    if (drawn_ >= 0) fmt::print(stderr, "\r{:{}}\r", "", width + 8);
  }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(double done) {
    const int percent = static_cast<int>(100 * done);
    if (!shown_ || percent == drawn_) return;
    drawn_ = percent;
    const int filled = percent * width / 100;
    fmt::print(stderr, "\r[{:#<{}}{:{}}] {:3} %", "", filled, "", width - filled, percent);
    std::fflush(stderr);
  }

 private:
  static constexpr int width = 50;
  bool shown_;
  int drawn_ = -1;
};

std::vector<MonteCarloOutput> draw_trials(const PredictArguments& arguments, const System& system,
                                          const std::vector<std::size_t>& given) {
  if (arguments.trials == 0) return {};
  ProgressBar bar;
  return run_monte_carlo(system, given,
                         {.trials = arguments.trials,
                          .seed = arguments.seed,
                          .progress = [&bar](double done) { bar.show(done); }});
}

/// All that was found of a system's outputs.
struct Prediction {
  const System& system;
  std::vector<VerdictReport> verdicts;
  std::vector<MonteCarloOutput> monte_carlo;  ///< empty where none was asked for
  TimePrediction time;
};

void print_text(const PredictArguments& arguments, const Prediction& prediction) {
  const System& system = prediction.system;
  const Plan& plan = system.plan();
  for (std::size_t o = 0; o < plan.outputs.size(); ++o) {
    const NodeState& state = system.node(plan.outputs[o]);
    if (!state.outcome.has_output()) continue;
    const Estimate& estimate = state.output().estimate;
    fmt::print("{}: {}", plan.nodes[plan.outputs[o]].name,
               estimate_text(estimate, prediction.verdicts[o]));
    fmt::print("{}", degrees_of_freedom_text(estimate, plan.owners));
    if (!prediction.monte_carlo.empty())
      fmt::print("\nMonte Carlo, {} trials, seed {}\n{}", arguments.trials, arguments.seed,
                 monte_carlo_text(estimate, prediction.monte_carlo[o]));
    const std::string shares = budget_text(estimate, plan.owners);
    if (arguments.budget)
      fmt::print("{}", budget_tables_text(estimate, plan.owners));
    else if (!shares.empty())
      fmt::print("share of the variance\n{}", shares);
    fmt::print("{}", parts_text(state.output(), plan.nodes[plan.outputs[o]].name, plan.owners));
  }
  for (const UnknownCorrelation& unknown : plan.unknown_correlations)
    fmt::print("note: {}\n", describe(unknown, plan));
  for (const PlanNode& node : plan.nodes)
    if (node.type->remembers)
      fmt::print("note: '{}' keeps earlier ticks; this is its first\n", node.name);
  fmt::print("{}", time_text(prediction.time, plan));
}

/// The outputs with what Monte Carlo found of each.
Json outputs_with_trials(const Prediction& prediction) {
  const Plan& plan = prediction.system.plan();
  Json json = outputs_json(TickView(prediction.system, {.verdicts = prediction.verdicts}));
  for (std::size_t o = 0; o < prediction.monte_carlo.size(); ++o) {
    Json& one = plan.outputs.size() == 1 ? json : json["outputs"][o];
    if (!one.is_null()) one["monte_carlo"] = monte_carlo_json(prediction.monte_carlo[o]);
  }
  return json;
}

/// Faults of the outputs that are not there.
Json faults_json(const System& system) {
  const Plan& plan = system.plan();
  Json faults = Json::array();
  for (const std::size_t node : plan.outputs) {
    const NodeState& state = system.node(node);
    if (state.outcome.is_fault())
      faults.push_back(
          fault_json(state.outcome.fault(), plan.nodes[state.origin.value_or(node)].name));
  }
  return faults;
}

int predict(const PredictArguments& arguments, Session& session) {
  session.load_modules();
  Plan plan = session.read_graph(arguments.graph, arguments.sets);
  if (!arguments.profile.empty()) session.apply_profile_file(arguments.profile, plan);
  const auto points = read_operating_points(arguments.at, plan);
  std::vector<std::size_t> given;
  given.reserve(points.size());
  for (const auto& [node, point] : points) given.push_back(node);

  System system(plan, 1, {.stand_ins = given_outputs(points)});
  system.expect();
  const Prediction prediction{
      system, judge(system, given), draw_trials(arguments, system, given),
      predict_time(plan, arguments.parallel ? Execution::parallel : Execution::one_thread)};
  std::size_t missing = 0;
  for (const std::size_t node : plan.outputs) {
    if (system.node(node).outcome.has_output()) continue;
    ++missing;
    report_fault(system, node);
  }
  if (missing != 0)
    fmt::print(stderr,
               "      a module's operating point can be given: --at 'NAME={{COMPONENT: "
               "{{value: ..., std: ...}}, ...}}'\n");
  if (arguments.json) {
    Json json = {{"output", outputs_with_trials(prediction)}};
    if (missing != 0) json["faults"] = faults_json(system);
    json["time"] = time_json(prediction.time, plan);
    fmt::print("{}\n", json_text(json));
  } else if (missing < plan.outputs.size()) {
    print_text(arguments, prediction);
  }
  return missing < plan.outputs.size() ? exit_fine : exit_failed;
}

}  // namespace

void add_predict(Verb command, Session& session) {
  const auto arguments = std::make_shared<PredictArguments>();
  Verb verb = command.add_verb(
      "predict", "Time and error of a system at an operating point, without acquiring");
  verb.add_option("GRAPH", arguments->graph, "Graph file").required();
  verb.add_option("--at", arguments->at,
                  "What a module gives at the operating point: NAME={COMPONENT: {value, std}}")
      .type_name("NAME=VALUE")
      .one_value_each();
  verb.add_set_option(arguments->sets);
  verb.add_option("--profile", arguments->profile, "Module times measured by run --profile")
      .type_name("FILE");
  verb.add_option("--monte-carlo", arguments->trials,
                  "Draw every source of error from its distribution so many times")
      .type_name("N")
      .check(whole_number<std::size_t>(1, most_trials));
  verb.add_option("--seed", arguments->seed, "Seed of Monte Carlo")
      .type_name("N")
      .check(whole_number<std::uint64_t>(0, std::numeric_limits<std::uint64_t>::max()));
  verb.add_flag("--budget", arguments->budget,
                "Who is to blame, a table a component, and what halving each source would bring");
  verb.add_flag("--parallel", arguments->parallel, "Branches run side by side");
  verb.add_flag("--json", arguments->json, "Print JSON");
  verb.on_call([arguments, &session] { throw Exit{predict(*arguments, session)}; });
}

}  // namespace ilss
