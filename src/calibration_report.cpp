#include "src/calibration_report.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "framework/estimate/consistency.h"
#include "framework/report/text_table.h"

namespace ilss {
namespace {

constexpr std::size_t parameter_count = lep_calibration_names.size();
constexpr double bounds_probability = 0.99;

/// The unit that people read a parameter in, and how many of it an SI unit is.
struct ShownUnit {
  const char* name;
  double per_si;
};
ShownUnit shown_unit(std::size_t parameter) {
  if (lep_calibration_units[parameter] == "rad") return {"deg", 180 / std::numbers::pi};
  return {"mm", 1e3};
}

double deviation(const LepCalibration& calibration, std::size_t parameter) {
  const auto i = static_cast<Eigen::Index>(parameter);
  return std::sqrt(calibration.covariance(i, i));
}

double correlation(const LepCalibration& calibration, std::size_t a, std::size_t b) {
  const double scale = deviation(calibration, a) * deviation(calibration, b);
  if (scale == 0) return a == b ? 1 : 0;
  return calibration.covariance(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) / scale;
}

std::optional<double> linear_value(const LepCalibration& calibration, std::size_t parameter) {
  if (!calibration.linear || parameter >= 4) return std::nullopt;
  const LepGeometry<double>& g = calibration.linear->geometry;
  return std::array<double, 4>{g.focal_length, g.baseline, g.vergence, g.lens_distance}[parameter];
}

/// As many decimals as leave two digits of the sd.
int decimals(double standard_deviation) {
  if (!(standard_deviation > 0)) return 4;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(standard_deviation))), 0, 12);
}

std::string parameter_table(const LepCalibrationReport& report) {
  const LepCalibration& calibration = report.calibration;
  const auto values = calibration.values();
  TextTable table;
  table.column("parameter", Align::left);
  table.column("unit", Align::left);
  table.column("fit");
  table.column("sd");
  table.column("linear");
  table.column("off by\n(sd of fit)");
  for (std::size_t i = 0; i < parameter_count; ++i) {
    const auto [unit, per_si] = shown_unit(i);
    const double sd = deviation(calibration, i);
    std::vector<std::string> cells = {
        std::string(lep_calibration_names[i]), unit,
        fmt::format("{:.{}f}", values[i] * per_si, decimals(sd * per_si)),
        sd > 0 ? fmt::format("{:.2g}", sd * per_si) : "given"};
    if (const auto linear = linear_value(calibration, i)) {
      cells.push_back(fmt::format("{:.{}f}", *linear * per_si, decimals(sd * per_si)));
      cells.push_back(fmt::format("{:+.1f}", (*linear - values[i]) / sd));
    }
    table.row(std::move(cells));
  }
  return table.text();
}

/// Correlations of the parameters that are uncertain.
std::string correlation_table(const LepCalibration& calibration) {
  std::vector<std::size_t> uncertain;
  for (std::size_t i = 0; i < parameter_count; ++i)
    if (deviation(calibration, i) > 0) uncertain.push_back(i);
  TextTable table;
  table.column("correlation", Align::left);
  for (const std::size_t i : uncertain) table.column(std::string(lep_calibration_names[i]));
  for (std::size_t a = 0; a < uncertain.size(); ++a) {
    std::vector<std::string> cells = {std::string(lep_calibration_names[uncertain[a]])};
    for (std::size_t b = 0; b <= a; ++b)
      cells.push_back(
          a == b ? "1"
                 : fmt::format("{:+.4f}", correlation(calibration, uncertain[a], uncertain[b])));
    table.row(std::move(cells));
  }
  return table.text();
}

std::string table_line(const char* what, const LepTableError& error) {
  return fmt::format("  {:<28} z off by {:.3g} mm rms, {:+.3g} mm at most, {} of {} cells\n", what,
                     1e3 * error.rms, 1e3 * error.largest, error.inverted, error.cells);
}

std::string table_text(const LepTableReport& table) {
  if (!table.fault.empty()) return fmt::format("look-up table: none: {}\n", table.fault);
  return fmt::format("look-up table, against the fit at the centres of its cells\n{}{}",
                     table_line("interpolation alone", table.interpolation),
                     table_line("with the readings' noise", table.with_noise));
}

Json table_error_json(const LepTableError& error) {
  return {{"cells", error.cells},
          {"inverted", error.inverted},
          {"rms", error.rms},
          {"largest", error.largest}};
}

}  // namespace

std::string calibration_text(const LepCalibrationReport& report) {
  const LepCalibration& calibration = report.calibration;
  const LepResiduals& residuals = calibration.residuals;
  const double degrees = calibration.degrees_of_freedom();
  const Interval bounds = chi_square_interval(degrees, bounds_probability);
  std::string text = fmt::format("{}: {} readings\n", report.file, calibration.points);
  if (report.origin)
    text += fmt::format("scan origin: from {} stripe edges, sd of a scan angle {:.3g} deg\n",
                        report.origin->edges, report.origin->residual * 180 / std::numbers::pi);
  text += "\n" + parameter_table(report) + "\n" + correlation_table(calibration) + "\n";
  text += fmt::format(
      "chi-squared {:.1f} of {:.0f} degrees of freedom: {:.3f}, 99 % bounds {:.3f} "
      ".. {:.3f}: {}\n",
      calibration.chi_squared, degrees, calibration.chi_squared / degrees, bounds.low / degrees,
      bounds.high / degrees,
      bounds.contains(calibration.chi_squared)
          ? "model and stated noise agree with the readings"
          : "model and stated noise do NOT agree with the readings");
  text += fmt::format(
      "image position, measured less fitted: mean {:+.2g} um, rms {:.3g} um, "
      "largest {:+.3g} um (line {}), {:+.1f} sd (line {})\n",
      1e6 * residuals.mean, 1e6 * residuals.rms, 1e6 * residuals.largest, report.largest_line,
      residuals.largest_in_sd, report.largest_in_sd_line);
  return text + table_text(report.table);
}

