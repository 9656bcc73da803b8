#include "sensors/laser/simulate/visible_pieces.h"

#include <cmath>

#include "framework/estimate/angle.h"

namespace ilss {
namespace {

/// How much of a circle lies between two of its points (rad).
double span_between(const ScenePoint& centre, const ScenePoint& a, const ScenePoint& b) {
  return std::abs(wrap_angle(std::atan2(a.z - centre.z, a.x - centre.x) -
                             std::atan2(b.z - centre.z, b.x - centre.x)));
}

bool counts(const Scene& scene, std::span<const TracedBeam> beams, const VisiblePiece& piece) {
  if (piece.readings() < least_counted_readings) return false;
  const ScenePoint& start = beams[piece.first].point;
  const ScenePoint& end = beams[piece.last].point;
  if (!piece.is_arc) return distance(start, end) >= least_counted_length;
  const Pillar& pillar = scene.pillars[piece.surface - scene.walls.size()];
  return span_between(pillar.centre, start, end) >= least_counted_span;
}

}  // namespace

void find_pieces(const Scene& scene, std::span<const TracedBeam> beams,
                 std::vector<VisiblePiece>& pieces) {
  pieces.clear();
  for (std::size_t i = 0; i < beams.size(); ++i) {
    if (!beams[i].hit) continue;
    const std::size_t surface = beams[i].hit->surface;
    if (!pieces.empty() && pieces.back().last + 1 == i && pieces.back().surface == surface)
      pieces.back().last = i;
    else
      pieces.push_back(
          {.surface = surface, .first = i, .last = i, .is_arc = surface >= scene.walls.size()});
  }
  for (VisiblePiece& piece : pieces) piece.counts = counts(scene, beams, piece);
}

}  // namespace ilss
