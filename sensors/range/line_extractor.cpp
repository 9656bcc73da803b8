#include "sensors/range/line_extractor.h"

#include <fmt/format.h>

#include <cmath>

namespace ilss {

void LineExtractor::Options::declare(OptionVisitor& visit) {
  visit("evidence", rule.segmentation.evidence,
        "chi² that a further segment must save before it is believed", {.minimum = 1});
  visit("outlier_cost", rule.segmentation.outlier_cost,
        "chi² that a reading may cost before it counts as an outlier", {.minimum = 1});
  visit("least_readings", least_readings, "of a segment", {.minimum = 3, .maximum = 1000});
  visit("max_gap", rule.max_gap, "between the ends of two pieces that are one segment",
        {.unit = "m", .minimum = 0});
  visit("least_radius", rule.arc.least_radius, "of an arc", {.unit = "m", .minimum = 0});
  visit("largest_radius", rule.arc.largest_radius, "of an arc; 0: no arcs",
        {.unit = "m", .minimum = 0});
  visit("continuous", continuous, "readings go on from tick to tick; a tick is no whole scan");
  visit("memory", memory,
        "scans over which a line is averaged, before it starts anew; 1: each scan alone",
        {.minimum = 1, .maximum = 1000000});
  visit.require(rule.arc.largest_radius == 0 || rule.arc.least_radius < rule.arc.largest_radius,
                "'least_radius' must be less than 'largest_radius'");
  visit.require(!continuous || memory == 1, "'memory' is for whole scans, not with 'continuous'");
}

Interface LineExtractor::interface(const Options& options) {
  return {.inputs = {{"scan", &descriptor<RangeScan>()}},
          .output = &descriptor<RangeFeatures>(),
          .frame_of_input = 0,
          .forgets = !options.continuous && options.memory == 1};
}

namespace {

ScanLinesRule rule_of(const LineExtractor::Options& options) {
  ScanLinesRule rule = options.rule;
  rule.segmentation.least_readings = static_cast<std::size_t>(options.least_readings);
  return rule;
}

}  // namespace

LineExtractor::LineExtractor(const Options& options)
    : options_(options),
      lines_(rule_of(options)),
      memory_(static_cast<std::size_t>(options.memory), options.rule.max_gap) {}

void LineExtractor::reset() {
  memory_.clear();
  scan_begun_ = false;
}

Outcome<> check_readings(std::span<const RangeReading> readings) {
  const auto wrong = [](std::size_t i, std::string_view what) {
    return Fault{FaultKind::bad_data, fmt::format("reading {}: {}", i, what)};
  };
  double direction = 0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const RangeReading& r = readings[i];
    double sum = r.time + r.head + r.origin_x + r.origin_z + r.bearing;
    for (const double s : r.sensitivity) sum += s;
    if (!std::isfinite(sum)) return wrong(i, "a number is not finite");
    if (!(r.inverse_range > 0 && std::isfinite(r.inverse_range)))
      return wrong(i, "the range must be above 0 and finite");
    if (!(r.deviation > 0 && std::isfinite(r.deviation)))
      return wrong(i, "the sd of the range must be above 0 and finite");
    if (i == 0) continue;
    const double step = r.bearing - readings[i - 1].bearing;
    if (step * direction < 0 || step == 0)
      return wrong(i, "bearings must run in one direction through a scan");
    direction = step;
  }
  return {};
}

Outcome<> LineExtractor::evaluate(const Evaluation& evaluation, Output& output) {
  const Estimate& scan = evaluation.input(0);
  const auto shared = payload_of<RangeScan>(scan);
  const double noise_correlation = shared.noise_correlation;
  if (!(noise_correlation >= 0 && noise_correlation < 1))
    return Fault{FaultKind::bad_data,
                 fmt::format("a noise correlation of {} is not in [0, 1)", noise_correlation)};
  return options_.continuous ? extract_on(evaluation, shared, output)
                             : extract_scan(evaluation, shared, output);
}

Outcome<> LineExtractor::extract_scan(const Evaluation& evaluation, const RangeScan<double>& shared,
                                      Output& output) {
  const std::span<const RangeReading> readings = readings_of(*evaluation.inputs[0]);
  if (readings.size() < static_cast<std::size_t>(options_.least_readings))
    return Fault{FaultKind::no_detection,
                 fmt::format("the scan has {} readings; a segment needs {}", readings.size(),
                             options_.least_readings)};
  if (Outcome<> outcome = check_readings(readings); !outcome) return outcome;
  lines_.begin({shared.noise_correlation, shared.noise_in_range != 0}, shared.beam_width);
  for (const RangeReading& reading : readings) lines_.add(reading);
  lines_.finish();
  memory_.join(lines_.segments(), readings);
  FeatureWriter writer(evaluation, evaluation.input(0), output);
  const std::span<const FittedSegment> segments = lines_.segments();
  for (std::size_t i = 0; i < segments.size(); ++i) {
    writer.add(segments[i], readings);
    if (i > 0) writer.add_edge(segments[i - 1], segments[i], readings);
  }
  writer.finish();
  return {};
}

/// Whether a reading starts a new sweep: the sensor turns back within its head.
bool LineExtractor::jumps_back(const RangeReading& reading) const {
  const std::span<const RangeReading> readings = lines_.readings();
  if (readings.size() < 2) return false;
  const auto in_head = [](const RangeReading& r) { return r.bearing - r.head; };
  const RangeReading& last = readings.back();
  return (in_head(reading) - in_head(last)) *
             (in_head(last) - in_head(readings[readings.size() - 2])) <
         0;
}

Outcome<> LineExtractor::extract_on(const Evaluation& evaluation, const RangeScan<double>& shared,
                                    Output& output) {
  FeatureWriter writer(evaluation, evaluation.input(0), output);
  bool any = false;
  const auto write_run = [&](const ReadingRun& run, bool is_open) {
    if (!lines_.fit_run(run, open_)) return;
    writer.add(open_, lines_.readings(), is_open);
    any = true;
  };
  for (const RangeReading& reading : readings_of(*evaluation.inputs[0])) {
    if (scan_begun_ && jumps_back(reading)) {
      write_run(lines_.runs().back(), false);
      scan_begun_ = false;
    }
    if (!scan_begun_) {
      lines_.begin({shared.noise_correlation, shared.noise_in_range != 0}, shared.beam_width);
      scan_begun_ = true;
    }
    if (Outcome<> outcome = check_readings({&reading, 1}); !outcome) return outcome;
    if (lines_.add(reading)) write_run(lines_.runs()[lines_.runs().size() - 2], false);
  }
  if (scan_begun_) write_run(lines_.runs().back(), true);
  if (!any) return Pending{};
  writer.finish();
  return {};
}

}  // namespace ilss
