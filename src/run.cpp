// `ilss run`: a system over its input, with its instruments.
#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "framework/estimate/units.h"
#include "framework/report/command_report.h"
#include "framework/report/estimate_json.h"
#include "framework/report/estimate_text.h"
#include "framework/report/set_text.h"
#include "framework/runtime/agreement.h"
#include "framework/runtime/runner.h"
#include "src/feature_file.h"
#include "src/picture.h"
#include "src/picture_svg.h"
#include "src/session.h"

namespace ilss {
namespace {

volatile std::sig_atomic_t interrupted = 0;

/// Where no --ticks is given, a run without end stops here.
constexpr std::int64_t default_ticks = 1000;
constexpr double longest_period = 1e6;  // s
constexpr double least_picture_scale = 1e-3;
constexpr double most_picture_scale = 1e6;

/// Outputs up to this number are shown one by one at every tick; more are counted.
constexpr std::size_t most_outputs_shown = 4;

struct Arguments {
  std::string graph;
  std::vector<std::string> sets;
  std::vector<std::string> commands;
  std::optional<std::int64_t> ticks = {};
  std::string period = "100 ms";
  std::uint64_t seed = 1;
  std::string profile;
  std::string features;
  std::string picture;
  double picture_scale = 1;
  bool json = false;
  bool quiet = false;
};

/// How often there was which verdict.
using VerdictCounts = std::array<std::uint64_t, static_cast<std::size_t>(Verdict::invalid) + 1>;

/// What the summary tells of one output beyond its outcomes.
struct OutputSummary {
  std::uint64_t outputs = 0;
  VerdictCounts verdicts = {};
  std::vector<double> variance_sum;
  SetSummary elements = {};  ///< of a set
};

/// Leaves the run after the tick at the first Ctrl-C; the second ends the command, so that a run
/// that hangs in a tick can be ended, too.
void end_run_at_interrupt() {
  struct sigaction action = {};
  action.sa_handler = [](int) { interrupted = 1; };
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, nullptr);
}

/// The first node whose source has come to its end or cannot be read any more, if any.
std::optional<std::size_t> find_fault(const System& system, FaultKind kind) {
  for (std::size_t i = 0; i < system.size(); ++i)
    if (system.node(i).outcome.is_fault() && system.node(i).outcome.fault().kind == kind) return i;
  return std::nullopt;
}

Json tick_json(const Runner& runner, double time, const std::vector<VerdictReport>& verdicts) {
  const System& system = runner.system();
  const Plan& plan = system.plan();
  const auto [outcome, at] = system_outcome(system);
  Json json = {{"tick", system.ticks() - 1}, {"time", time}, {"outcome", outcome_name(*outcome)}};
  if (outcome->is_fault())
    json["fault"] =
        fault_json(outcome->fault(), plan.nodes[system.node(at).origin.value_or(at)].name);
  json["output"] = outputs_json(system, plan.owners, verdicts);
  Json modules = Json::object();
  for (std::size_t i = 0; i < system.size(); ++i) {
    const NodeState& state = system.node(i);
    Json module = {{"outcome", outcome_name(state.outcome)},
                   {"compute_ns", runner.compute_ns(i)},
                   {"age_ns", nullptr}};
    if (state.has_value)
      module["age_ns"] = (time_at(time) - state.output().acquired.oldest).count();
    if (state.outcome.is_fault())
      module["fault"] =
          fault_json(state.outcome.fault(), plan.nodes[state.origin.value_or(i)].name);
    modules[plan.nodes[i].name] = std::move(module);
  }
  json["modules"] = std::move(modules);
  for (const GivenCommand& given : runner.commander().given())
    json["commands"].push_back(given_command_json(given, plan));
  return json;
}

/// The verdicts that are not linear_ok: "23 second_order, 2 invalid"; empty where there is none.
std::string verdict_counts_text(const VerdictCounts& counts) {
  std::string text;
  for (std::size_t verdict = 0; verdict < counts.size(); ++verdict)
    if (counts[verdict] != 0 && static_cast<Verdict>(verdict) != Verdict::linear_ok)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counts[verdict],
                          verdict_name(static_cast<Verdict>(verdict)));
  return text;
}