Json calibration_json(const LepCalibrationReport& report) {
  const LepCalibration& calibration = report.calibration;
  const auto values = calibration.values();
  Json parameters = Json::array();
  Json covariance = Json::array();
  Json correlations = Json::array();
  for (std::size_t i = 0; i < parameter_count; ++i) {
    Json parameter = {{"name", lep_calibration_names[i]},
                      {"unit", lep_calibration_units[i]},
                      {"value", values[i]},
                      {"std", deviation(calibration, i)}};
    if (const auto linear = linear_value(calibration, i)) parameter["linear"] = *linear;
    parameters.push_back(std::move(parameter));
    Json covariance_row = Json::array();
    Json correlation_row = Json::array();
    for (std::size_t j = 0; j < parameter_count; ++j) {
      covariance_row.push_back(
          calibration.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
      correlation_row.push_back(correlation(calibration, i, j));
    }
    covariance.push_back(std::move(covariance_row));
    correlations.push_back(std::move(correlation_row));
  }
  const LepResiduals& residuals = calibration.residuals;
  Json json = {{"calibration", "lep"},
               {"readings", calibration.points},
               {"parameters", std::move(parameters)},
               {"covariance", std::move(covariance)},
               {"correlations", std::move(correlations)},
               {"chi_squared", calibration.chi_squared},
               {"degrees_of_freedom", calibration.degrees_of_freedom()},
               {"residuals",
                {{"unit", "m"},
                 {"mean", residuals.mean},
                 {"rms", residuals.rms},
                 {"largest", residuals.largest},
                 {"largest_line", report.largest_line},
                 {"largest_in_sd", residuals.largest_in_sd},
                 {"largest_in_sd_line", report.largest_in_sd_line}}}};
  if (report.origin)
    json["scan_origin"] = {{"edges", report.origin->edges},
                           {"scan_angle_std", report.origin->residual}};
  if (report.table.fault.empty())
    json["table"] = {{"unit", "m"},
                     {"interpolation", table_error_json(report.table.interpolation)},
                     {"with_noise", table_error_json(report.table.with_noise)}};
  else
    json["table"] = {{"fault", report.table.fault}};
  return json;
}

std::string calibration_yaml(const LepCalibrationReport& report) {
  const LepCalibration& calibration = report.calibration;
  const auto values = calibration.values();
  std::string text = fmt::format(
      "# LEP sensor, calibrated on {} readings; chi-squared {:.1f} of {:.0f} degrees of freedom.\n"
      "# A graph takes it as constants: {{lep: {{file: ...}}}} and then $lep.focal_length, ...\n"
      "value:\n",
      calibration.points, calibration.chi_squared, calibration.degrees_of_freedom());
  for (std::size_t i = 0; i < parameter_count; ++i)
    text += fmt::format("  {}: {:.12g} {}\n", lep_calibration_names[i], values[i],
                        lep_calibration_units[i]);
  text += "covariance:  # in the products of these units\n";
  for (Eigen::Index i = 0; i < calibration.covariance.rows(); ++i) {
    std::vector<double> row;
    for (Eigen::Index j = 0; j < calibration.covariance.cols(); ++j)
      row.push_back(calibration.covariance(std::min(i, j), std::max(i, j)));
    text += fmt::format("  - [{:.15g}]\n", fmt::join(row, ", "));
  }
  return text;
}

std::string noise_text(const LepNoiseReport& report) {
  const LepNoiseFit& fit = report.fit;
  return fmt::format(
      "{}: {} readings\n"
      "noise current  ({:.3f} +- {:.3f}) pA, the slope of log(sd) by log(current) being -1\n"
      "               sd of image position = {:.1f} um nA / detector current, for a detector of "
      "{:g} mm\n"
      "scatter        {:.1f} % of an sd about that line\n"
      "free slope     {:.3f} +- {:.3f}\n",
      report.file, fit.readings, 1e12 * fit.noise_current, 1e12 * fit.noise_current_deviation,
      1e15 * fit.noise_current * report.detector_length / 2, 1e3 * report.detector_length,
      100 * fit.residual, fit.slope, fit.slope_deviation);
}

Json noise_json(const LepNoiseReport& report) {
  const LepNoiseFit& fit = report.fit;
  return {{"calibration", "lep_noise"},
          {"readings", fit.readings},
          {"detector_length", report.detector_length},
          {"noise_current",
           {{"unit", "A"}, {"value", fit.noise_current}, {"std", fit.noise_current_deviation}}},
          {"residual", fit.residual},
          {"free_slope", {{"value", fit.slope}, {"std", fit.slope_deviation}}}};
}

std::string noise_yaml(const LepNoiseReport& report) {
  const LepNoiseFit& fit = report.fit;
  return fmt::format(
      "# Noise current of a LEP's detector of {:g} m, from {} readings.\n"
      "# A graph takes it as constants: {{noise: {{file: ...}}}} and then $noise.\n"
      "value: {:.9g} A\nstd: {:.6g} A\ndegrees_of_freedom: {}\n",
      report.detector_length, fit.readings, fit.noise_current, fit.noise_current_deviation,
      fit.readings - 1);
}

}  // namespace ilss
