// `ilss run`: a system over its input, with its instruments.
#include "framework/runtime/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "framework/estimate/units.h"
#include "framework/report/feature_file.h"
#include "framework/report/picture_svg.h"
#include "framework/report/run_summary.h"
#include "framework/report/tick_json.h"
#include "framework/report/tick_text.h"
#include "src/output_file.h"
#include "src/picture_scene.h"
#include "src/session.h"

namespace ilss {
namespace {

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free);  // set by a signal's handler

/// Where no --ticks is given, a run without end stops here.
constexpr std::int64_t default_ticks = 1000;
constexpr const char* default_period = "100 ms";
constexpr double longest_period = 1e6;  // s
constexpr unsigned most_threads = 1024;
constexpr double least_picture_scale = 1e-3;
constexpr double most_picture_scale = 1e6;

struct RunArguments {
  std::string graph;
  std::vector<std::string> sets;
  std::vector<std::string> commands;
  std::optional<std::int64_t> ticks = {};
  std::string time = "period";
  std::string period;  ///< empty: the default
  std::uint64_t seed = 1;
  unsigned threads = 1;
  std::string verdict;
  std::string profile;
  std::string features;
  std::string picture;
  double picture_scale = 1;
  bool json = false;
  bool quiet = false;
};

/// Leaves the run after the tick at the first Ctrl-C; the second ends the command, so that a run
/// that hangs in a tick can be ended, too.
void end_run_at_interrupt() {
  struct sigaction action = {};
  action.sa_handler = [](int) { interrupted = true; };
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, nullptr);
}

/// Prints every tick, with the verdicts on what it prints.
class TickPrinter final : public Observer {
 public:
  explicit TickPrinter(bool as_json) : as_json_(as_json) {}
  OutputRange wants_verdicts(const TickView& tick) override { return {0, tick.outputs()}; }
  void observe(const TickView& tick) override {
    fmt::print("{}", as_json_ ? json_text(tick_json(tick), true) + "\n" : tick_text(tick));
  }

 private:
  bool as_json_;
};

/// The payload of the plan's one output, which must be a set, as --features writes it.
const PayloadDescriptor& set_of(const Plan& plan) {
  if (plan.outputs.size() != 1)
    fail(exit_bad_input,
         fmt::format("--features: the graph gives {} outputs; expected one, a set of features",
                     plan.outputs.size()));
  const PayloadDescriptor& payload = *plan.nodes[plan.outputs.front()].interface.output;
  if (payload.element.empty())
    fail(exit_bad_input,
         fmt::format("--features: the graph gives {}, which is no set of features", payload.name));
  return payload;
}

/// The format that a file's name says; must fit the set.
FeatureFile::Format feature_format(const std::string& path, const PayloadDescriptor& set) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension == ".json") return FeatureFile::Format::json;
  if (extension != ".csv")
    fail(exit_bad_input,
         fmt::format("--features: '{}' ends neither in .csv nor in .json, so its format is unknown",
                     path));
  if (set.elements.empty())
    fail(exit_bad_input, fmt::format("--features: {} does not declare its elements, so a CSV file "
                                     "has no columns; .json takes it",
                                     set.name));
  return FeatureFile::Format::csv;
}

/// Keeps the picture of the last tick that had something to draw.
class PictureTaker final : public Observer {
 public:
  explicit PictureTaker(const System& system) : system_(system) {}
  void observe(const TickView& tick) override {
    auto drawn = picture_of(
        tick, [&](std::size_t node) { return scene_behind(system_, node, seconds(tick.time())); });
    if (drawn) picture_ = std::move(drawn);
  }
  const std::optional<Picture>& picture() const { return picture_; }

 private:
  const System& system_;
  std::optional<Picture> picture_;
};

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
void report_waiting(const Run& run) {
  if (const std::size_t waiting = run.waiting_commands(); waiting != 0)
    fmt::print(stderr, "ilss: the run ended before the time of {} command{}\n", waiting,
               waiting == 1 ? "" : "s");
}

/// What the modules have to say of their data.
void report_notes(const System& system) {
  for (std::size_t i = 0; i < system.size(); ++i)
    if (const std::string note = system.note(i); !note.empty())
      fmt::print(stderr, "ilss: '{}': {}\n", system.plan().nodes[i].name, note);
}