/// What one output came to in a tick, on one line, with a mark where its error is not to be
/// believed as it stands.
std::string output_text(const System& system, std::size_t node, Verdict verdict) {
  const NodeState& state = system.node(node);
  if (state.outcome.is_fault())
    return fmt::format("{} in {}: {}", fault_name(state.outcome.fault().kind),
                       system.plan().nodes[state.origin.value_or(node)].name,
                       state.outcome.fault().message);
  if (!state.outcome.has_output()) return "pending";
  const Estimate& estimate = state.output().estimate;
  std::string text = samples_text(state.output());
  if (has_parts(*estimate.type)) {
    text += (text.empty() ? "" : "  ") + component_line(estimate);
  } else {
    for (std::size_t i = 0; i < estimate.dimension(); ++i) {
      const Component& component = estimate.type->components[i];
      text += fmt::format(
          "{}{} {}", i == 0 ? "" : " ", component.name,
          quantity_text(estimate.value[i], estimate.lineage.standard_deviation(i), component.unit));
    }
  }
  if (verdict != Verdict::linear_ok)
    text += fmt::format("  {} {}", verdict == Verdict::invalid ? '!' : '~', verdict_name(verdict));
  return text;
}

/// The elements of an output that is a set, below its line.
void print_elements(const System& system, std::size_t node, const std::string& indent) {
  const NodeState& state = system.node(node);
  if (state.outcome.has_output() && !state.output().estimate.type->element.empty())
    fmt::print("{}", elements_text(state.output().elements, indent));
}

/// "22 of 24 outputs (3 second_order)".
std::string output_counts_text(const System& system, const std::vector<VerdictReport>& verdicts) {
  const std::vector<std::size_t>& outputs = system.plan().outputs;
  std::size_t given = 0;
  VerdictCounts counts = {};
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    if (!system.node(outputs[o]).outcome.has_output()) continue;
    ++given;
    ++counts[static_cast<std::size_t>(verdicts[o].verdict)];
  }
  const std::string not_linear = verdict_counts_text(counts);
  return fmt::format("{} of {} outputs{}", given, outputs.size(),
                     not_linear.empty() ? "" : fmt::format(" ({})", not_linear));
}

void print_tick(const System& system, double time, const std::vector<VerdictReport>& verdicts) {
  const Plan& plan = system.plan();
  const std::string when = fmt::format("{:>6} {:>9.3f} s", system.ticks() - 1, time);
  if (plan.outputs.size() == 1) {
    fmt::print("{}  {}\n", when, output_text(system, plan.outputs[0], verdicts[0].verdict));
    print_elements(system, plan.outputs[0], std::string(20, ' '));
    return;
  }
  if (plan.outputs.size() > most_outputs_shown) {
    fmt::print("{}  {}\n", when, output_counts_text(system, verdicts));
    return;
  }
  fmt::print("{}\n", when);
  for (std::size_t o = 0; o < plan.outputs.size(); ++o) {
    fmt::print("         {:<20} {}\n", plan.nodes[plan.outputs[o]].name,
               output_text(system, plan.outputs[o], verdicts[o].verdict));
    print_elements(system, plan.outputs[o], std::string(30, ' '));
  }
}

void print_commands(const Runner& runner, double time) {
  for (const GivenCommand& given : runner.commander().given())
    fmt::print("{:>16.3f} s  {}\n", time, given_command_text(given, runner.system().plan()));
}

void observe_outputs(const System& system, const std::vector<VerdictReport>& verdicts,
                     std::vector<OutputSummary>& summaries) {
  for (std::size_t o = 0; o < summaries.size(); ++o) {
    const NodeState& state = system.node(system.plan().outputs[o]);
    if (!state.fresh) continue;
    ++summaries[o].outputs;
    ++summaries[o].verdicts[static_cast<std::size_t>(verdicts[o].verdict)];
    summaries[o].variance_sum.resize(state.output().estimate.dimension(), 0.0);
    for (std::size_t i = 0; i < summaries[o].variance_sum.size(); ++i)
      summaries[o].variance_sum[i] += state.output().estimate.lineage.variance(i);
    if (!state.output().estimate.type->element.empty())
      summaries[o].elements.add(state.output().elements);
  }
}

