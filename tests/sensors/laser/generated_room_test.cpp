// The protocol of generated rooms, held against many of them.
#include "sensors/laser/generated_room.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "framework/estimate/angle.h"
#include "sensors/laser/visible_pieces.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr std::uint64_t rooms = 200;

double distance(const ScenePoint& a, const ScenePoint& b) {
  return std::hypot(a.x - b.x, a.z - b.z);
}

double direction(const Wall& wall) {
  return std::atan2(wall.to.z - wall.from.z, wall.to.x - wall.from.x);
}

TEST(GeneratedRoom, TurnsByThirtyDegreesOrMoreAtEveryCorner) {
  for (std::uint64_t seed = 0; seed < rooms; ++seed) {
    SCOPED_TRACE(seed);
    const Scene room = generate_room(seed);
    for (const Wall& wall : room.walls) {
      int neighbours = 0;
      for (const Wall& next : room.walls)
        if (distance(wall.to, next.from) < 1e-9) {
          ++neighbours;
          EXPECT_GE(std::abs(wrap_angle(direction(next) - direction(wall))), 30 * degree);
        }
      EXPECT_EQ(neighbours, 1) << "outlines are closed";
    }
  }
}

TEST(GeneratedRoom, HasPillarsAndWallsOfTheProtocolsSizes) {
  std::map<std::size_t, int> pillars;
  std::map<std::size_t, int> boxes;
  for (std::uint64_t seed = 0; seed < rooms; ++seed) {
    SCOPED_TRACE(seed);
    const Scene room = generate_room(seed);
    ++pillars[room.pillars.size()];
    for (const Pillar& pillar : room.pillars) {
      EXPECT_GE(pillar.radius, 0.3);
      EXPECT_LE(pillar.radius, 1.5);
    }
    std::size_t closed = 0;  // outlines: the room's and the boxes'
    for (std::size_t i = 0; i < room.walls.size(); ++i) {
      EXPECT_GE(distance(room.walls[i].from, room.walls[i].to), 0.5);
      EXPECT_LE(std::abs(room.walls[i].from.x), 6.3);
      EXPECT_LE(std::abs(room.walls[i].from.z), 6.3);
      closed +=
          i + 1 == room.walls.size() || distance(room.walls[i].to, room.walls[i + 1].from) > 1e-9;
    }
    ++boxes[closed - 1];
  }
  EXPECT_EQ(pillars[0], 0);
  EXPECT_GT(pillars[1], 20);
  EXPECT_GT(pillars[2], 20);
  EXPECT_GT(pillars[3], 20);
  EXPECT_GT(boxes[1] + boxes[2] + boxes[3] + boxes[4], 180);
  EXPECT_GT(boxes[3] + boxes[4], 40);
}

TEST(GeneratedRoom, FollowsFromItsSeed) {
  const Scene first = generate_room(3);
  const Scene again = generate_room(3);
  const Scene other = generate_room(4);
  EXPECT_EQ(first.walls[0].from.x, again.walls[0].from.x);
  EXPECT_EQ(first.pillars[0].radius, again.pillars[0].radius);
  EXPECT_NE(first.walls[0].from.x, other.walls[0].from.x);
}

TEST(GeneratedRoom, EveryStandpointShowsLinesAndArcsAndNothingBorderline) {
  for (std::uint64_t seed = 0; seed < rooms; ++seed) {
    SCOPED_TRACE(seed);
    const Scene room = generate_room(seed);
    const RayCaster caster(room);
    const auto robot = draw_standpoint(room, caster, {}, {}, seed);
    ASSERT_TRUE(robot);
    std::vector<TracedBeam> beams;
    std::vector<VisiblePiece> pieces;
    trace_beams(caster, {}, {*robot, {}}, beams);
    find_pieces(room, beams, pieces);
    int lines = 0;
    int arcs = 0;
    for (const VisiblePiece& piece : pieces) {
      if (!piece.counts) {
        EXPECT_LT(piece.readings(), 5u);
        continue;
      }
      ++(piece.is_arc ? arcs : lines);
      EXPECT_GE(piece.readings(), 10u);
      const ScenePoint& start = beams[piece.first].point;
      const ScenePoint& end = beams[piece.last].point;
      if (!piece.is_arc) {
        EXPECT_GE(distance(start, end), 0.5);
        continue;
      }
      const Pillar& pillar = room.pillars[piece.surface - room.walls.size()];
      EXPECT_GE(distance(start, end), pillar.radius * (1 - 1e-12));  // the chord of 60 degrees
    }
    EXPECT_GE(lines, 2);
    EXPECT_GE(arcs, 1);
    for (const TracedBeam& beam : beams) {
      ASSERT_TRUE(beam.hit) << "rooms are closed";
      EXPECT_GE(beam.hit->range, 0.5 - 1e-9);
    }
  }
}

TEST(GeneratedRoom, StandpointIsTheRobotsAndItsLaserStandsWhereTheMountSays) {
  const Scene room = generate_room(1);
  const RayCaster caster(room);
  const ScenePose mount{0.3, -0.1, 40 * degree};
  const auto carried = draw_standpoint(room, caster, {}, mount, 5);
  const auto bare = draw_standpoint(room, caster, {}, {}, 5);
  ASSERT_TRUE(carried && bare);
  const ScenePose laser = compose_poses(*carried, mount);
  EXPECT_NEAR(laser.x, bare->x, 1e-12);
  EXPECT_NEAR(laser.z, bare->z, 1e-12);
  EXPECT_NEAR(wrap_angle(laser.heading - bare->heading), 0, 1e-12);
}

}  // namespace
}  // namespace ilss
