// The protocol of generated rooms, held against many of them.
#include "sensors/laser/simulate/generated_room.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "framework/estimate/angle.h"
#include "sensors/laser/simulate/visible_pieces.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr std::uint64_t rooms = 200;

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

TEST(GeneratedRoom, HasOneToThreePillarsOfTheProtocolsRadii) {
  std::map<std::size_t, int> counts;
  std::vector<double> radii;
  for (std::uint64_t seed = 0; seed < rooms; ++seed) {
    const Scene room = generate_room(seed);
    ++counts[room.pillars.size()];
    for (const Pillar& pillar : room.pillars) radii.push_back(pillar.radius);
  }
  EXPECT_EQ(counts.size(), 3u);
  for (const std::size_t count : {1u, 2u, 3u}) EXPECT_GT(counts[count], 20) << count;
  EXPECT_GE(std::ranges::min(radii), 0.3);
  EXPECT_LE(std::ranges::max(radii), 1.5);
  EXPECT_GT(std::ranges::max(radii), 1.2) << "large ones find a place, too";
}

/// How many closed outlines a room has: its own and its boxes'.
int outlines_of(const Scene& room) {
  int closed = 0;
  for (std::size_t i = 0; i < room.walls.size(); ++i)
    if (i + 1 == room.walls.size() || distance(room.walls[i].to, room.walls[i + 1].from) > 1e-9)
      ++closed;
  return closed;
}

TEST(GeneratedRoom, HasBoxesAndWallsOfHalfAMetreOrMore) {
  std::map<int, int> boxes;
  for (std::uint64_t seed = 0; seed < rooms; ++seed) {
    SCOPED_TRACE(seed);
    const Scene room = generate_room(seed);
    ++boxes[outlines_of(room) - 1];
    for (const Wall& wall : room.walls) {
      EXPECT_GE(distance(wall.from, wall.to), 0.5);
      EXPECT_LE(std::max(std::abs(wall.from.x), std::abs(wall.from.z)), 5 + 1.2) << "and a niche";
    }
  }
  EXPECT_LT(boxes[0], 20);
  EXPECT_GT(boxes[3] + boxes[4], 40);
  EXPECT_LE(boxes.rbegin()->first, 4);
}

TEST(GeneratedRoom, FollowsFromItsSeed) {
  const Scene first = generate_room(3);
  const Scene again = generate_room(3);
  const Scene other = generate_room(4);
  EXPECT_EQ(first.walls[0].from.x, again.walls[0].from.x);
  EXPECT_EQ(first.pillars[0].radius, again.pillars[0].radius);
  EXPECT_NE(first.walls[0].from.x, other.walls[0].from.x);
}

/// What a drawn standpoint shows.
struct ShownRoom {
  Scene room;
  std::vector<TracedBeam> beams;
  std::vector<VisiblePiece> pieces;

  /// How long a piece is, from its first to its last beam (m).
  double chord(const VisiblePiece& piece) const {
    return distance(beams[piece.first].point, beams[piece.last].point);
  }
  auto count(bool arcs) const {
    return std::ranges::count_if(
        pieces, [arcs](const VisiblePiece& piece) { return piece.counts && piece.is_arc == arcs; });
  }
};

ShownRoom show_room(std::uint64_t seed) {
  ShownRoom shown;
  shown.room = generate_room(seed);
  const RayCaster caster(shown.room);
  const auto robot = draw_standpoint(shown.room, caster, {}, {}, seed);
  EXPECT_TRUE(robot);
  trace_beams(caster, {}, {robot.value(), {}}, shown.beams);
  find_pieces(shown.room, shown.beams, shown.pieces);
  return shown;
}

TEST(GeneratedRoom, EveryStandpointShowsLinesAndAnArcFromHalfAMetreOrMore) {
  for (std::uint64_t seed = 0; seed < rooms; ++seed) {
    SCOPED_TRACE(seed);
    const ShownRoom shown = show_room(seed);
    EXPECT_GE(shown.count(false), 2);
    EXPECT_GE(shown.count(true), 1);
    EXPECT_TRUE(std::ranges::all_of(shown.beams, [](const TracedBeam& beam) {
      return beam.hit && beam.hit->range >= 0.5 - 1e-9;
    }));
  }
}

TEST(GeneratedRoom, WhatCountsIsLargeEnoughAndWhatDoesNotHasFourReadingsAtMost) {
  for (std::uint64_t seed = 0; seed < rooms; ++seed) {
    SCOPED_TRACE(seed);
    const ShownRoom shown = show_room(seed);
    for (const VisiblePiece& piece : shown.pieces) {
      const bool is_small = piece.readings() <= 4;
      EXPECT_EQ(piece.counts, !is_small);
      if (is_small) continue;
      EXPECT_GE(piece.readings(), 10u);
      // The chord of 60 degrees is as long as the radius.
      const double least =
          piece.is_arc ? shown.room.pillars[piece.surface - shown.room.walls.size()].radius : 0.5;
      EXPECT_GE(shown.chord(piece), least * (1 - 1e-12));
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
