#include "sensors/laser/simulate/generated_room.h"

#include <algorithm>
#include <cmath>

#include "framework/estimate/angle.h"
#include "sensors/laser/simulate/visible_pieces.h"

namespace ilss {
namespace {

constexpr double half_room = 5;          // m, of the largest
constexpr double clearance = 0.5;        // m
constexpr int placement_attempts = 200;  // for a thing of one size
constexpr int standpoint_attempts = 5000;
constexpr std::size_t most_stray_readings = 4;  // of a piece that does not count

/// What a room is drawn with.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}
  double between(double low, double high) { return draw_uniform(random_, low, high); }
  /// Whole numbers from `low` to `high`.
  int whole(int low, int high) {
    return low + static_cast<int>(draw_index(random_, static_cast<std::uint64_t>(high - low) + 1));
  }
  bool chance(double probability) { return between(0, 1) < probability; }

 private:
  RandomBits random_;
};

double distance(const ScenePoint& point, const Wall& wall) {
  const double dx = wall.to.x - wall.from.x;
  const double dz = wall.to.z - wall.from.z;
  const double along =
      ((point.x - wall.from.x) * dx + (point.z - wall.from.z) * dz) / (dx * dx + dz * dz);
  const double share = std::clamp(along, 0.0, 1.0);
  return distance(point, ScenePoint{wall.from.x + share * dx, wall.from.z + share * dz});
}

/// Whether a point is in the room and in no box: whether a ray from it crosses walls an odd number
/// of times.
bool is_inside(const Scene& room, const ScenePoint& point) {
  bool inside = false;
  for (const Wall& wall : room.walls)
    if ((wall.from.z > point.z) != (wall.to.z > point.z))
      inside ^= point.x < wall.from.x + (wall.to.x - wall.from.x) * (point.z - wall.from.z) /
                                            (wall.to.z - wall.from.z);
  return inside;
}

/// Whether a disc around a point is free of walls and pillars.
bool is_free(const Scene& room, const ScenePoint& point, double radius) {
  return is_inside(room, point) &&
         std::all_of(room.walls.begin(), room.walls.end(),
                     [&](const Wall& wall) { return distance(point, wall) >= radius; }) &&
         std::all_of(room.pillars.begin(), room.pillars.end(), [&](const Pillar& pillar) {
           return distance(point, pillar.centre) >= radius + pillar.radius;
         });
}

ScenePoint draw_point(Draw& draw) {
  const double x = draw.between(-half_room, half_room);
  return {x, draw.between(-half_room, half_room)};
}

std::optional<ScenePoint> draw_place(const Scene& room, double radius, Draw& draw) {
  for (int i = 0; i < placement_attempts; ++i) {
    const ScenePoint place = draw_point(draw);
    if (is_free(room, place, radius + clearance)) return place;
  }
  return std::nullopt;
}

/// The outline's corners along one side, which runs along `direction` from `corner` for `length`:
/// the end of the cut at its start, perhaps a niche or a buttress, the start of the cut at its end.
void add_side(const ScenePoint& corner, const ScenePoint& direction, double length,
              double cut_at_start, double cut_at_end, Draw& draw,
              std::vector<ScenePoint>& outline) {
  const auto add = [&](double along, double outward) {
    outline.push_back({corner.x + along * direction.x + outward * direction.z,
                       corner.z + along * direction.z - outward * direction.x});
  };
  add(cut_at_start, 0);
  const double width = draw.between(1, 2.5);
  const double depth = draw.between(0.6, 1.2) * (draw.chance(0.5) ? 1 : -1);
  const double slant =
      std::abs(depth) / std::tan(draw.between(35 * radians_per_degree, 90 * radians_per_degree));
  const double taken = width + 2 * slant;
  constexpr double least_wall = 0.8;
  const double first = cut_at_start + least_wall;
  const double last = length - cut_at_end - least_wall - taken;
  const double share = draw.between(0, 1);
  if (draw.chance(0.3) && last > first) {
    const double begin = first + share * (last - first);
    add(begin, 0);
    add(begin + slant, depth);
    add(begin + slant + width, depth);
    add(begin + taken, 0);
  }
  if (cut_at_end > 0) add(length - cut_at_end, 0);
}

std::vector<ScenePoint> draw_outline(Draw& draw) {
  const double length = draw.between(6, 2 * half_room);
  const double width = draw.between(6, 2 * half_room);
  struct Cut {
    double before = 0, after = 0;
  };
  Cut cuts[4];
  for (Cut& cut : cuts) {
    const double size = draw.between(0.9, 2.2);
    const double angle = draw.between(32 * radians_per_degree, 58 * radians_per_degree);
    if (draw.chance(0.35)) cut = {size * std::cos(angle), size * std::sin(angle)};
  }
  const ScenePoint corners[4] = {{-length / 2, -width / 2},
                                 {length / 2, -width / 2},
                                 {length / 2, width / 2},
                                 {-length / 2, width / 2}};
  const ScenePoint directions[4] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  std::vector<ScenePoint> outline;
  for (std::size_t i = 0; i < 4; ++i)
    add_side(corners[i], directions[i], i % 2 == 0 ? length : width, cuts[i].after,
             cuts[(i + 1) % 4].before, draw, outline);
  return outline;
}

void add_walls(const std::vector<ScenePoint>& outline, Scene& room) {
  for (std::size_t i = 0; i < outline.size(); ++i)
    room.walls.push_back(
        {.from = outline[i], .to = outline[(i + 1) % outline.size()], .targets = {}});
}

void add_pillar(Draw& draw, Scene& room) {
  const double radius = draw.between(0.3, 1.5);
  if (const auto place = draw_place(room, radius, draw))
    room.pillars.push_back({.centre = *place, .radius = radius});
}

void add_box(Draw& draw, Scene& room) {
  const double length = draw.between(0.6, 2);
  const double width = draw.between(0.6, 2);
  const double angle = draw.between(0, std::numbers::pi);
  const auto place = draw_place(room, std::hypot(length, width) / 2, draw);
  if (!place) return;
  const ScenePose middle{place->x, place->z, angle};
  std::vector<ScenePoint> outline;
  for (const auto& [x, z] : {std::pair{1, 1}, {1, -1}, {-1, -1}, {-1, 1}}) {
    const ScenePose corner = compose_poses(middle, {0.5 * x * length, 0.5 * z * width, 0});
    outline.push_back({corner.x, corner.z});
  }
  add_walls(outline, room);
}

/// Where the robot stands whose laser stands at `laser`.
ScenePose carrier_of(const ScenePose& laser, const ScenePose& mount) {
  const ScenePose turned = compose_poses({0, 0, laser.heading - mount.heading}, mount);
  return {laser.x - turned.x, laser.z - turned.z, laser.heading - mount.heading};
}

/// Whether a scan shows several lines and an arc that count, and nothing borderline.
bool is_fair(const std::vector<VisiblePiece>& pieces) {
  constexpr int least_lines = 2;
  int lines = 0;
  int arcs = 0;
  for (const VisiblePiece& piece : pieces) {
    if (!piece.counts && piece.readings() > most_stray_readings) return false;
    if (piece.counts) ++(piece.is_arc ? arcs : lines);
  }
  return lines >= least_lines && arcs > 0;
}

}  // namespace

