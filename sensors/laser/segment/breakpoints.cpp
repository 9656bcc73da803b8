#include "sensors/laser/segment/breakpoints.h"

#include <fmt/format.h>

#include <cmath>

#include "sensors/laser/internal/pairs.h"

namespace ilss {
bool BreakpointRule::breaks(double range_before, double range, double step) {
  // The steps of a scan are alike but for rounding, so that the last one's numbers serve again.
  if (!(std::abs(step - step_) < tolerance_)) {
    step_ = step;
    tolerance_ = 1e-9 * std::abs(step);
    const double angle = std::abs(step);
    reach_ = angle < incidence_ ? std::sin(angle) / std::sin(incidence_ - angle) : INFINITY;
    cosine_ = std::cos(angle);
  }
  const double square =
      range * range + range_before * range_before - 2 * range * range_before * cosine_;
  const double limit = range_before * reach_ + noise_;
  return square > limit * limit;
}

bool BreakpointRule::continues(const LaserBeam& a, const LaserBeam& b, const LaserBeam& c) const {
  const Pair range_before{a.range, b.range};
  const Pair range{b.range, c.range};
  const Pair step = Pair{b.bearing, c.bearing} - Pair{a.bearing, b.bearing};
  const Pair off = step - step_;
  const Pair square =
      range * range + range_before * range_before - 2 * range * range_before * cosine_;
  const Pair limit = range_before * reach_ + noise_;
  return both((off < tolerance_) & (off > -tolerance_) & (range > 0) & (range < INFINITY) &
              (square <= limit * limit));
}

void Breakpoints::Options::declare(OptionVisitor& visit) {
  visit("incidence", incidence, "lambda: beams that meet a surface at less break it",
        {.unit = "rad", .minimum = 0, .maximum = 1.5707963267948966});
  visit("deviations", deviations, "sd of a range's noise that two readings of a surface may differ",
        {.minimum = 0});
  visit("least_readings", least_readings, "of a cluster", {.minimum = 1, .maximum = 1000000});
}

Interface Breakpoints::interface() {
  return {.inputs = {{"scan", &descriptor<LaserScan>()}},
          .output = &descriptor<SegmentedScan>(),
          .frame_of_input = 0};
}

Outcome<> Breakpoints::evaluate(const Evaluation& evaluation, Output& output) {
  const std::span<const LaserBeam> beams = beams_of(*evaluation.inputs[0]);
  const double deviation = noise_of(evaluation.input(0)).range_deviation();
  BreakpointRule rule(options_.incidence, options_.deviations * deviation);
  const std::span<SegmentedBeam> rows = make_rows<SegmentedBeam>(output, beams.size());
  double segment = 1;     // the open cluster's number
  std::size_t begin = 0;  // of the open cluster
  // Ends the open cluster before beam i; its number is the next one's if it was too small.
  const auto close = [&](std::size_t i) {
    if (i - begin >= static_cast<std::size_t>(options_.least_readings))
      ++segment;
    else
      for (; begin < i; ++begin) rows[begin].segment = 0;
    begin = i;
  };
  const auto write = [&](std::size_t i) { rows[i] = {beams[i].bearing, beams[i].range, segment}; };
  for (std::size_t i = 0; i < beams.size(); ++i) {
    for (;
         i > begin && i + 1 < beams.size() && rule.continues(beams[i - 1], beams[i], beams[i + 1]);
         i += 2) {
      write(i);
      write(i + 1);
    }
    if (i == beams.size()) break;
    const auto [bearing, range] = beams[i];
    if (!std::isfinite(bearing) || !(range >= 0 && range < INFINITY))
      return Fault{FaultKind::bad_data,
                   fmt::format("beam {}: bearing {}, range {}", i, bearing, range)};
    if (range == 0) {
      close(i);
      rows[i] = {bearing, 0, 0};
      begin = i + 1;
      continue;
    }
    if (i > begin && rule.breaks(beams[i - 1].range, range, bearing - beams[i - 1].bearing))
      close(i);
    write(i);
  }
  close(beams.size());
  if (segment == 1) return Fault{FaultKind::no_detection, "the scan has no cluster of readings"};
  output.estimate.value = evaluation.input(0).value;
  output.estimate.lineage = evaluation.input(0).lineage;
  return {};
}

}  // namespace ilss