Duration read_period(const RunArguments& arguments) {
  if (arguments.time == "log" && !arguments.period.empty())
    fail(exit_bad_input, "--period: with --time log the data say when the ticks are");
  const auto period =
      parse_quantity(arguments.period.empty() ? default_period : arguments.period, "s");
  if (const auto* error = std::get_if<std::string>(&period))
    fail(exit_bad_input, "--period: " + *error);
  const Duration duration = duration_of(std::get<double>(period));
  if (!(duration.count() > 0 && std::get<double>(period) <= longest_period))
    fail(exit_bad_input,
         fmt::format("--period must be above 0 and at most {:.0f} s", longest_period));
  return duration;
}

Pacing read_pacing(const std::string& time) {
  if (time == "log") return Pacing::data;
  return time == "real" ? Pacing::real : Pacing::simulated;
}

/// Which ticks are judged. By default observers say so; but verdicts between its ticks would be in
/// what a profile measures, since they leave the processor's caches to others.
std::optional<std::int64_t> read_verdict_rate(const RunArguments& arguments) {
  if (arguments.verdict.empty())
    return arguments.profile.empty() ? std::nullopt : std::optional<std::int64_t>(0);
  if (arguments.verdict == "every") return 1;
  if (arguments.verdict == "off") return 0;
  return std::stoll(arguments.verdict);
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

/// Before a run: each of its files can be written, and no two are one.
void check_files(const RunArguments& arguments) {
  const std::array<std::pair<const char*, const std::string*>, 3> files{
      {{"--profile", &arguments.profile},
       {"--picture", &arguments.picture},
       {"--features", &arguments.features}}};
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (files[i].second->empty()) continue;
    check_file(files[i].first, *files[i].second, arguments.graph);
    std::error_code ignored;
    for (std::size_t j = 0; j < i; ++j)
      if (!files[j].second->empty() &&
          std::filesystem::weakly_canonical(*files[i].second, ignored) ==
              std::filesystem::weakly_canonical(*files[j].second, ignored))
        fail(exit_bad_input, fmt::format("{}: '{}' is the file of {}, too", files[i].first,
                                         *files[i].second, files[j].first));
  }
}

/// Accepts `every`, `off`, or one in how many.
OptionCheck verdict_rate() {
  return [](const std::string& text) -> std::string {
    std::int64_t ticks = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), ticks);
    if (text == "every" || text == "off" ||
        (error == std::errc{} && end == text.data() + text.size() && ticks > 0))
      return "";
    return fmt::format("'{}' is neither every, nor off, nor a number of ticks above 0", text);
  };
}

OptionCheck file_name() {
  return [](const std::string& file) -> std::string {
    return file.empty() ? "the file's name is empty" : "";
  };
}

void write_profile_file(const std::string& path, const Runner& runner) {
  std::ofstream file(path);
  write_profile(runner.profile(), file);
  if (!file.flush()) fail(exit_failed, fmt::format("cannot write the profile '{}'", path));
}

