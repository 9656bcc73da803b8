#include <fmt/format.h>

#include <cmath>

#include "framework/report/estimate_text.h"
#include "framework/report/text_table.h"
#include "src/compare_report.h"

namespace ilss {
namespace {

/// Three significant digits, without an exponent: "0.0123", "12.3", "1230".
std::string three_digits(double number) {
  if (!std::isfinite(number)) return "-";
  const double size = std::abs(number);
  const int decimals = size > 0 ? 2 - static_cast<int>(std::floor(std::log10(size))) : 2;
  return decimal_text(number, std::clamp(decimals, 0, 6));
}

std::string percent(double share) { return fmt::format("{:.1f} %", 100 * share); }

std::string sets_title_text(const Study& study) {
  std::string text = study.name;
  if (!study.description.empty()) text += ": " + study.description;
  return text + fmt::format("\nmeasured: {} ticks a case, seed {}, the same for all alternatives\n",
                            study.runs, study.seed);
}

/// How a payload's elements are matched, in words.
std::string rule_text(const ElementRule& rule) {
  std::string text = rule.type->name;
  for (const auto& [label, value] : rule.only) {
    const Label& named = rule.type->labels[label];
    text += fmt::format(", {} {}", named.name, named.values[static_cast<std::size_t>(value)]);
  }
  return text + (rule.interval
                     ? fmt::format(" (matched where readings overlap by {:g})", rule.overlap)
                     : fmt::format(" (matched within {})", quantity_text(rule.gate, "m")));
}

void add_columns(const Study& study, const ElementRule& rule, TextTable& table) {
  table.column("alternative", Align::left);
  for (const char* heading : {"found", "TruePos", "FalsePos"}) table.column(heading);
  if (study.cases.front().tolerated) table.column("tolerated");
  for (const std::size_t c : rule.judged) {
    const Component& component = rule.type->components[c];
    const std::string group =
        fmt::format("{} in {}", component.name, reading_unit(component.unit).name);
    table.column("sd", Align::right, group);
    table.column("median", Align::right, group);
    if (study.reference) table.column("rel.", Align::right, group);
  }
  if (!rule.interval) table.column("median\ndistance");
  table.column("mean", Align::right, "NEES");
  table.column("99 % bounds", Align::right, "NEES");
  table.column("inside\n95 %");
  if (study.validation_gate) table.column(fmt::format("inside\n{:g}", *study.validation_gate));
  table.column("time\np50");
}

void add_errors(const Study& study, const ElementRule& rule, const ElementScore& score,
                std::vector<std::string>& cells) {
  for (std::size_t j = 0; j < rule.judged.size(); ++j) {
    const double factor = reading_unit(rule.type->components[rule.judged[j]].unit).factor;
    cells.push_back(
        score.errors.empty() ? "-" : three_digits(score.errors[j].standard_deviation * factor));
    cells.push_back(score.errors.empty() ? "-" : three_digits(score.errors[j].median * factor));
    if (study.reference)
      cells.push_back(score.relative_deviation.empty()
                          ? "-"
                          : fmt::format("{:.2f}", score.relative_deviation[j]));
  }
}

std::vector<std::string> row_of(const Study& study, std::size_t a, const ElementRule& rule,
                                const ElementScore& score, const LatencyHistogram& time) {
  std::vector<std::string> cells = {study.alternatives[a], std::to_string(score.found),
                                    percent(score.true_positive()),
                                    percent(score.false_positive())};
  if (study.cases.front().tolerated) cells.push_back(std::to_string(score.tolerated));
  add_errors(study, rule, score, cells);
  if (!rule.interval)
    cells.push_back(score.matched > 0 ? quantity_text(score.median_distance, "m") : "-");
  if (score.consistency.degrees_of_freedom() > 0) {
    const Interval bounds = score.nees_bounds(consistency_probability);
    cells.push_back(fmt::format("{:.2f}", score.mean_nees()));
    cells.push_back(fmt::format("{:.2f} .. {:.2f}", bounds.low, bounds.high));
  } else {
    cells.insert(cells.end(), {"-", "-"});
  }
  cells.push_back(score.matched > 0 ? percent(score.inside_95_share()) : "-");
  if (study.validation_gate)
    cells.push_back(score.matched > 0 ? percent(score.inside_gate_share()) : "-");
  constexpr double nanosecond = 1e-9;
  cells.push_back(duration_text(static_cast<double>(time.quantile(0.5)) * nanosecond));
  return cells;
}

std::string score_table(const Study& study, const SetCase& compared, std::size_t element) {
  const ElementRule& rule = study.judged[element];
  TextTable table;
  add_columns(study, rule, table);
  for (std::size_t a = 0; a < study.alternatives.size(); ++a)
    table.row(row_of(study, a, rule, compared.alternatives[a].scores[element],
                     compared.alternatives[a].time));
  return fmt::format("\n{} {}: {} true {}\n{}", study.case_noun, compared.name,
                     compared.alternatives.front().scores[element].truth, rule_text(rule),
                     table.text());
}

/// Ticks that gave no set.
std::string notes_text(const Study& study, const SetCase& compared) {
  std::string text;
  const auto note = [&](std::string_view who, const std::map<FaultKind, FaultCount>& faults) {
    for (const auto& [kind, fault] : faults)
      text += fmt::format("{} {}, {}: {} of {} ticks gave {}: {}\n", study.case_noun, compared.name,
                          who, fault.count, study.runs, fault_name(kind), fault.message);
  };
  note("truth", compared.truth_faults);
  for (std::size_t a = 0; a < study.alternatives.size(); ++a)
    note(study.alternatives[a], compared.alternatives[a].faults);
  return text;
}

std::string legend_text(const Study& study) {
  std::string text =
      "TruePos: share of the true that was found; FalsePos: share of the found that is "
      "not true";
  if (study.cases.front().tolerated) text += " (nor tolerated)";
  text += "\nsd, median: of the errors of matches, the median of their sizes";
  if (study.reference)
    text += fmt::format("; rel.: sd over that of {}, of the matches that both have",
                        study.alternatives[*study.reference]);
  text += "\ninside: share of matches in the stated covariance's 95 % ellipse";
  if (study.validation_gate)
    text += fmt::format(", and in that of chi-square {:g}", *study.validation_gate);
  return text + "\ntime: of all modules but simulated sensors\n";
}

}  // namespace

std::string set_comparison_text(const Study& study, const std::vector<SetCase>& cases) {
  std::string text = sets_title_text(study);
  std::string notes;
  for (const SetCase& compared : cases) {
    for (std::size_t e = 0; e < study.judged.size(); ++e) text += score_table(study, compared, e);
    notes += notes_text(study, compared);
  }
  text += "\n" + legend_text(study);
  if (!notes.empty()) text += "\n" + notes;
  return text;
}

}  // namespace ilss
