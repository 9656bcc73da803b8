// `ilss calibrate`: fits a sensor's model to measurements of known things.
#include <fmt/format.h>

#include <cmath>

#include "framework/graph/quantity_reader.h"
#include "sensors/lep/lep_detector.h"
#include "src/calibration_output.h"
#include "src/calibration_report.h"
#include "src/calibration_table.h"
#include "src/session.h"

namespace ilss {
namespace {

struct NoiseArguments {
  std::string file;
  std::string detector_length;
  std::string output;
  bool json = false;
  bool force = false;
};

struct LepArguments {
  NoiseArguments common;
  std::string noise_current;
  std::string stripes;
  std::array<std::string, 3> origin;  ///< x, z, projected vergence, as written
};

constexpr std::array<const char*, 3> origin_options = {"--origin-x", "--origin-z",
                                                       "--projected-vergence"};

/// A quantity of the command line in an SI unit.
struct Quantity {
  double value = 0;
  double deviation = 0;
};

/// Reads `10 mm` or `{value: 10 mm, std: 0.1 mm}`; the default where nothing is written.
Quantity read_option(const std::string& option, const std::string& text, std::string_view unit,
                     Quantity otherwise, Diagnostics& diagnostics) {
  if (text.empty()) return otherwise;
  const std::size_t errors = diagnostics.size();
  const Node node = parse_document(text, fmt::format("{} '{}'", option, text), diagnostics);
  if (diagnostics.size() != errors) return otherwise;
  const auto written = read_quantity(node, diagnostics);
  if (!written) return otherwise;
  const auto si = to_si(*written, unit, diagnostics);
  if (!si) return otherwise;
  return {si->value, si->scale * written->standard_deviation.value_or(0)};
}

double read_detector_length(const NoiseArguments& arguments, Diagnostics& diagnostics) {
  const double length = read_option("--detector-length", arguments.detector_length, "m",
                                    {lep_detector_length}, diagnostics)
                            .value;
  if (!(length > 0)) fail(exit_bad_input, "--detector-length: a length is positive");
  return length;
}

void calibrate_noise(const NoiseArguments& arguments) {
  check_output_file("--output", arguments.output, {arguments.file});
  static constexpr std::array<TableColumn, 2> columns = {
      {{"detector_current", "A", true}, {"image_position_std", "m", true}}};
  Diagnostics diagnostics;
  const double length = read_detector_length(arguments, diagnostics);
  const CalibrationTable table = read_calibration_table(arguments.file, columns, diagnostics);
  if (!diagnostics.empty()) report_and_exit(diagnostics);
  std::vector<LepNoiseReading> readings;
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    readings.push_back({table.columns[0][i], table.columns[1][i]});
  const auto fit = fit_noise_current(readings, length);
  if (!fit) refuse(arguments.file, fit.fault());
  const LepNoiseReport report{arguments.file, length, *fit};
  write_file(arguments.output, noise_yaml(report));
  fmt::print("{}", arguments.json ? json_text(noise_json(report)) + "\n" : noise_text(report));
}

/// The readings of the data file, each with the sd of its image position.
std::vector<LepCalibrationPoint> read_points(const LepArguments& arguments,
                                             std::vector<Position>& rows,
                                             Diagnostics& diagnostics) {
  const double length = read_detector_length(arguments.common, diagnostics);
  const bool by_current = !arguments.noise_current.empty();
  const Quantity noise =
      read_option("--noise-current", arguments.noise_current, "A", {}, diagnostics);
  if (by_current && diagnostics.empty() && !(noise.value > 0))
    fail(exit_bad_input, "--noise-current: a noise current is positive");
  const std::array<TableColumn, 4> columns = {
      {{"scan_angle", "rad"},
       {"depth", "m"},
       {"image_position", "m"},
       by_current ? TableColumn{"detector_current", "A", true}
                  : TableColumn{"image_position_std", "m", true,
                                "a column detector_current with --noise-current"}}};
  CalibrationTable table = read_calibration_table(arguments.common.file, columns, diagnostics);
  if (!diagnostics.empty()) report_and_exit(diagnostics);
  const double noise_current = std::hypot(noise.value, noise.deviation);
  std::vector<LepCalibrationPoint> points;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const double error = table.columns[3][i];
    points.push_back({table.columns[0][i], table.columns[1][i], table.columns[2][i],
                      by_current ? image_position_deviation(length, noise_current, error) : error});
  }
  rows = std::move(table.rows);
  return points;
}

LepScanOriginFit read_stripes(const std::string& file, Diagnostics& diagnostics) {
  static constexpr std::array<TableColumn, 3> columns = {
      {{"scan_angle", "rad"}, {"x", "m"}, {"z", "m"}}};
  const CalibrationTable table = read_calibration_table(file, columns, diagnostics);
  if (!diagnostics.empty()) report_and_exit(diagnostics);
  std::vector<StripeEdge> edges;
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    edges.push_back({table.columns[0][i], table.columns[1][i], table.columns[2][i]});
  const auto fit = fit_scan_origin(edges);
  if (!fit) refuse(file, fit.fault());
  return *fit;
}

LepScanOrigin read_origin(const LepArguments& arguments, Diagnostics& diagnostics) {
  LepScanOrigin origin;
  const std::array<double*, 3> values = {&origin.x, &origin.z, &origin.projected_vergence};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Quantity quantity =
        read_option(origin_options[i], arguments.origin[i], i == 2 ? "rad" : "m", {}, diagnostics);
    *values[i] = quantity.value;
    const auto k = static_cast<Eigen::Index>(i);
    origin.covariance(k, k) = quantity.deviation * quantity.deviation;
  }
  return origin;
}