/// Writes the picture of the last tick that had something to draw.
int write_picture_file(const RunArguments& arguments, const std::optional<Picture>& picture) {
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

/// What there is to say of a run's end besides its summary.
void report_end(const Run& run, const RunArguments& arguments) {
  const Ending& ending = *run.ending();
  if (ending.reason == RunEnd::device_lost)
    fmt::print(stderr, "ilss: the run cannot go on: '{}': {}\n", ending.module->name,
               ending.fault.message);
  else if (ending.reason == RunEnd::interrupted)
    fmt::print(stderr, "ilss: interrupted after {}\n", ticks_text(run.ticks()));
  else if (ending.reason == RunEnd::most_ticks && !arguments.ticks)
    fmt::print(stderr,
               "ilss: stopped after {}; --ticks N goes on, --ticks 0 to the end of the data\n",
               ticks_text(run.ticks()));
  if (ending.reason != RunEnd::device_lost) report_waiting(run);
  report_notes(run.runner().system());
}

RunOptions read_options(const RunArguments& arguments, const Plan& plan) {
  return {.pacing = read_pacing(arguments.time),
          .period = read_period(arguments),
          .most_ticks = arguments.ticks.value_or(default_ticks),
          .seed = arguments.seed,
          .threads = arguments.threads,
          .judge_every = read_verdict_rate(arguments),
          .commands = read_commands(arguments.commands, plan),
          .interrupted = &interrupted};
}

int run(const RunArguments& arguments, Session& session) {
  session.load_modules();
  check_picture_scale(arguments.picture_scale);
  const Plan plan = session.read_graph(arguments.graph, arguments.sets);
  RunOptions options = read_options(arguments, plan);
  check_files(arguments);
  std::optional<OutputFile> feature_file;
  std::optional<FeatureFile> features;
  if (!arguments.features.empty()) {
    const PayloadDescriptor& set = set_of(plan);
    const FeatureFile::Format format = feature_format(arguments.features, set);
    features.emplace(feature_file.emplace(arguments.features).stream(), format, set);
  }

  Run run(plan, std::move(options));
  RunSummary summary(plan, arguments.quiet);
  TickPrinter printer(arguments.json);
  PictureTaker pictures(run.runner().system());
  run.add(summary);
  if (features) run.add(*features);
  if (!arguments.picture.empty()) run.add(pictures);
  if (!arguments.quiet) run.add(printer);
  Diagnostics diagnostics;
  if (!run.open(diagnostics)) report_and_exit(diagnostics);
  end_run_at_interrupt();
  const Ending& ending = run.finish();

  report_end(run, arguments);
  if (ending.reason == RunEnd::device_lost) return exit_failed;
  if (!arguments.json) fmt::print("{}", summary_text(run, summary));
  if (features) {
    features->finish();
    feature_file->commit();
  }
  if (!arguments.profile.empty()) write_profile_file(arguments.profile, run.runner());
  return arguments.picture.empty() ? exit_fine : write_picture_file(arguments, pictures.picture());
}

}  // namespace

void add_run(Verb command, Session& session) {
  const auto arguments = std::make_shared<RunArguments>();
  Verb verb = command.add_verb("run", "Run a system over its input");
  verb.add_option("GRAPH", arguments->graph, "Graph file").required();
  verb.add_set_option(arguments->sets);
  verb.add_option("--command", arguments->commands,
                  "Give a command of the system before the first tick at that time (default 0 s)")
      .type_name("NAME=VALUE[@TIME]")
      .one_value_each();
  verb.add_option("--ticks", arguments->ticks,
                  "At most so many ticks; 0: to the end of the data (default 1000)")
      .check(whole_number(std::int64_t{0}, std::numeric_limits<std::int64_t>::max()));
  verb.add_option("--time", arguments->time,
                  "Where ticks come from: a period in simulated time, the real clock, or the times "
                  "at which the data of a log were acquired")
      .one_of({"period", "real", "log"})
      .show_default();
  verb.add_option("--period", arguments->period,
                  fmt::format("Time from tick to tick (default {})", default_period));
  verb.add_option("--seed", arguments->seed, "Seed of all random numbers")
      .check(whole_number(std::uint64_t{0}, std::numeric_limits<std::uint64_t>::max()))
      .show_default();
  verb.add_option("--threads", arguments->threads,
                  "Evaluate modules that do not depend on each other side by side")
      .check(whole_number(1U, most_threads))
      .show_default();
  verb.add_option("--verdict", arguments->verdict,
                  "Judge the outputs of every tick, of one in N, or of none (default: of those "
                  "printed, with --quiet of ever fewer, with --profile of none)")
      .type_name("every|N|off")
      .check(verdict_rate());
  verb.add_option("--profile", arguments->profile, "Write the modules' measured times here")
      .type_name("FILE")
      .check(file_name());
  verb.add_option("--features", arguments->features,
                  "Write every feature with its covariance, as CSV or JSON by the file's name")
      .type_name("FILE.csv|FILE.json")
      .check(file_name());
  const Option picture =
      verb.add_option("--picture", arguments->picture,
                      "Draw the last tick: scans, segments, edges and points, as SVG")
          .type_name("FILE")
          .check(file_name());
  verb.add_option("--picture-scale", arguments->picture_scale,
                  "Draw errors so many times as large as they are")
      .type_name("N")
      .show_default()
      .needs(picture);
  const Option quiet = verb.add_flag("--quiet", arguments->quiet, "Print the summary only");
  verb.add_flag("--json", arguments->json, "Print one JSON object a tick").excludes(quiet);
  verb.on_call([arguments, &session] { throw Exit{run(*arguments, session)}; });
}

}  // namespace ilss
