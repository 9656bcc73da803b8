#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "framework/report/estimate_text.h"
#include "framework/report/text_table.h"
#include "src/compare_report.h"

namespace ilss {
namespace {

/// Numbers of one column, shown with the same number of decimals. NaN is an empty cell's "-".
class NumberColumn {
 public:
  void add(double number) { numbers_.push_back(number); }

  /// The fewest decimals that show recorded numbers as they were written.
  int exact_decimals() const {
    constexpr int most = 4;
    int decimals = 0;
    for (const double number : numbers_)
      while (decimals < most && std::isfinite(number)) {
        const double scaled = number * std::pow(10.0, decimals);
        if (std::abs(scaled - std::round(scaled)) < 1e-6) break;
        ++decimals;
      }
    return decimals;
  }

  /// As many decimals as give the largest number three significant digits.
  int three_digits() const {
    double largest = 0;
    for (const double number : numbers_)
      if (std::isfinite(number)) largest = std::max(largest, std::abs(number));
    if (largest <= 0) return 0;
    return std::clamp(2 - static_cast<int>(std::floor(std::log10(largest))), 0, 6);
  }

 private:
  std::vector<double> numbers_;
};

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

std::string number_text(double number, int decimals) {
  if (std::isnan(number)) return "-";
  const std::string text = fmt::format("{:.{}f}", number, decimals);
  // "-0.0" is 0.
  return text.find_first_of("123456789") == std::string::npos && text.front() == '-'
             ? text.substr(1)
             : text;
}

std::string rms_text(double number) {
  if (std::isnan(number)) return "-";
  NumberColumn one;
  one.add(number);
  return number_text(number, one.three_digits());
}

ReadingUnit unit_of(const Study& study, std::size_t component) {
  return reading_unit(study.payload->components[component].unit);
}

/// A component's name with its reading unit behind `separator`.
std::string heading(const Study& study, std::size_t component, std::string_view separator) {
  const std::string unit = unit_of(study, component).name;
  const std::string& name = study.payload->components[component].name;
  return unit.empty() ? name : fmt::format("{}{}{}", name, separator, unit);
}

std::string requirement_text(const Study& study) {
  std::string text;
  for (std::size_t c = 0; c < study.requirement.size(); ++c) {
    if (!study.requirement[c]) continue;
    const Component& component = study.payload->components[c];
    text += fmt::format("{}{} within {}", text.empty() ? "" : ", ", component.name,
                        quantity_text(*study.requirement[c], component.unit));
  }
  return text;
}

std::string systems_title_text(const Study& study) {
  std::string text = study.name;
  if (!study.description.empty()) text += ": " + study.description;
  text += "\n";
  if (study.has_requirement()) text += fmt::format("required: {}\n", requirement_text(study));
  if (!study.recorded)
    text += fmt::format("measured: {} runs a case, seed {}{}\n", study.runs, study.seed,
                        study.draw_systematic_errors
                            ? ", random and systematic errors drawn in each run"
                            : ", random errors drawn in each run");
  return text + "\n";
}

std::string judgement_text(const Study& study, const CaseAlternative& alternative) {
  if (!alternative.judged) return alternative.measurement.outputs == 0 ? "no output" : "";
  if (alternative.measurement.outputs == 0) return "no output";
  if (alternative.meets_requirement) return "OK";
  std::string text = "misses";
  for (const Miss& miss : alternative.misses) {
    const Component& component = study.payload->components[miss.component];
    text += fmt::format("{} {} by {}", &miss == &alternative.misses.front() ? "" : ",",
                        component.name, quantity_text(miss.excess(), component.unit));
  }
  return text;
}

/// A component of the truth, in its reading unit.
double true_value(const Study& study, const ComparedCase& compared, std::size_t component) {
  if (compared.truth.empty()) return missing;
  return compared.truth[component] * unit_of(study, component).factor;
}

/// A figure of one component's errors, in its reading unit.
double error_figure(const Study& study, const CaseAlternative& alternative, std::size_t component,
                    double ComponentErrors::*figure) {
  const auto& errors = alternative.measurement.errors;
  if (errors.empty()) return missing;
  return errors[component].*figure * unit_of(study, component).factor;
}

double measured_value(const Study& study, const CaseAlternative& alternative,
                      std::size_t component) {
  if (alternative.measurement.value.empty()) return missing;
  return alternative.measurement.value[component] * unit_of(study, component).factor;
}

/// Columns of recorded values: the truth, then value and error of each alternative's components.
struct RecordedColumns {
  std::vector<int> truth;  ///< decimals, a component
  std::vector<int> value;  ///< decimals, an alternative and component
  std::vector<int> error;
};

RecordedColumns recorded_decimals(const Study& study, const Comparison& comparison) {
  RecordedColumns decimals;
  const std::size_t components = study.payload->dimension();
  for (std::size_t c = 0; c < components; ++c) {
    NumberColumn truth;
    for (const ComparedCase& compared : comparison.cases) truth.add(true_value(study, compared, c));
    decimals.truth.push_back(truth.exact_decimals());
  }
  for (std::size_t a = 0; a < study.alternatives.size(); ++a)
    for (std::size_t c = 0; c < components; ++c) {
      NumberColumn value;
      for (const ComparedCase& compared : comparison.cases)
        value.add(measured_value(study, compared.alternatives[a], c));
      decimals.value.push_back(value.exact_decimals());
      decimals.error.push_back(std::max(decimals.value.back(), decimals.truth[c]));
    }
  return decimals;
}

std::string recorded_table(const Study& study, const Comparison& comparison) {
  const std::size_t components = study.payload->dimension();
  TextTable table;
  table.column(study.case_noun, Align::left);
  for (std::size_t c = 0; c < components; ++c)
    table.column(heading(study, c, "\n"), Align::right, "truth");
  for (const std::string& name : study.alternatives) {
    for (std::size_t c = 0; c < components; ++c) {
      table.column(heading(study, c, "\n"), Align::right, name);
      table.column("error", Align::right, name);
    }
    if (study.has_requirement()) table.column("required", Align::left, name);
  }
  const RecordedColumns decimals = recorded_decimals(study, comparison);
  for (const ComparedCase& compared : comparison.cases) {
    std::vector<std::string> cells = {compared.name};
    for (std::size_t c = 0; c < components; ++c)
      cells.push_back(number_text(true_value(study, compared, c), decimals.truth[c]));
    for (std::size_t a = 0; a < study.alternatives.size(); ++a) {
      const CaseAlternative& alternative = compared.alternatives[a];
      for (std::size_t c = 0; c < components; ++c) {
        const std::size_t column = a * components + c;
        cells.push_back(number_text(measured_value(study, alternative, c), decimals.value[column]));
        cells.push_back(number_text(error_figure(study, alternative, c, &ComponentErrors::bias),
                                    decimals.error[column]));
      }
      if (study.has_requirement()) cells.push_back(judgement_text(study, alternative));
    }
    table.row(std::move(cells));
  }
  table.line();
  std::vector<std::string> cells = {"RMS"};
  cells.resize(1 + components);
  for (const AlternativeSummary& summary : comparison.summary) {
    for (std::size_t c = 0; c < components; ++c) {
      cells.emplace_back();
      cells.push_back(
          rms_text(summary.rms.empty() ? missing : summary.rms[c] * unit_of(study, c).factor));
    }
    if (study.has_requirement()) cells.emplace_back();
  }
  table.row(std::move(cells));
  return table.text();
}

/// The error of systems: a figure a column.
struct ErrorFigures {
  double truth, predicted, deviation, bias, rms;
};

ErrorFigures error_figures(const Study& study, const ComparedCase& compared, std::size_t a,
                           std::size_t component) {
  const CaseAlternative& alternative = compared.alternatives[a];
  const auto& predicted = alternative.prediction->standard_deviation;
  const auto figure = [&](double ComponentErrors::*which) {
    return error_figure(study, alternative, component, which);
  };
  return {true_value(study, compared, component),
          predicted.empty() ? missing : predicted[component] * unit_of(study, component).factor,
          figure(&ComponentErrors::standard_deviation), figure(&ComponentErrors::bias),
          figure(&ComponentErrors::rms)};
}

constexpr double ErrorFigures::*shown_figures[] = {&ErrorFigures::truth, &ErrorFigures::predicted,
                                                   &ErrorFigures::deviation, &ErrorFigures::bias,
                                                   &ErrorFigures::rms};
constexpr std::size_t figure_count = std::size(shown_figures);

/// Decimals of the error table's columns: each component's figures.
std::vector<int> error_decimals(const Study& study, const Comparison& comparison) {
  std::vector<int> decimals;
  for (std::size_t c = 0; c < study.payload->dimension(); ++c)
    for (const auto figure : shown_figures) {
      NumberColumn column;
      for (const ComparedCase& compared : comparison.cases)
        for (std::size_t a = 0; a < study.alternatives.size(); ++a)
          column.add(error_figures(study, compared, a, c).*figure);
      decimals.push_back(column.three_digits());
    }
  return decimals;
}

std::string share_inside_text(const CaseAlternative& alternative) {
  if (!alternative.judged) return "-";
  return fmt::format("{:.0f} %", 100.0 * static_cast<double>(alternative.measurement.inside) /
                                     static_cast<double>(alternative.measurement.runs));
}

std::vector<std::string> error_row(const Study& study, const ComparedCase& compared, std::size_t a,
                                   const std::vector<int>& decimals) {
  std::vector<std::string> cells = {a == 0 ? compared.name : "", study.alternatives[a]};
  for (std::size_t c = 0; c < study.payload->dimension(); ++c) {
    const ErrorFigures row = error_figures(study, compared, a, c);
    // The truth stands in a case's first row only.
    for (std::size_t f = 0; f < figure_count; ++f)
      cells.push_back(f == 0 && a > 0
                          ? ""
                          : number_text(row.*shown_figures[f], decimals[c * figure_count + f]));
  }
  if (study.has_requirement()) {
    cells.push_back(share_inside_text(compared.alternatives[a]));
    cells.push_back(judgement_text(study, compared.alternatives[a]));
  }
  return cells;
}

std::string error_table(const Study& study, const Comparison& comparison) {
  const std::size_t components = study.payload->dimension();
  TextTable table;
  table.column(study.case_noun, Align::left);
  table.column("alternative", Align::left);
  for (std::size_t c = 0; c < components; ++c)
    for (const char* word : {"true", "predicted", "sd", "bias", "RMS"})
      table.column(word, Align::right, heading(study, c, " in "));
  if (study.has_requirement()) {
    table.column("inside", Align::right, "required");
    table.column("RMS", Align::left, "required");
  }
  const std::vector<int> decimals = error_decimals(study, comparison);
  for (const ComparedCase& compared : comparison.cases)
    for (std::size_t a = 0; a < study.alternatives.size(); ++a)
      table.row(error_row(study, compared, a, decimals));
  table.line();
  for (std::size_t a = 0; a < study.alternatives.size(); ++a) {
    const AlternativeSummary& summary = comparison.summary[a];
    std::vector<std::string> cells = {a == 0 ? "all" : "", study.alternatives[a]};
    for (std::size_t c = 0; c < components; ++c) {
      cells.resize(cells.size() + figure_count - 1);
      cells.push_back(
          rms_text(summary.rms.empty() ? missing : summary.rms[c] * unit_of(study, c).factor));
    }
    table.row(std::move(cells));
  }
  return table.text() +
         "predicted: standard deviation expected before running; sd, bias, RMS: of the errors made"
         "\n";
}

std::string predicted_time_text(const CasePrediction& prediction) {
  if (prediction.time_known()) return duration_text(prediction.time.typical);
  if (prediction.time.typical <= 0) return "unknown";
  return fmt::format("over {}", duration_text(prediction.time.typical));
}

std::string trust_table(const Study& study, const Comparison& comparison) {
  const std::size_t components = study.payload->dimension();
  TextTable table;
  table.column(study.case_noun, Align::left);
  table.column("alternative", Align::left);
  table.column("outputs", Align::right);
  table.column("verdict", Align::left, "predicted");
  table.column("time", Align::right, "predicted");
  table.column("median", Align::right, "computed in");
  table.column("p99", Align::right, "computed in");
  table.column("per dof", Align::right, "NEES");
  table.column("99 % bounds", Align::right, "NEES");
  table.column("inside", Align::left, "NEES");
  for (std::size_t c = 0; c < components; ++c)
    table.column(study.payload->components[c].name, Align::right, "95 % coverage");
  for (const ComparedCase& compared : comparison.cases)
    for (std::size_t a = 0; a < study.alternatives.size(); ++a) {
      const CaseAlternative& alternative = compared.alternatives[a];
      const CaseMeasurement& measured = alternative.measurement;
      const CasePrediction& predicted = *alternative.prediction;
      constexpr double nanosecond = 1e-9;
      const LatencySummary time = measured.time->summary();
      std::vector<std::string> cells = {
          a == 0 ? compared.name : "",
          study.alternatives[a],
          fmt::format("{}/{}", measured.outputs, measured.runs),
          std::string(predicted.verdict ? verdict_name(predicted.verdict->verdict) : "-"),
          predicted_time_text(predicted),
          duration_text(static_cast<double>(time.p50) * nanosecond),
          duration_text(static_cast<double>(time.p99) * nanosecond)};
      if (measured.consistency.degrees_of_freedom() > 0) {
        const Interval bounds = measured.consistency.bounds(consistency_probability);
        cells.push_back(fmt::format("{:.3g}", measured.consistency.mean()));
        cells.push_back(fmt::format("{:.3f} .. {:.3f}", bounds.low, bounds.high));
        cells.emplace_back(measured.consistency.consistent(consistency_probability) ? "yes" : "NO");
      } else {
        cells.insert(cells.end(), {"-", "-", "-"});
      }
      for (std::size_t c = 0; c < components; ++c)
        cells.push_back(measured.errors.empty()
                            ? "-"
                            : fmt::format("{:.1f} %", 100 * measured.errors[c].coverage));
      table.row(std::move(cells));
    }
  return table.text() + "predicted time: typical, in one thread, as declared in the graphs\n";
}

/// What kept figures from the tables: faults of the truth, of predictions and of runs.
std::string notes_text(const Study& study, const Comparison& comparison) {
  std::string text;
  for (const ComparedCase& compared : comparison.cases) {
    const std::string where = fmt::format("{} {}", study.case_noun, compared.name);
    if (compared.truth_fault)
      text += fmt::format("{}: no truth, so nothing is judged: {} ({})\n", where,
                          compared.truth_fault->message, fault_name(compared.truth_fault->kind));
    for (std::size_t a = 0; a < study.alternatives.size(); ++a) {
      const CaseAlternative& alternative = compared.alternatives[a];
      if (alternative.prediction && alternative.prediction->fault)
        text += fmt::format("{}, {}: no prediction: {} ({})\n", where, study.alternatives[a],
                            alternative.prediction->fault->message,
                            fault_name(alternative.prediction->fault->kind));
      for (const auto& [kind, fault] : alternative.measurement.faults)
        text += study.recorded
                    ? fmt::format("{}, {}: {} ({})\n", where, study.alternatives[a], fault.message,
                                  fault_name(kind))
                    : fmt::format("{}, {}: {} of {} runs gave {}: {}\n", where,
                                  study.alternatives[a], fault.count, alternative.measurement.runs,
                                  fault_name(kind), fault.message);
    }
  }
  return text;
}

/// What a case misses, in words: "pose 7 misses it: range is off by -304 mm, 4 mm too much".
std::string miss_sentence(const Study& study, const ComparedCase& compared, std::size_t a) {
  const CaseAlternative& alternative = compared.alternatives[a];
  std::string text = fmt::format("{} {} misses it:", study.case_noun, compared.name);
  if (alternative.measurement.outputs == 0) return text + " no output";
  for (const Miss& miss : alternative.misses) {
    const Component& component = study.payload->components[miss.component];
    text += fmt::format("{} {} is off by {}{}, {} too much",
                        &miss == &alternative.misses.front() ? "" : ";", component.name,
                        quantity_text(std::abs(miss.error), component.unit),
                        study.recorded ? "" : " RMS", quantity_text(miss.excess(), component.unit));
  }
  return text;
}

std::string judgement_sentences(const Study& study, const Comparison& comparison) {
  constexpr std::int64_t most_listed = 5;
  std::string text;
  for (std::size_t a = 0; a < study.alternatives.size(); ++a) {
    const AlternativeSummary& summary = comparison.summary[a];
    text += fmt::format("{}: {} of {} {}s meet the requirement", study.alternatives[a], summary.met,
                        comparison.cases.size(), study.case_noun);
    std::int64_t listed = 0;
    for (const ComparedCase& compared : comparison.cases) {
      const CaseAlternative& alternative = compared.alternatives[a];
      if (!alternative.judged || alternative.meets_requirement || ++listed > most_listed) continue;
      text += "; " + miss_sentence(study, compared, a);
    }
    if (listed > most_listed) text += fmt::format("; and {} more", listed - most_listed);
    const auto unjudged = static_cast<std::int64_t>(comparison.cases.size()) - summary.judged;
    if (unjudged > 0) text += fmt::format("; {} could not be judged", unjudged);
    text += ".\n";
  }
  return text;
}

}  // namespace

std::string comparison_text(const Study& study, const Comparison& comparison) {
  std::string text = systems_title_text(study);
  text += study.recorded ? recorded_table(study, comparison)
                         : error_table(study, comparison) + "\n" + trust_table(study, comparison);
  const std::string notes = notes_text(study, comparison);
  if (!notes.empty()) text += "\n" + notes;
  if (study.has_requirement()) text += "\n" + judgement_sentences(study, comparison);
  return text;
}

}  // namespace ilss
