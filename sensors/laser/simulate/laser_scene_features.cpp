#include "sensors/laser/simulate/laser_scene_features.h"

#include <cmath>

namespace ilss {
namespace {

/// Pieces of fewer readings are left out of the small ones, too: two points are on many lines.
constexpr std::size_t least_small_readings = 3;

bool same_place(const ScenePoint& a, const ScenePoint& b) {
  constexpr double rounding = 1e-9;  // m
  return std::hypot(a.x - b.x, a.z - b.z) < rounding;
}

/// Where two walls meet end to end, if they do.
const ScenePoint* common_end(const Wall& a, const Wall& b) {
  for (const ScenePoint* end : {&a.from, &a.to})
    if (same_place(*end, b.from) || same_place(*end, b.to)) return end;
  return nullptr;
}

/// A wall's line in a frame: rho (m, not negative) and phi.
struct PlaneLine {
  double rho, phi;
};

PlaneLine line_of(const Wall& wall, const ScenePose& frame) {
  const ScenePoint from = to_frame(frame, wall.from);
  const ScenePoint to = to_frame(frame, wall.to);
  const double length = distance(from, to);
  const double x = -(to.z - from.z) / length;
  const double z = (to.x - from.x) / length;
  const double rho = x * from.x + z * from.z;
  return rho < 0 ? PlaneLine{-rho, std::atan2(-z, -x)} : PlaneLine{rho, std::atan2(z, x)};
}

}  // namespace

/// Writes the features of one scan.
class LaserSceneFeatures::Writer {
 public:
  Writer(const LaserSceneFeatures& scan, const ScenePose& robot, Output& output)
      : scene_(scan.world_.scene()),
        beams_(scan.beams_),
        pieces_(scan.pieces_),
        wanted_(scan.options_.pieces),
        robot_(robot),
        output_(output) {
    output_.elements.clear();
  }

  void write() {
    std::size_t segments = 0;
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      const VisiblePiece& piece = pieces_[p];
      if (is_wanted(piece.counts) && piece.readings() >= least_small_readings) {
        ++segments;
        piece.is_arc ? write_arc(piece) : write_line(piece);
      }
      if (p + 1 < pieces_.size() && pieces_[p + 1].first == piece.last + 1)
        write_between(piece, pieces_[p + 1]);
    }
    assign<RangeFeatures>(output_.estimate, {static_cast<double>(segments)});
  }

 private:
  bool is_wanted(bool counts) const { return counts == (wanted_ == CountedPieces::counted); }

  ScenePoint place(const ScenePoint& world) const { return to_frame(robot_, world); }

  const Wall& wall(const VisiblePiece& piece) const { return scene_.walls[piece.surface]; }

  template <template <typename> class Payload>
  void write(const Payload<double>& feature) {
    Estimate& element = output_.elements.emplace_back();
    element.type = &descriptor<Payload>();
    element.frame = output_.estimate.frame;
    assign<Payload>(element, feature);
  }

  void write_line(const VisiblePiece& piece) {
    const PlaneLine line = line_of(wall(piece), robot_);
    const ScenePoint start = place(beams_[piece.first].point);
    const ScenePoint end = place(beams_[piece.last].point);
    write<LineSegment>({line.rho, line.phi, start.x, start.z, end.x, end.z,
                        static_cast<double>(piece.readings()), static_cast<double>(piece.first),
                        static_cast<double>(piece.last)});
  }

  void write_arc(const VisiblePiece& piece) {
    const Pillar& pillar = scene_.pillars[piece.surface - scene_.walls.size()];
    const ScenePoint centre = place(pillar.centre);
    const ScenePoint start = place(beams_[piece.first].point);
    const ScenePoint end = place(beams_[piece.last].point);
    write<ArcSegment>({centre.x, centre.z, pillar.radius, start.x, start.z, end.x, end.z,
                       static_cast<double>(piece.readings()), static_cast<double>(piece.first),
                       static_cast<double>(piece.last)});
  }

  /// The corner or edge between two pieces of neighbouring beams.
  void write_between(const VisiblePiece& before, const VisiblePiece& after) {
    const ScenePoint* corner =
        before.is_arc || after.is_arc ? nullptr : common_end(wall(before), wall(after));
    if (corner != nullptr) return write_corner(before, after, *corner);
    const bool before_is_nearer = beams_[before.last].hit->range < beams_[after.first].hit->range;
    const VisiblePiece& nearer = before_is_nearer ? before : after;
    if (nearer.is_arc || !is_wanted(nearer.counts)) return;
    write_edge(nearer, beams_[before_is_nearer ? before.last : after.first].point);
  }

  /// Where of two walls only one counts, its end at the corner is no mistake for an edge either:
  /// there is next to nothing to be seen of the other.
  void write_corner(const VisiblePiece& before, const VisiblePiece& after,
                    const ScenePoint& corner) {
    if (!is_wanted(before.counts && after.counts)) return;
    const ScenePoint at = place(corner);
    write<Corner>({at.x, at.z, {static_cast<int>(CornerKind::real_corner)}});
    if (before.counts == after.counts) return;
    const VisiblePiece& counted = before.counts ? before : after;
    write<SurfaceEdge>({at.x, at.z, line_of(wall(counted), robot_).phi});
  }

  /// The end of a piece's wall that is nearest to where a beam met it last.
  void write_edge(const VisiblePiece& piece, const ScenePoint& last_met) {
    const Wall& surface = wall(piece);
    const bool at_from = distance(surface.from, last_met) < distance(surface.to, last_met);
    const ScenePoint at = place(at_from ? surface.from : surface.to);
    write<SurfaceEdge>({at.x, at.z, line_of(surface, robot_).phi});
  }

  const Scene& scene_;
  std::span<const TracedBeam> beams_;
  std::span<const VisiblePiece> pieces_;
  CountedPieces wanted_;
  const ScenePose& robot_;
  Output& output_;
};

void LaserSceneFeatures::Options::declare(OptionVisitor& visit) {
  world.declare(visit);
  visit("pieces", pieces, "which features: those that count, or those too small to");
  visit("frame", frame, "name of the robot's frame, x forward and z to the right");
}

Interface LaserSceneFeatures::interface(const Options& options) {
  return {.inputs = {},
          .output = &descriptor<RangeFeatures>(),
          .frame = options.frame,
          .draws_readings = true};
}

Outcome<> LaserSceneFeatures::evaluate(const Evaluation& evaluation, Output& output) {
  const Outcome<LaserStand> stand = world_.enter(evaluation);
  if (!stand) return stand.fault();
  trace_beams(world_.caster(), world_.sweep(), *stand, beams_);
  find_pieces(world_.scene(), beams_, pieces_);
  Writer(*this, stand->robot, output).write();
  output.acquired = Acquisition::at(evaluation.time);
  return {};
}

}  // namespace ilss