Scene generate_room(std::uint64_t seed) {
  Draw draw(seed);
  Scene room;
  room.description = "a generated room";
  add_walls(draw_outline(draw), room);
  // Pillars first: the large ones need the room.
  const int pillars = draw.whole(1, 3);
  for (int i = 0; i < pillars; ++i) add_pillar(draw, room);
  constexpr int pillar_attempts = 100;  // every room has a pillar
  for (int i = 0; i < pillar_attempts && room.pillars.empty(); ++i) add_pillar(draw, room);
  const int boxes = draw.whole(2, 4);
  for (int i = 0; i < boxes; ++i) add_box(draw, room);
  return room;
}

std::optional<ScenePose> draw_standpoint(const Scene& room, const RayCaster& caster,
                                         const LaserSweep& sweep, const ScenePose& mount,
                                         std::uint64_t seed) {
  Draw draw(seed);
  std::vector<TracedBeam> beams;
  std::vector<VisiblePiece> pieces;
  for (int i = 0; i < standpoint_attempts; ++i) {
    const ScenePoint place = draw_point(draw);
    const double heading = draw.between(-std::numbers::pi, std::numbers::pi);
    if (!is_free(room, place, clearance)) continue;
    const ScenePose robot = carrier_of({place.x, place.z, heading}, mount);
    trace_beams(caster, sweep, {robot, mount}, beams);
    find_pieces(room, beams, pieces);
    if (is_fair(pieces)) return robot;
  }
  return std::nullopt;
}

}  // namespace ilss