/// Faults by kind; the end of the data is how runs end, not a fault to count.
std::string fault_counts_text(const OutcomeCounts& counts) {
  std::string text;
  for (std::size_t kind = 0; kind < OutcomeCounts::fault_kinds; ++kind)
    if (counts.faults_by_kind[kind] != 0 && static_cast<FaultKind>(kind) != FaultKind::end_of_data)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counts.faults_by_kind[kind],
                          fault_name(static_cast<FaultKind>(kind)));
  if (counts.pending != 0)
    text += fmt::format("{}{} pending", text.empty() ? "" : ", ", counts.pending);
  return text.empty() ? "-" : text;
}

/// "x 1.2 mm, phi 0.3 deg": root mean squares; of samples and sets, what is exact is left out.
std::string stated_text(const OutputSummary& summary, const PayloadDescriptor& payload) {
  std::string stated;
  for (std::size_t i = 0; i < summary.variance_sum.size(); ++i) {
    if (has_parts(payload) && summary.variance_sum[i] <= 0) continue;
    const Component& component = payload.components[i];
    stated += fmt::format(
        "{}{} {}", stated.empty() ? "" : ", ", component.name,
        quantity_text(std::sqrt(summary.variance_sum[i] / static_cast<double>(summary.outputs)),
                      component.unit));
  }
  const std::string not_linear = verdict_counts_text(summary.verdicts);
  if (!not_linear.empty()) stated += fmt::format("   ({})", not_linear);
  return stated.empty() && has_parts(payload) ? "-" : stated;
}

void print_outputs(const Runner& runner, const std::vector<OutputSummary>& summaries) {
  const Plan& plan = runner.system().plan();
  const auto row = [](const std::string& name, std::uint64_t count, const std::string& faults,
                      const std::string& stated) {
    fmt::print("{:<20} {:>8}  {:<40} {}\n", name, count, faults, stated);
  };
  fmt::print("\n{:<20} {:>8}  {:<40} stated std (root mean square)\n", "output", "outputs",
             "faults");
  for (std::size_t o = 0; o < summaries.size(); ++o) {
    const std::size_t node = plan.outputs[o];
    row(plan.nodes[node].name, summaries[o].outputs, fault_counts_text(runner.outcomes(node)),
        stated_text(summaries[o], *plan.nodes[node].interface.output));
    for (const SetSummary::Entry& entry : summaries[o].elements.entries())
      row("  " + entry.type->name, entry.count, "", summary_text(entry, summaries[o].outputs));
  }
}

void print_agreement(const Agreement& agreement, const Plan& plan) {
  if (agreement.pairs().empty()) return;
  fmt::print("\n{:<20} {:<20} {:>9} {:>9}   (difference within its 95 % bound)\n", "output",
             "and output", "compared", "agree");
  for (const AgreementCount& pair : agreement.pairs())
    if (pair.compared != 0)
      fmt::print("{:<20} {:<20} {:>9} {:>9}\n", plan.nodes[plan.outputs[pair.first]].name,
                 plan.nodes[plan.outputs[pair.second]].name, pair.compared, pair.agreed);
  const AgreementCount total = agreement.total();
  if (total.compared != 0)
    fmt::print(
        "all: {} of {} agree ({:.1f} %; 95 % would if errors are as stated and both see the "
        "same)\n",
        total.agreed, total.compared,
        100.0 * static_cast<double>(total.agreed) / static_cast<double>(total.compared));
}

void print_latency(const Runner& runner) {
  const Plan& plan = runner.system().plan();
  const auto row = [](const std::string& name, const LatencySummary& s) {
    const auto text = [](std::uint64_t ns) {
      return duration_text(static_cast<double>(ns) * 1e-9);
    };
    fmt::print("{:<20} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9}\n", name, s.count, text(s.p50),
               text(s.p90), text(s.p99), text(s.p999), text(s.max));
  };
  fmt::print("\n{:<20} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "compute time", "ticks", "p50",
             "p90", "p99", "p99.9", "max");
  constexpr std::size_t most_rows = 60;
  for (std::size_t i = 0; i < std::min(plan.nodes.size(), most_rows); ++i)
    row(plan.nodes[i].name, runner.latency(i).summary());
  if (plan.nodes.size() > most_rows)
    fmt::print("... and {} more modules\n", plan.nodes.size() - most_rows);
  row("end to end", runner.end_to_end().summary());
}

/// Reads all commands before any module is made, or says all that is wrong with them.
std::vector<ScheduledCommand> read_commands(const std::vector<std::string>& texts,
                                            const Plan& plan) {
  Diagnostics diagnostics;
  std::vector<ScheduledCommand> commands;
  for (const std::string& text : texts)
    if (auto command = parse_command(text, plan, "--command " + text, diagnostics))
      commands.push_back(std::move(*command));
  if (!diagnostics.empty()) report_and_exit(diagnostics);
  return commands;
}

