#include "sensors/laser/segmenter.h"

namespace ilss {

void SegmentRule::declare(OptionVisitor& visit) {
  visit("least_readings", least_readings, "of a segment", {.minimum = 2, .maximum = 1000000});
  visit("least_length", least_length, "of a segment, from its first to its last point",
        {.unit = "m", .minimum = 0});
}

bool SegmentRule::accepts(std::span<const ScanPoint> segment) const {
  if (static_cast<std::int64_t>(segment.size()) < least_readings) return false;
  const ScanPoint& first = segment.front();
  const ScanPoint& last = segment.back();
  return std::hypot(last.x - first.x, last.y - first.y) >= least_length;
}

Outcome<> ClusterSegmentation::read(const Output& scan) {
  const std::span<const SegmentedBeam> beams = segmented_beams_of(scan);
  clusters_.clear();
  double open = 0;
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const SegmentedBeam& beam = beams[i];
    if (!std::isfinite(beam.bearing) || !std::isfinite(beam.range) || beam.range < 0 ||
        !std::isfinite(beam.segment))
      return Fault{FaultKind::bad_data, fmt::format("beam {}: bearing {}, range {}, segment {}", i,
                                                    beam.bearing, beam.range, beam.segment)};
    const double segment = beam.range > 0 ? beam.segment : 0;
    if (segment != 0 && segment == open)
      clusters_.back().end = i + 1;
    else if (segment != 0)
      clusters_.push_back({i, i + 1});
    open = segment;
  }
  points_ = buffer_.update(beams);
  return {};
}

void ClusterSegmentation::write(const Evaluation& evaluation, std::span<const ReadingRun> runs,
                                Output& output) const {
  const std::span<SegmentedBeam> beams = make_rows<SegmentedBeam>(output, points_.size());
  for (std::size_t i = 0; i < beams.size(); ++i)
    beams[i] = {points_[i].bearing, points_[i].range, 0};
  for (std::size_t k = 0; k < runs.size(); ++k)
    for (std::size_t i = runs[k].begin; i < runs[k].end; ++i)
      beams[i].segment = static_cast<double>(k + 1);
  output.estimate.value = evaluation.input(0).value;
  output.estimate.lineage = evaluation.input(0).lineage;
}

}  // namespace ilss
