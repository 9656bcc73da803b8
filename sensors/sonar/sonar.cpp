#include "sensors/sonar/sonar.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "sensors/scene/beam.h"

namespace ilss {
namespace {

constexpr std::size_t reading_size = dimension_of<SonarReading>;
constexpr std::size_t parameter_count = dimension_of<Sonar::Parameters>;

/// How the reading follows from the parameters (column-major): beam and mount pass unchanged, the
/// range is measured, and the robot's pose in the scene is nothing that a sonar knows.
constexpr std::array<double, reading_size* parameter_count> reading_by_parameters = [] {
  std::array<double, reading_size * parameter_count> jacobian{};
  for (std::size_t i = 1; i < reading_size; ++i) jacobian[(i - 1) * reading_size + i] = 1;
  return jacobian;
}();

UnitConversion length_conversion(const std::string& unit) {
  const auto conversion = unit_conversion(unit, "m");
  const auto* known = std::get_if<UnitConversion>(&conversion);
  return known != nullptr ? *known : UnitConversion{};
}

}  // namespace

void RangeError::declare(OptionVisitor& visit) {
  visit("constant", constant, "sd at range 0", {.unit = "m", .minimum = 0});
  visit("proportional", proportional, "sd that grows with range, as a share of it", {.minimum = 0});
}

void GivenRange::declare(OptionVisitor& visit) {
  visit("range", range, "the reading", {.unit = "m", .required = true});
}

void RangeColumn::declare(OptionVisitor& visit) {
  visit("file", file,
        "a CSV file, one row a reading; an empty cell is no echo (`no_detection`); empty lines and "
        "lines that start with # are left out",
        {.required = true});
  visit("column", column, "the column's name in the header, or its number from 1");
  visit("unit", unit, "the unit of its numbers");
  const auto conversion = unit_conversion(unit, "m");
  const auto* wrong = std::get_if<std::string>(&conversion);
  visit.require(wrong == nullptr, wrong != nullptr ? "unit: " + *wrong : "");
}

void SonarInput::declare(OptionVisitor& visit) {
  visit("values", values, "readings, one after another");
  visit("csv", csv, "readings from a recording");
  visit("scene", scene, "a simulated scene's file");
  visit.require((values.empty() ? 0 : 1) + (csv ? 1 : 0) + (scene ? 1 : 0) == 1,
                "a sonar's input needs exactly one of 'values', 'csv' and 'scene'");
}

void Sonar::Options::declare(OptionVisitor& visit) {
  visit("range_std", range_std, "sd of the range, the same at every range",
        {.unit = "m", .minimum = 0});
  visit("range_error", range_error,
        "error of the range: variance = constant^2 + (proportional range)^2");
  visit("no_echo", no_echo, "readings of this or more mean that no echo came back",
        {.unit = "m", .minimum = 0});
  visit("max_range", max_range, "a wall farther away gives no echo", {.unit = "m", .minimum = 0});
  visit("period", period, "one reading every so many ticks", {.minimum = 1});
  visit("frame", frame, "the frame that the mount is given in");
  visit("input", input, "where readings come from", {.required = true});
  visit.require(range_std.has_value() != range_error.has_value(),
                "a sonar needs exactly one of 'range_std' and 'range_error'");
}

Interface Sonar::interface(const Options& options) {
  return {.inputs = {},
          .output = &descriptor<SonarReading>(),
          .frame = options.frame,
          .draws_readings = options.input.scene.has_value()};
}

double Sonar::standard_deviation(double range) const {
  if (options_.range_std) return *options_.range_std;
  const RangeError error = options_.range_error.value_or(RangeError{});
  return std::hypot(error.constant, error.proportional * range);
}

Outcome<> Sonar::open() {
  if (!options_.input.csv || recording_ != nullptr) return {};
  auto opened = CsvFile::open(options_.input.csv->file);
  if (!opened) return opened.fault();
  const auto column = (*opened)->find_column(options_.input.csv->column);
  if (!column) return column.fault();
  recording_ = *opened;
  column_ = *column;
  conversion_ = length_conversion(options_.input.csv->unit);
  return {};
}

Outcome<> Sonar::evaluate(const Evaluation& evaluation, Output& output) {
  if (evaluation.tick % options_.period != 0) return Pending{};
  auto range = acquire(evaluation, static_cast<std::size_t>(evaluation.tick / options_.period));
  if (!range) return range.fault();
  if (options_.input.scene) {
    RandomBits random = evaluation.random();
    *range += standard_deviation(*range) * draw_normal(random);
  }
  return emit(evaluation, *range, output);
}

Outcome<> Sonar::expect(const Evaluation& evaluation, const Output* operating_point,
                        Output& output) {
  if (operating_point == nullptr) {
    if (Outcome<> outcome = open(); !outcome) return outcome;
    const auto range = acquire(evaluation, 0);
    if (!range) return range.fault();
    return emit(evaluation, *range, output);
  }
  const std::vector<double>& point = operating_point->estimate.value;
  if (Outcome<> outcome = emit(evaluation, point[0], output); !outcome) return outcome;
  for (std::size_t i = 1; i < reading_size; ++i)
    if (!std::isnan(point[i])) output.estimate.value[i] = point[i];
  return {};
}

Outcome<double> Sonar::acquire(const Evaluation& evaluation, std::size_t reading) const {
  if (options_.input.scene) return scene_range(evaluation.parameters);
  if (options_.input.csv) return recorded_range(*options_.input.csv, reading);
  if (reading < options_.input.values.size()) return options_.input.values[reading].range;
  return Fault{FaultKind::end_of_data,
               fmt::format("all {} given readings are used up", options_.input.values.size())};
}

Outcome<double> Sonar::recorded_range(const RangeColumn& source, std::size_t reading) const {
  if (reading >= recording_->rows())
    return Fault{FaultKind::end_of_data,
                 fmt::format("'{}' has {} rows", source.file.string(), recording_->rows())};
  const auto number = recording_->number(reading, column_);
  if (!number) return number.fault();
  return conversion_.scale * *number + conversion_.offset;
}

Outcome<double> Sonar::scene_range(const Estimate& parameters) const {
  const auto p = payload_of<Parameters>(parameters);
  const ScenePose beam = compose_poses({p.robot_x, p.robot_z, p.robot_heading},
                                       {p.mount_x, p.mount_z, p.mount_heading});
  const auto hit =
      nearest_in_beam(options_.input.scene->content, beam, p.beam_half_angle,
                      options_.max_range.value_or(std::numeric_limits<double>::infinity()));
  if (!hit) return Fault{FaultKind::no_detection, "no wall in the beam"};
  return hit->range;
}

Outcome<> Sonar::emit(const Evaluation& evaluation, double range, Output& output) const {
  if (range >= options_.no_echo.value_or(std::numeric_limits<double>::infinity()) ||
      range > options_.max_range.value_or(std::numeric_limits<double>::infinity()))
    return Fault{FaultKind::no_detection, fmt::format("no echo: the reading is {} m", range)};
  if (!(range > 0))
    return Fault{FaultKind::out_of_range,
                 fmt::format("the reading is {} m; a range is positive", range)};
  Estimate& estimate = output.estimate;
  const std::vector<double>& p = evaluation.parameters.value;
  estimate.value.assign({range, p[0], p[1], p[2], p[3]});
  const LineageTerm term{reading_by_parameters.data(), &evaluation.parameters.lineage};
  compose({&term, 1}, reading_size, estimate.lineage);
  if (const double sd = standard_deviation(range); sd > 0)
    estimate.lineage.add(evaluation.fresh(0), 0, sd);
  return {};
}

}  // namespace ilss