/// Commands whose time did not come are no part of the run.
void report_waiting(const Commander& commander) {
  if (commander.waiting() != 0)
    fmt::print(stderr, "ilss: the run ended before the time of {} command{}\n", commander.waiting(),
               commander.waiting() == 1 ? "" : "s");
}

/// What the modules have to say of their data.
void report_notes(const System& system) {
  for (std::size_t i = 0; i < system.size(); ++i)
    if (const std::string note = system.note(i); !note.empty())
      fmt::print(stderr, "ilss: '{}': {}\n", system.plan().nodes[i].name, note);
}

double read_period(const std::string& text) {
  const auto period = parse_quantity(text, "s");
  if (const auto* error = std::get_if<std::string>(&period))
    fail(exit_bad_input, "--period: " + *error);
  if (!(std::get<double>(period) > 0 && std::get<double>(period) <= longest_period))
    fail(exit_bad_input,
         fmt::format("--period must be above 0 and at most {:.0f} s", longest_period));
  return std::get<double>(period);
}

void check_picture_scale(double scale) {
  if (!(scale >= least_picture_scale && scale <= most_picture_scale))
    fail(exit_bad_input, fmt::format("--picture-scale must be from {:g} to {:.0f}",
                                     least_picture_scale, most_picture_scale));
}

/// Finds out before a run whether an option's file can be written, and leaves all as it is.
void check_file(const std::string& option, const std::string& path, const std::string& graph) {
  check_output_file(option, path, {graph});
  std::error_code ignored;
  const bool is_new = !std::filesystem::exists(path, ignored);
  if (!std::ofstream(path, std::ios::app))
    fail(exit_bad_input,
         fmt::format("{}: cannot write '{}': {}", option, path, std::strerror(errno)));
  if (is_new) std::filesystem::remove(path, ignored);
}

CLI::Validator file_name() {
  return {[](const std::string& file) -> std::string {
            return file.empty() ? "the file's name is empty" : "";
          },
          ""};
}

void write_profile_file(const std::string& path, const Runner& runner) {
  std::ofstream file(path);
  write_profile(runner.profile(), file);
  if (!file.flush()) fail(exit_failed, fmt::format("cannot write the profile '{}'", path));
}

/// Writes the picture of the last tick that had something to draw.
int write_picture_file(const Arguments& arguments, const std::optional<Picture>& picture) {
  if (!picture) {
    fmt::print(stderr,
               "ilss: --picture: nothing that the run gave has a place in a plane: no range scan, "
               "segment, arc, edge or point\n");
    return exit_failed;
  }
  for (const std::string& message : picture->left_out)
    fmt::print(stderr, "ilss: --picture: {}\n", message);
  std::ofstream file(arguments.picture, std::ios::binary);
  file << picture_svg(*picture, arguments.picture_scale);
  if (!file.flush())
    fail(exit_failed, fmt::format("cannot write the picture '{}'", arguments.picture));
  return exit_fine;
}

std::string ticks_text(std::int64_t ticks) {
  return fmt::format("{} tick{}", ticks, ticks == 1 ? "" : "s");
}

