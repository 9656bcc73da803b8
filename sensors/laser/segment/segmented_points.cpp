#include "sensors/laser/segment/segmented_points.h"

#include <fmt/format.h>

#include <cmath>

namespace ilss {

namespace {

Fault bad_beam(const SegmentedBeam& beam, std::size_t i) {
  return {FaultKind::bad_data, fmt::format("beam {}: bearing {}, range {}, segment {}", i,
                                           beam.bearing, beam.range, beam.segment)};
}

}  // namespace

Outcome<> SegmentedPoints::read(const Output& scan) {
  const std::span<const SegmentedBeam> beams = segmented_beams_of(scan);
  runs_.clear();
  double open = 0;
  // Ends the open run before beam i, and begins the segment's.
  const auto change_to = [&](double segment, std::size_t i) {
    if (open != 0) runs_.back().end = i;
    if (segment != 0) runs_.push_back({i, i});
    open = segment;
  };
  buffer_.resize(beams.size());
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const SegmentedBeam& beam = beams[i];
    const bool has_return = beam.range > 0 && beam.range < INFINITY;
    if (!has_return || beam.segment != open || !buffer_.knows(i, beam.bearing)) {
      if (!std::isfinite(beam.bearing) || !std::isfinite(beam.range) || beam.range < 0 ||
          !std::isfinite(beam.segment))
        return bad_beam(beam, i);
      const double segment = has_return ? beam.segment : 0;
      if (segment != open) change_to(segment, i);
    }
    buffer_.set(i, beam.bearing, beam.range);
  }
  change_to(0, beams.size());
  points_ = buffer_.points();
  return {};
}

void SegmentedPoints::write(const Evaluation& evaluation, std::span<const ReadingRun> segments,
                            Output& output) const {
  const std::span<SegmentedBeam> beams = make_rows<SegmentedBeam>(output, points_.size());
  std::size_t written = 0;
  const auto write_until = [&](std::size_t end, double segment) {
    for (; written < end; ++written)
      beams[written] = {points_[written].bearing, points_[written].range, segment};
  };
  for (std::size_t k = 0; k < segments.size(); ++k) {
    write_until(segments[k].begin, 0);
    write_until(segments[k].end, static_cast<double>(k + 1));
  }
  write_until(beams.size(), 0);
  output.estimate.value = evaluation.input(0).value;
  output.estimate.lineage = evaluation.input(0).lineage;
}

}  // namespace ilss
