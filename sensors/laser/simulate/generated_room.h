// Rooms to try segmenters in: walls, boxes and pillars at random, and places to scan them from.
#pragma once

#include <cstdint>
#include <optional>

#include "sensors/laser/simulate/laser_simulation.h"

namespace ilss {

/// A room in the manner of the maps of Núñez et al. 2009, sec. 5: 6 to 10 m by 6 to 10 m, some of
/// its corners cut off and some of its walls with a niche or a buttress, so that it turns by 30
/// degrees or more at every corner; in it one to three pillars of radius 0.3 to 1.5 m and two to
/// four boxes of 0.6 to 2 m at any angle, all at least 0.5 m apart. Its middle is the world's
/// origin. As many of the things as find a place are there.
Scene generate_room(std::uint64_t seed);

/// Draws where in a room to scan from: anywhere at least 0.5 m from every surface, with any
/// heading, such that the scan is fair: two walls or more and a pillar show pieces that count
/// (visible_pieces.h), and so does every piece that five beams or more meet, so that none is
/// borderline; what is not fair is drawn again. `mount` is the laser's on the robot; the pose is
/// the robot's. Nothing where 5,000 draws did not find such a place.
std::optional<ScenePose> draw_standpoint(const Scene& room, const RayCaster& caster,
                                         const LaserSweep& sweep, const ScenePose& mount,
                                         std::uint64_t seed);

}  // namespace ilss
