#include "sensors/features/wall_from_segments.h"

#include <cmath>

namespace ilss {
namespace {

/// Components of line_segment that become wall points: both ends' x and z.
constexpr std::size_t first_end = index_of<LineSegment>("start_x");
constexpr std::size_t end_count = 4;

/// Whether the ray from the origin at `bearing` meets the segment.
bool is_met(const LineSegment<double>& segment, double bearing) {
  const double c = std::cos(bearing);
  const double s = std::sin(bearing);
  const double start = c * segment.start_z - s * segment.start_x;
  const double end = c * segment.end_z - s * segment.end_x;
  if ((start < 0) == (end < 0)) return false;
  const double share = start / (start - end);
  const double x = segment.start_x + share * (segment.end_x - segment.start_x);
  const double z = segment.start_z + share * (segment.end_z - segment.start_z);
  return c * x + s * z > 0;
}

}  // namespace

void WallFromSegments::Options::declare(OptionVisitor& visit) {
  visit("bearing", bearing, "at which the wall is seen, from x towards z; without: the longest",
        {.unit = "rad"});
}

Interface WallFromSegments::interface() {
  return {.inputs = {{"features", &descriptor<RangeFeatures>()}},
          .output = &descriptor<WallPoints>(),
          .frame_of_input = 0};
}

Outcome<> WallFromSegments::evaluate(const Evaluation& evaluation, Output& output) {
  const Estimate* best = nullptr;
  double longest = 0;
  for (const Estimate& element : evaluation.inputs[0]->elements) {
    if (element.type->name != LineSegment<double>::name) continue;
    const auto segment = payload_of<LineSegment>(element);
    if (options_.bearing && !is_met(segment, *options_.bearing)) continue;
    const double length =
        std::hypot(segment.end_x - segment.start_x, segment.end_z - segment.start_z);
    if (best != nullptr && length <= longest) continue;
    best = &element;
    longest = length;
  }
  if (best == nullptr)
    return Fault{FaultKind::no_detection, options_.bearing ? "no segment lies at the bearing"
                                                           : "the scan has no line segment"};
  const auto segment = payload_of<LineSegment>(*best);
  assign<WallPoints>(output.estimate,
                     {segment.start_x, segment.start_z, segment.end_x, segment.end_z, {}});
  for (std::size_t k = 0; k < best->lineage.size(); ++k)
    output.estimate.lineage.add(best->lineage.sources()[k],
                                best->lineage.column(k).subspan(first_end, end_count));
  return {};
}

}  // namespace ilss
