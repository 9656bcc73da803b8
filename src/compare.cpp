// `ilss compare`: alternatives side by side, predicted and measured, against truth and requirement.
#include <fmt/format.h>

#include <cstdint>
#include <limits>

#include "src/compare_report.h"
#include "src/session.h"

namespace ilss {
namespace {

struct CompareArguments {
  std::string study;
  std::optional<std::int64_t> runs;
  std::optional<std::uint64_t> seed;
  bool enforce = false;
  bool json = false;
};

int compare_study(const CompareArguments& arguments, Session& session) {
  session.load_modules();
  Diagnostics diagnostics;
  auto study = read_study(arguments.study, session.registry, diagnostics);
  if (!diagnostics.empty() || !study) report_and_exit(diagnostics);
  if (arguments.enforce && !study->has_requirement())
    fail(exit_bad_input, fmt::format("--enforce: {} states no requirement", arguments.study));
  if (study->recorded && (arguments.runs || arguments.seed))
    fail(exit_bad_input, fmt::format("--runs and --seed are for studies of graphs; {} compares "
                                     "recordings",
                                     arguments.study));
  if (arguments.runs) study->runs = *arguments.runs;
  if (arguments.seed) study->seed = *arguments.seed;
  if (study->compares_sets()) {
    const std::vector<SetCase> cases = compare_sets(*study);
    if (arguments.json)
      fmt::print("{}\n", json_text(set_comparison_json(*study, cases)));
    else
      fmt::print("{}", set_comparison_text(*study, cases));
    return exit_fine;
  }
  const Comparison comparison = compare(*study);
  if (arguments.json)
    fmt::print("{}\n", json_text(comparison_json(*study, comparison)));
  else
    fmt::print("{}", comparison_text(*study, comparison));
  return arguments.enforce && !comparison.requirement_met ? exit_failed : exit_fine;
}

}  // namespace

void add_compare(Verb command, Session& session) {
  const auto arguments = std::make_shared<CompareArguments>();
  Verb verb = command.add_verb(
      "compare", "Alternatives side by side: predicted, run, judged against truth and requirement");
  verb.add_option("STUDY", arguments->study, "Study file").required();
  verb.add_option("--runs", arguments->runs, "Runs of each system in each case")
      .check(whole_number(std::int64_t{1}, std::int64_t{1'000'000'000}));
  verb.add_option("--seed", arguments->seed, "Seed of the random errors")
      .check(whole_number(std::uint64_t{0}, std::numeric_limits<std::uint64_t>::max()));
  verb.add_flag("--enforce", arguments->enforce,
                "Exit with 1 where an alternative misses the requirement");
  verb.add_flag("--json", arguments->json, "Print JSON");
  verb.on_call([arguments, &session] { throw Exit{compare_study(*arguments, session)}; });
}

}  // namespace ilss
