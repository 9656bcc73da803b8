// `ilss calibrate laser`: the systematic error of a laser's ranges.
#include <fmt/format.h>

#include <cmath>

#include "framework/estimate/consistency.h"
#include "framework/report/estimate_json.h"
#include "framework/report/text_table.h"
#include "sensors/laser/acquire/laser_calibration.h"
#include "sensors/laser/acquire/laser_correction.h"
#include "src/calibration_output.h"
#include "src/calibration_table.h"
#include "src/session.h"

namespace ilss {
namespace {

struct Arguments {
  std::string file;
  std::string output;
  int order = 6;
  bool json = false;
  bool force = false;
};

struct Report {
  const Arguments& arguments;
  LaserCalibration calibration;
  int largest_line = 0;
};

double deviation(const LaserCalibration& calibration, int k) {
  return std::sqrt(calibration.covariance(k, k));
}

/// What the polynomial says at a range, and how sure of that it is (m).
std::pair<double, double> bias_at(const LaserCalibration& calibration, double range) {
  Eigen::Matrix<double, 1, range_biases> powers;
  double power = 1;
  for (Eigen::Index k = 0; k < powers.size(); ++k, power *= range / calibration.reference)
    powers[k] = power;
  return {range_bias(calibration.bias, range / calibration.reference),
          std::sqrt((powers * calibration.covariance * powers.transpose()).value())};
}

std::string misfit_text(const LaserCalibration& calibration) {
  if (!calibration.noise_is_stated)
    return fmt::format("range_std    {:.3g} mm, from the residuals: none was stated\n",
                       1e3 * calibration.range_std);
  const double degrees = calibration.degrees_of_freedom();
  const Interval bounds = chi_square_interval(degrees, 0.99);
  return fmt::format(
      "chi-squared {:.1f} of {:.0f} degrees of freedom: {:.3f}, 99 % bounds {:.3f} .. {:.3f}: the "
      "polynomial and the stated noise {} with the ranges\n",
      calibration.chi_squared, degrees, calibration.chi_squared / degrees, bounds.low / degrees,
      bounds.high / degrees, bounds.contains(calibration.chi_squared) ? "agree" : "do NOT agree");
}

std::string report_text(const Report& report) {
  const LaserCalibration& calibration = report.calibration;
  std::string text =
      fmt::format("{}: {} ranges, {:.3f} to {:.3f} m\n\n", report.arguments.file,
                  calibration.points, calibration.least_range, calibration.reference);
  TextTable table;
  table.column("range (m)");
  table.column("too long by (mm)");
  table.column("sd (mm)");
  constexpr int rows = 8;
  for (int i = 0; i <= rows; ++i) {
    const double range =
        calibration.least_range + (calibration.reference - calibration.least_range) * i / rows;
    const auto [bias, sd] = bias_at(calibration, range);
    table.row({fmt::format("{:.3f}", range), fmt::format("{:+.2f}", 1e3 * bias),
               fmt::format("{:.2f}", 1e3 * sd)});
  }
  text += table.text() + "\n" + misfit_text(calibration);
  return text + fmt::format(
                    "measured less true: {:.3g} mm rms before, {:.3g} mm after, largest {:+.3g} mm "
                    "(line {})\n",
                    1e3 * calibration.uncorrected, 1e3 * calibration.range_std,
                    1e3 * calibration.largest, report.largest_line);
}

Json report_json(const Report& report) {
  const LaserCalibration& calibration = report.calibration;
  Json parameters = Json::array();
  Json covariance = Json::array();
  for (int i = 0; i < static_cast<int>(range_biases); ++i) {
    parameters.push_back({{"name", range_bias_names[static_cast<std::size_t>(i)]},
                          {"unit", "m"},
                          {"value", calibration.bias[static_cast<std::size_t>(i)]},
                          {"std", deviation(calibration, i)}});
    Json row = Json::array();
    for (int j = 0; j < static_cast<int>(range_biases); ++j)
      row.push_back(calibration.covariance(i, j));
    covariance.push_back(std::move(row));
  }
  Json json = {{"calibration", "laser"},
               {"ranges", calibration.points},
               {"order", calibration.order},
               {"least_range", calibration.least_range},
               {"bias_range", calibration.reference},
               {"parameters", std::move(parameters)},
               {"covariance", std::move(covariance)},
               {"range_std", calibration.range_std},
               {"residuals",
                {{"unit", "m"},
                 {"rms", calibration.range_std},
                 {"rms_before", calibration.uncorrected},
                 {"largest", calibration.largest},
                 {"largest_line", report.largest_line}}}};
  if (calibration.noise_is_stated) {
    json["chi_squared"] = calibration.chi_squared;
    json["degrees_of_freedom"] = calibration.degrees_of_freedom();
  }
  return json;
}

/// A vector constant with its covariance; bias_range is exact.
std::string report_yaml(const Report& report) {
  const LaserCalibration& calibration = report.calibration;
  std::string text = fmt::format(
      "# Laser, calibrated on {} ranges of {:.3f} to {:.3f} m; sd about the polynomial {:.3g} mm.\n"
      "# A graph takes it as constants: {{ranges: {{file: ...}}}} and then $ranges.bias_0, ...\n"
      "value:\n",
      calibration.points, calibration.least_range, calibration.reference,
      1e3 * calibration.range_std);
  for (std::size_t k = 0; k < range_biases; ++k)
    text += fmt::format("  {}: {:.15g} m\n", range_bias_names[k], calibration.bias[k]);
  text += fmt::format("  bias_range: {:.15g} m\ncovariance:  # in m²\n", calibration.reference);
  constexpr auto size = static_cast<Eigen::Index>(range_biases);
  for (Eigen::Index i = 0; i <= size; ++i) {
    std::vector<double> row;
    for (Eigen::Index j = 0; j <= size; ++j)
      row.push_back(i < size && j < size ? calibration.covariance(std::min(i, j), std::max(i, j))
                                         : 0);
    text += fmt::format("  - [{:.17g}]\n", fmt::join(row, ", "));
  }
  return text;
}

std::vector<CalibrationRange> read_ranges(const std::string& file, std::vector<Position>& rows,
                                          Diagnostics& diagnostics) {
  static constexpr std::array<TableColumn, 3> columns = {
      {{"measured", "m", true},
       {"true", "m", true},
       {.name = "range_std", .unit = "m", .positive = true, .optional = true}}};
  CalibrationTable table = read_calibration_table(file, columns, diagnostics);
  std::vector<CalibrationRange> ranges;
  if (!diagnostics.empty()) return ranges;
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    ranges.push_back({table.columns[0][i], table.columns[1][i],
                      table.columns[2].empty() ? 0 : table.columns[2][i]});
  rows = std::move(table.rows);
  return ranges;
}

void calibrate(const Arguments& arguments) {
  check_output_file("--output", arguments.output, {arguments.file});
  Diagnostics diagnostics;
  std::vector<Position> rows;
  const auto ranges = read_ranges(arguments.file, rows, diagnostics);
  if (!diagnostics.empty()) report_and_exit(diagnostics);
  const auto calibration = calibrate_laser(ranges, arguments.order);
  if (!calibration) refuse(arguments.file, calibration.fault());
  const Report report{arguments, *calibration, rows[calibration->largest_at].line};
  const double misfit = calibration->chi_squared / calibration->degrees_of_freedom();
  const bool fits = misfit < most_chi_squared || arguments.force;
  if (fits) write_file(arguments.output, report_yaml(report));
  fmt::print("{}", arguments.json ? json_text(report_json(report)) + "\n" : report_text(report));
  if (!fits)
    fail(exit_failed, fmt::format("the polynomial does not fit: chi-squared is {:.3g} a degree of "
                                  "freedom, and line {} lies farthest off; are the units right? "
                                  "Nothing is written without --force",
                                  misfit, report.largest_line));
}

}  // namespace

void add_calibrate_laser(Verb calibrate_verb) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = calibrate_verb.add_verb(
      "laser", "Laser range finder: the systematic error of its ranges, a polynomial");
  verb.add_option("DATA", arguments->file,
                  "CSV file with the columns measured and true, and range_std where it is known, "
                  "each with its unit: 'measured [m]'")
      .required();
  verb.add_option("--order", arguments->order, "Of the polynomial (default 6)")
      .check(whole_number(0, 6));
  verb.add_option("--output", arguments->output, "Write a YAML file that a graph's constants take")
      .type_name("FILE");
  verb.add_flag("--json", arguments->json, "Print JSON");
  verb.add_flag("--force", arguments->force, "Write a polynomial that does not fit, too");
  verb.on_call([arguments] { calibrate(*arguments); });
}

}  // namespace ilss
