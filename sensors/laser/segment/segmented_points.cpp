#include "sensors/laser/segment/segmented_points.h"

#include <fmt/format.h>

#include <cmath>

namespace ilss {

Outcome<> SegmentedPoints::read(const Output& scan) {
  const std::span<const SegmentedBeam> beams = segmented_beams_of(scan);
  runs_.clear();
  double open = 0;
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const SegmentedBeam& beam = beams[i];
    if (!std::isfinite(beam.bearing) || !std::isfinite(beam.range) || beam.range < 0 ||
        !std::isfinite(beam.segment))
      return Fault{FaultKind::bad_data, fmt::format("beam {}: bearing {}, range {}, segment {}", i,
                                                    beam.bearing, beam.range, beam.segment)};
    const double segment = beam.range > 0 ? beam.segment : 0;
    if (segment != 0 && segment == open)
      runs_.back().end = i + 1;
    else if (segment != 0)
      runs_.push_back({i, i + 1});
    open = segment;
  }
  points_ = buffer_.update(beams);
  return {};
}

void SegmentedPoints::write(const Evaluation& evaluation, std::span<const ReadingRun> segments,
                            Output& output) const {
  const std::span<SegmentedBeam> beams = make_rows<SegmentedBeam>(output, points_.size());
  for (std::size_t i = 0; i < beams.size(); ++i)
    beams[i] = {points_[i].bearing, points_[i].range, 0};
  for (std::size_t k = 0; k < segments.size(); ++k)
    for (std::size_t i = segments[k].begin; i < segments[k].end; ++i)
      beams[i].segment = static_cast<double>(k + 1);
  output.estimate.value = evaluation.input(0).value;
  output.estimate.lineage = evaluation.input(0).lineage;
}

}  // namespace ilss
