#include "sensors/range/range_readings.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "framework/estimate/units.h"

namespace ilss {
namespace {

constexpr std::size_t range_scan_size = dimension_of<RangeScan>;

double scale_of(const std::string& unit, const char* si_unit) {
  const auto conversion = unit_conversion(unit, si_unit);
  const auto* known = std::get_if<UnitConversion>(&conversion);
  return known != nullptr ? known->scale : 1;
}

void check_unit(OptionVisitor& visit, const char* option, const std::string& unit,
                const char* si_unit) {
  const auto conversion = unit_conversion(unit, si_unit);
  const auto* wrong = std::get_if<std::string>(&conversion);
  visit.require(wrong == nullptr,
                wrong != nullptr ? fmt::format("{}: {}", option, *wrong) : std::string());
}

}  // namespace

void RangeReadings::Options::declare(OptionVisitor& visit) {
  visit("file", file, "a CSV file, one row a reading; an empty range is no reading",
        {.required = true});
  visit("angle", angle, "the angles' column: its name, or its number from 1");
  visit("angle_unit", angle_unit, "of angle and head");
  visit(
      "angles", angles,
      "from_x_to_z: polar coordinates of the frame; from_z_to_x: from forward to the right, where "
      "x is to the right and z forward");
  visit("range", range, "the ranges' column");
  visit("range_unit", range_unit, "of range and range_std");
  visit("range_std", range_std, "the column of each range's sd");
  visit("std_constant", std_constant, "sd of a range, beside the column's or instead of it",
        {.unit = "m", .minimum = 0});
  visit("std_proportional", std_proportional, "sd as a share of the range", {.minimum = 0});
  visit("head", head, "the column of the head's angle, in the sense of `angles`");
  visit("time_column", time_column, "the column of the times, in s");
  visit("readings", readings, "rows of a scan; without it a scan ends where the angle jumps back",
        {.minimum = 1});
  visit("min_range", min_range, "a range below it is a fault", {.unit = "m", .minimum = 0});
  visit("max_range", max_range, "a range above it is a fault", {.unit = "m", .minimum = 0});
  visit("noise_correlation", noise_correlation, "of one reading's noise and the next one's",
        {.minimum = 0, .maximum = 0.99});
  visit("beam_width", beam_width, "within which a reading may hold two surfaces",
        {.unit = "m", .minimum = 0});
  visit("skip_bad", skip_bad, "leave out rows that would be a fault");
  visit("frame", frame, "name of the frame that the scans are in");
  check_unit(visit, "angle_unit", angle_unit, "rad");
  check_unit(visit, "range_unit", range_unit, "m");
  visit.require(range_std || std_constant > 0 || std_proportional > 0,
                "the ranges need an error: range_std, std_constant or std_proportional");
}

Interface RangeReadings::interface(const Options& options) {
  return {.inputs = {}, .output = &descriptor<RangeScan>(), .frame = options.frame};
}

void RangeReadings::reset() {
  next_ = 0;
  skipped_ = {};
}

/// That of the next scan's last reading that has one, where a column tells times; of a scan without
/// any, that of the next reading that has one.
std::optional<Time> RangeReadings::next_time() {
  if (!columns_.time || next_ >= recording_->rows()) return std::nullopt;
  const std::size_t end = end_of_scan();
  for (std::size_t row = end; row-- > next_;)
    if (const auto time = recording_->number(row, *columns_.time)) return time_at(*time);
  for (std::size_t row = end; row < recording_->rows(); ++row)
    if (const auto time = recording_->number(row, *columns_.time)) return time_at(*time);
  return std::nullopt;
}

Outcome<> RangeReadings::open() {
  if (recording_ != nullptr) return {};
  auto opened = CsvFile::open(options_.file);
  if (!opened) return opened.fault();
  std::optional<Fault> missing;
  const auto find = [&](const std::string& wanted) -> std::size_t {
    const auto column = (*opened)->find_column(wanted);
    if (column) return *column;
    missing = column.fault();
    return 0;
  };
  const auto find_optional =
      [&](const std::optional<std::string>& wanted) -> std::optional<std::size_t> {
    if (!wanted) return std::nullopt;
    return find(*wanted);
  };
  columns_ = {find(options_.angle), find(options_.range), find_optional(options_.range_std),
              find_optional(options_.head), find_optional(options_.time_column)};
  if (missing) return *missing;
  recording_ = *opened;
  to_metres_ = scale_of(options_.range_unit, "m");
  to_radians_ = scale_of(options_.angle_unit, "rad");
  return {};
}

/// The row behind the last one of the scan that starts at `next_`.
std::size_t RangeReadings::end_of_scan() const {
  const std::size_t rows = recording_->rows();
  if (options_.readings)
    return std::min(rows, next_ + static_cast<std::size_t>(*options_.readings));
  double direction = 0;
  std::optional<double> last;
  for (std::size_t row = next_; row < rows; ++row) {
    const auto angle = recording_->number(row, columns_.angle);
    if (!angle) continue;  // said when the row is read
    if (last) {
      const double step = *angle - *last;
      if (step * direction < 0) return row;
      if (direction == 0) direction = step;
    }
    last = *angle;
  }
  return rows;
}

Outcome<> RangeReadings::read_row(std::size_t row, const Evaluation& evaluation,
                                  RangeReading& reading) const {
  const auto wrong = [&](std::string what) {
    return Fault{FaultKind::bad_data, fmt::format("{}: {}", recording_->place(row), what)};
  };
  const auto range_cell = recording_->number(row, columns_.range);
  if (!range_cell) {
    if (range_cell.fault().kind == FaultKind::no_detection) return Pending{};
    return range_cell.fault();
  }
  std::optional<Fault> fault;
  const auto number = [&](std::optional<std::size_t> column, double otherwise) {
    if (!column) return otherwise;
    const auto value = recording_->number(row, *column);
    if (value) return *value;
    fault = Fault{FaultKind::bad_data, value.fault().message};
    return otherwise;
  };
  const double angle = number(columns_.angle, 0) * to_radians_;
  const double head = number(columns_.head, 0) * to_radians_;
  const double column_std = number(columns_.range_std, 0) * to_metres_;
  const double time = number(columns_.time, seconds(evaluation.time));
  if (fault) return *fault;
  const auto p = payload_of<Parameters>(evaluation.parameters);
  if (!(p.scale > 0)) return wrong(fmt::format("a scale of {}; expected one above 0", p.scale));
  const double measured = *range_cell * to_metres_;
  if (!(measured > 0)) return wrong(fmt::format("a range of {} m; expected one above 0", measured));
  if (measured < options_.min_range ||
      measured > options_.max_range.value_or(std::numeric_limits<double>::infinity()))
    return wrong(fmt::format("a range of {} m is outside the sensor's field", measured));
  const double range = p.scale * (measured - p.offset);
  if (!(range > 0)) return wrong(fmt::format("a range of {} m is not above the offset", measured));
  if (columns_.range_std && !(column_std > 0))
    return wrong(fmt::format("an sd of {} m; expected one above 0", column_std));
  const double deviation =
      std::hypot(column_std, options_.std_constant, options_.std_proportional * range);
  const double u = 1 / range;
  if (!(u * u * deviation > 0) || !std::isfinite(p.scale * u * u + u * u * deviation))
    return wrong(fmt::format("a range of {} m is too {} to compute with", measured,
                             measured < 1 ? "small" : "large"));
  const bool from_z = options_.angles == AngleSense::from_z_to_x;
  const double turned = from_z ? -head : head;
  const double c = std::cos(turned);
  const double s = std::sin(turned);
  reading = {time,
             turned,
             c * p.mount_x - s * p.mount_z,
             s * p.mount_x + c * p.mount_z,
             (from_z ? std::numbers::pi / 2 - angle : angle) + turned + p.mount_heading,
             u,
             u * u * deviation,
             {p.scale * u * u, -u}};
  return {};
}

Outcome<> RangeReadings::evaluate(const Evaluation& evaluation, Output& output) {
  if (next_ >= recording_->rows())
    return Fault{FaultKind::end_of_data,
                 fmt::format("'{}' has {} rows", options_.file.string(), recording_->rows())};
  const std::size_t begin = next_;
  next_ = end_of_scan();
  const std::span<RangeReading> readings = make_readings(output, next_ - begin);
  std::size_t count = 0;
  for (std::size_t row = begin; row < next_; ++row) {
    Outcome<> outcome = read_row(row, evaluation, readings[count]);
    if (outcome.is_fault()) {
      if (!options_.skip_bad) return outcome;
      skipped_.add(outcome.fault());
    }
    if (outcome.has_output()) ++count;
  }
  if (count == 0)
    return Fault{FaultKind::no_detection,
                 fmt::format("{}: no row of the scan has a range", recording_->place(begin))};
  output.acquired = Acquisition::at(evaluation.time);
  if (columns_.time)
    output.acquired = {time_at(readings.front().time), time_at(readings[count - 1].time)};
  make_readings(output, count);
  const auto p = payload_of<Parameters>(evaluation.parameters);
  assign<RangeScan>(output.estimate, {p.mount_x, p.mount_z, p.mount_heading, 0, 0, 0, 0, 0,
                                      options_.noise_correlation, options_.beam_width, 1});
  constexpr std::size_t parameter_count = dimension_of<Parameters>;
  std::array<double, range_scan_size * parameter_count> jacobian{};
  jacobian[0 * range_scan_size + 3] = 1;            // the offset, in m
  jacobian[1 * range_scan_size + 4] = 1 / p.scale;  // the scale's relative error
  for (std::size_t i = 0; i < 3; ++i) jacobian[(2 + i) * range_scan_size + i] = 1;
  const LineageTerm term{jacobian.data(), &evaluation.parameters.lineage};
  compose({&term, 1}, range_scan_size, output.estimate.lineage);
  return {};
}

}  // namespace ilss