LepTableReport judge_table(std::span<const LepCalibrationPoint> points,
                           const LepCalibration& calibration) {
  const auto table = LepTable::make(points);
  if (!table) return {{}, {}, table.fault().message};
  return {interpolation_error(*table, calibration.geometry, calibration.origin),
          table_error(*table, calibration.geometry, calibration.origin),
          {}};
}

/// Complains of the first reading that the laser cannot have reached: where it stands is known here
/// only.
void check_points(std::span<const LepCalibrationPoint> points, const std::vector<Position>& rows,
                  const LepScanOrigin& origin, double detector_length, Diagnostics& diagnostics) {
  for (std::size_t i = 0; i < points.size() && diagnostics.empty(); ++i) {
    if (!(points[i].depth > origin.z))
      diagnostics.add(rows[i], fmt::format("the depth, {:g} m, is not in front of the scan origin, "
                                           "at {:g} m",
                                           points[i].depth, origin.z));
    else if (!(std::cos(points[i].scan_angle + origin.projected_vergence) > 0))
      diagnostics.add(rows[i], "the laser's angle must be less than 90 deg");
    else if (std::abs(points[i].image_position) > detector_length / 2)
      diagnostics.add(rows[i], fmt::format("the image position, {:g} mm, is beside a photodiode "
                                           "of {:g} mm",
                                           points[i].image_position * 1e3, detector_length * 1e3));
  }
}

void calibrate_sensor(const LepArguments& arguments) {
  check_output_file("--output", arguments.common.output,
                    {arguments.common.file, arguments.stripes});
  Diagnostics diagnostics;
  LepCalibrationReport report;
  report.file = arguments.common.file;
  std::vector<Position> rows;
  const auto points = read_points(arguments, rows, diagnostics);
  LepScanOrigin origin = read_origin(arguments, diagnostics);
  if (!arguments.stripes.empty()) {
    report.origin = read_stripes(arguments.stripes, diagnostics);
    origin = report.origin->origin;
  }
  check_points(points, rows, origin, read_detector_length(arguments.common, diagnostics),
               diagnostics);
  if (!diagnostics.empty()) report_and_exit(diagnostics);
  const auto calibration = calibrate_lep(points, origin);
  if (!calibration) refuse(arguments.common.file, calibration.fault());
  report.calibration = *calibration;
  report.table = judge_table(points, *calibration);
  report.largest_line = rows[calibration->residuals.largest_at].line;
  report.largest_in_sd_line = rows[calibration->residuals.largest_in_sd_at].line;
  const double misfit = calibration->chi_squared / calibration->degrees_of_freedom();
  const bool fits = misfit < most_chi_squared || arguments.common.force;
  if (fits) write_file(arguments.common.output, calibration_yaml(report));
  fmt::print("{}", arguments.common.json ? json_text(calibration_json(report)) + "\n"
                                         : calibration_text(report));
  if (!fits)
    fail(exit_failed,
         fmt::format(
             "the model does not fit: chi-squared is {:.3g} a degree of freedom, and line {} "
             "lies farthest off; are the units right? Nothing is written without --force",
             misfit, report.largest_in_sd_line));
}

void add_common_options(Verb verb, NoiseArguments& arguments) {
  verb.add_option("--detector-length", arguments.detector_length,
                  "P, from end to end of the photodiode (default 10 mm)")
      .type_name("LENGTH");
  verb.add_option("--output", arguments.output, "Write a YAML file that a graph's constants take")
      .type_name("FILE");
  verb.add_flag("--json", arguments.json, "Print JSON");
}

void add_lep(Verb command) {
  const auto arguments = std::make_shared<LepArguments>();
  Verb verb = command.add_verb(
      "lep", "LEP range sensor: focal length, baseline, vergence, lens distance, scan origin");
  verb.add_option("DATA", arguments->common.file,
                  "CSV file with the columns scan_angle, depth, image_position and either "
                  "image_position_std or detector_current, each with its unit: 'depth [m]'")
      .required();
  verb.add_option("--noise-current", arguments->noise_current,
                  "Of the detector; then a reading's sd follows from its detector_current")
      .type_name("CURRENT");
  const Option stripes =
      verb.add_option("--stripes", arguments->stripes,
                      "CSV file of stripe edges for the scan origin: scan_angle, x, z")
          .type_name("FILE");
  const std::array<const char*, 3> what = {
      "Where the laser turns, to the right of the head's axis (default 0)",
      "The same, forward of it (default 0)",
      "What is added to a scan angle to get the laser's (default 0)"};
  for (std::size_t i = 0; i < what.size(); ++i)
    verb.add_option(origin_options[i], arguments->origin[i], what[i])
        .type_name(i == 2 ? "ANGLE" : "LENGTH")
        .excludes(stripes);
  add_common_options(verb, arguments->common);
  verb.add_flag("--force", arguments->common.force, "Write a calibration that does not fit, too");
  verb.on_call([arguments] { calibrate_sensor(*arguments); });
}

void add_lep_noise(Verb command) {
  const auto arguments = std::make_shared<NoiseArguments>();
  Verb verb = command.add_verb(
      "lep_noise",
      "Noise current of a LEP's detector, from sds of image position at known currents");
  verb.add_option("TABLE", arguments->file,
                  "CSV file with the columns detector_current and image_position_std, each with "
                  "its unit: 'detector_current [nA]'")
      .required();
  add_common_options(verb, *arguments);
  verb.on_call([arguments] { calibrate_noise(*arguments); });
}

}  // namespace

void add_calibrate(Verb command) {
  Verb verb = command.add_verb("calibrate", "Fit a sensor's model to measurements");
  verb.require_verb();
  add_calibrate_laser(verb);
  add_lep(verb);
  add_lep_noise(verb);
}

}  // namespace ilss
