#include "sensors/laser/acquire/laser_log.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "sensors/laser/laser_mount.h"

namespace ilss {
namespace {

Fault lost(std::string message) { return {FaultKind::device_lost, std::move(message)}; }

}  // namespace

void LaserLog::Options::declare(OptionVisitor& visit) {
  visit("file", file, "the log, plain or compressed by gzip", {.required = true});
  visit("format", format, "of the log: a CARMEN message, URG-04LX, or time and ranges as CSV");
  visit("range_std", range_std, "sd of a range's noise, by the data sheet",
        {.unit = "m", .minimum = 0});
  visit("bearing_std", bearing_std, "sd of a beam's bearing", {.unit = "rad", .minimum = 0});
  visit("quantum", quantum, "step in which the log tells ranges", {.unit = "m", .minimum = 0});
  visit("min_range", min_range, "less is no return: codes of the device",
        {.unit = "m", .minimum = 0});
  visit("no_return", no_return, "this and more is no return", {.unit = "m", .minimum = 0});
  visit("field_of_view", field_of_view, "from the first to the last range of a CSV's scans",
        {.unit = "rad", .minimum = 0, .maximum = 6.2831853071795865});
  visit("first", first, "the scan to start with", {.minimum = 0});
  visit("skip_bad", skip_bad, "leave out lines that are no scan, instead of a fault");
  visit("frame", frame, "name of the laser's frame, x forward and y to the left");
}

Interface LaserLog::interface(const Options& options) {
  return {.inputs = {}, .output = &descriptor<LaserScan>(), .frame = options.frame};
}

void LaserLog::reset() {
  next_ = 0;
  beams_ = 0;
  time_ = -std::numeric_limits<double>::infinity();
  scans_passed_ = 0;
  has_begun_ = false;
  ahead_.reset();
  skipped_ = {};
}

Outcome<std::optional<LaserRecord>> LaserLog::parse(std::string_view line) const {
  switch (options_.format) {
    case LaserLogFormat::urg:
      return parse_urg(line);
    case LaserLogFormat::csv:
      return parse_laser_csv(line, options_.field_of_view);
    default:
      return parse_carmen(line, static_cast<CarmenMessage>(options_.format));
  }
}

void LaserLog::emit(const Evaluation& evaluation, const LaserRecord& record, Output& output) {
  const std::span<LaserBeam> beams = make_beams(output, record.ranges.size());
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const double range = record.ranges[i];
    const bool returned = range > 0 && range >= options_.min_range && range < options_.no_return;
    beams[i] = {record.first_bearing + static_cast<double>(i) * record.step, returned ? range : 0};
  }
  assign<LaserScan>(output.estimate, {.range_std = options_.range_std,
                                      .bearing_std = options_.bearing_std,
                                      .quantum = options_.quantum,
                                      .max_range = options_.no_return});
  set_mount(evaluation.parameters, 0, output.estimate);
  output.acquired = Acquisition::at(evaluation.time);
}

/// Whether a CSV's scan is like the one before it: nothing else tells a cut line, or one without
/// its time.
Outcome<> LaserLog::check_continuity(const LaserRecord& record) const {
  if (options_.format != LaserLogFormat::csv || beams_ == 0) return {};
  if (record.ranges.size() != beams_)
    return Fault{FaultKind::bad_data, fmt::format("{} ranges; expected {}, as in the scan before",
                                                  record.ranges.size(), beams_)};
  if (!(record.time > time_))
    return Fault{FaultKind::bad_data,
                 fmt::format("the time, {:g} s, is not after the scan before, {:g} s; the first "
                             "number of a line is its time",
                             record.time, time_)};
  return {};
}

Outcome<> LaserLog::open() {
  if (log_ != nullptr) return {};
  auto opened = TextLog::open(options_.file);
  if (!opened) return opened.fault();
  log_ = *opened;
  return {};
}

/// The next scan from the first wanted one on; nothing at the log's end.
Outcome<std::optional<LaserRecord>> LaserLog::read_next() {
  while (next_ < log_->lines()) {
    const std::size_t line = next_++;
    auto record = parse(log_->line(line));
    if (record && !*record) continue;
    if (scans_passed_ < options_.first) {
      ++scans_passed_;
      continue;
    }
    const Outcome<> continuity = record ? check_continuity(**record) : Outcome<>(record.fault());
    if (!continuity) {
      Fault fault{continuity.fault().kind, fmt::format("{}:{}: {}", options_.file.string(),
                                                       line + 1, continuity.fault().message)};
      if (!options_.skip_bad) return fault;
      skipped_.add(fault);
      continue;
    }
    beams_ = (*record)->ranges.size();
    time_ = (*record)->time;
    return record;
  }
  return std::optional<LaserRecord>();
}

std::optional<Time> LaserLog::next_time() {
  if (!ahead_) ahead_ = read_next();
  if (!*ahead_) return time_of_bad_scan();
  if (!**ahead_) return std::nullopt;
  return time_at((**ahead_)->time);
}

/// A scan that cannot be read has its turn with the one before it, or with the first that can be.
std::optional<Time> LaserLog::time_of_bad_scan() const {
  if (std::isfinite(time_)) return time_at(time_);
  for (std::size_t line = next_; line < log_->lines(); ++line)
    if (const auto record = parse(log_->line(line)); record && *record)
      return time_at((*record)->time);
  return std::nullopt;
}

Outcome<> LaserLog::evaluate(const Evaluation& evaluation, Output& output) {
  const bool is_first = !std::exchange(has_begun_, true);
  const Outcome<std::optional<LaserRecord>> record =
      ahead_ ? *std::exchange(ahead_, std::nullopt) : read_next();
  if (!record) return record.fault();
  if (*record) {
    emit(evaluation, **record, output);
    return {};
  }
  if (is_first)
    return lost(fmt::format("'{}' has no {} scan{}", options_.file.string(),
                            choices(options_.format)[static_cast<std::size_t>(options_.format)],
                            options_.first > 0 ? " from the first wanted on" : ""));
  return Fault{FaultKind::end_of_data,
               fmt::format("'{}' has no more scans", options_.file.string())};
}

}  // namespace ilss