int run(const Arguments& arguments, Session& session) {
  session.load_modules();
  const double period = read_period(arguments.period);
  check_picture_scale(arguments.picture_scale);
  const std::int64_t most_ticks = arguments.ticks.value_or(default_ticks);
  const Plan plan = session.read_graph(arguments.graph, arguments.sets);
  const std::vector<ScheduledCommand> commands = read_commands(arguments.commands, plan);
  if (!arguments.profile.empty()) check_file("--profile", arguments.profile, arguments.graph);
  if (!arguments.picture.empty()) check_file("--picture", arguments.picture, arguments.graph);
  std::optional<FeatureFile> features;
  if (!arguments.features.empty()) {
    check_file("--features", arguments.features, arguments.graph);
    features.emplace(arguments.features, plan);
  }
  Runner runner(plan, arguments.seed);
  for (const ScheduledCommand& command : commands) runner.schedule(command);
  Agreement agreement(plan);
  std::vector<OutputSummary> summaries(plan.outputs.size());
  end_run_at_interrupt();
  bool ended = false;
  std::optional<Picture> picture;
  std::int64_t tick = 0;
  for (; (most_ticks == 0 || tick < most_ticks) && interrupted == 0; ++tick) {
    const double time = static_cast<double>(tick) * period;
    runner.step(time_at(time));
    if (!arguments.json && !arguments.quiet) print_commands(runner, time);
    ended = find_fault(runner.system(), FaultKind::end_of_data).has_value();
    if (ended) break;
    const std::vector<VerdictReport> verdicts = judge(runner.system());
    observe_outputs(runner.system(), verdicts, summaries);
    agreement.observe(runner.system());
    if (features) features->add(runner.system(), time, verdicts);
    if (!arguments.picture.empty())
      if (auto drawn = picture_of(runner.system(), time)) picture = std::move(drawn);
    if (arguments.json)
      fmt::print("{}\n", json_text(tick_json(runner, time, verdicts), true));
    else if (!arguments.quiet)
      print_tick(runner.system(), time, verdicts);
    if (const auto lost = find_fault(runner.system(), FaultKind::device_lost)) {
      const NodeState& state = runner.system().node(*lost);
      fmt::print(stderr, "ilss: the run cannot go on: '{}': {}\n",
                 plan.nodes[state.origin.value_or(*lost)].name, state.outcome.fault().message);
      report_notes(runner.system());
      return exit_failed;
    }
  }
  if (interrupted != 0)
    fmt::print(stderr, "ilss: interrupted after {}\n", ticks_text(tick));
  else if (!ended && !arguments.ticks)
    fmt::print(stderr,
               "ilss: stopped after {}; --ticks N goes on, --ticks 0 to the end of the data\n",
               ticks_text(tick));
  report_waiting(runner.commander());
  report_notes(runner.system());
  if (!arguments.json) {
    fmt::print("\n{}{}\n", ticks_text(tick), ended ? ", to the end of the data" : "");
    if (const std::uint64_t refused = runner.commander().refused(); refused != 0)
      fmt::print("commands refused: {}\n", refused);
    print_outputs(runner, summaries);
    print_agreement(agreement, plan);
    print_latency(runner);
  }
  if (features) features->commit();
  if (!arguments.profile.empty()) write_profile_file(arguments.profile, runner);
  return arguments.picture.empty() ? exit_fine : write_picture_file(arguments, picture);
}

}  // namespace

void add_run(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* verb = app.add_subcommand("run", "Run a system over its input");
  verb->add_option("GRAPH", arguments->graph, "Graph file")->required();
  add_set_option(*verb, arguments->sets);
  verb->add_option("--command", arguments->commands,
                   "Give a command of the system before the first tick at that time (default 0 s)")
      ->type_name("NAME=VALUE[@TIME]")
      ->allow_extra_args(false);
  verb->add_option("--ticks", arguments->ticks,
                   "At most so many ticks; 0: to the end of the data (default 1000)")
      ->transform(whole_number(std::int64_t{0}, std::numeric_limits<std::int64_t>::max()));
  verb->add_option("--period", arguments->period, "Time from tick to tick")->capture_default_str();
  verb->add_option("--seed", arguments->seed, "Seed of all random numbers")
      ->transform(whole_number(std::uint64_t{0}, std::numeric_limits<std::uint64_t>::max()))
      ->capture_default_str();
  verb->add_option("--profile", arguments->profile, "Write the modules' measured times here")
      ->type_name("FILE")
      ->check(file_name());
  verb->add_option("--features", arguments->features,
                   "Write every feature with its covariance, as CSV or JSON by the file's name")
      ->type_name("FILE.csv|FILE.json")
      ->check(file_name());
  auto* picture = verb->add_option("--picture", arguments->picture,
                                   "Draw the last tick: scans, segments, edges and points, as SVG")
                      ->type_name("FILE")
                      ->check(file_name());
  verb->add_option("--picture-scale", arguments->picture_scale,
                   "Draw errors so many times as large as they are")
      ->type_name("N")
      ->capture_default_str()
      ->needs(picture);
  auto* quiet = verb->add_flag("--quiet", arguments->quiet, "Print the summary only");
  verb->add_flag("--json", arguments->json, "Print one JSON object a tick")->excludes(quiet);
  verb->callback([arguments, &session] { throw Exit{run(*arguments, session)}; });
}

}  // namespace ilss
