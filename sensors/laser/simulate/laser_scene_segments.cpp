#include "sensors/laser/simulate/laser_scene_segments.h"

namespace ilss {

void LaserSceneSegments::Options::declare(OptionVisitor& visit) {
  world.declare(visit);
  visit("frame", frame, "name of the laser's frame, x forward and y to the left");
}

Interface LaserSceneSegments::interface(const Options& options) {
  return {.inputs = {},
          .output = &descriptor<SegmentedScan>(),
          .frame = options.frame,
          .draws_readings = true};
}

Outcome<> LaserSceneSegments::evaluate(const Evaluation& evaluation, Output& output) {
  const Outcome<LaserStand> stand = world_.enter(evaluation);
  if (!stand) return stand.fault();
  scan_.resize(world_.sweep().beams);
  surfaces_.resize(scan_.size());
  world_.scan(evaluation, *stand, true, scan_, surfaces_);
  trace_beams(world_.caster(), world_.sweep(), *stand, beams_);
  find_pieces(world_.scene(), beams_, pieces_);
  const std::span<SegmentedBeam> beams = make_rows<SegmentedBeam>(output, scan_.size());
  for (std::size_t i = 0; i < beams.size(); ++i) beams[i] = {scan_[i].bearing, scan_[i].range, 0};
  double segment = 0;
  for (const VisiblePiece& piece : pieces_) {
    if (!piece.counts) continue;
    ++segment;
    for (std::size_t i = piece.first; i <= piece.last; ++i)
      if (surfaces_[i] == piece.surface) beams[i].segment = segment;
  }
  world_.describe(evaluation, output.estimate);
  output.acquired = {evaluation.time - duration_of(world_.sweep().duration), evaluation.time};
  return {};
}

}  // namespace ilss
