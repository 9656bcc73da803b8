// What a scan shows of a scene: pieces of walls and pillars, run by run of beams.
#pragma once

#include <span>
#include <vector>

#include "sensors/laser/simulate/laser_simulation.h"

namespace ilss {

/// A run of neighbouring beams that meet one wall or pillar.
struct VisiblePiece {
  std::size_t surface = 0;  ///< index into the scene's walls and, after these, its pillars
  std::size_t first = 0;    ///< beam
  std::size_t last = 0;     ///< beam, the piece's own
  bool is_arc = false;
  bool counts = false;  ///< whether a feature of it can be asked for

  std::size_t readings() const { return last - first + 1; }
};

/// What counts, by the protocol of Núñez et al. 2009, sec. 5: pieces of
/// at least 10 readings; of walls that are at least 50 cm long from first to last reading, of
/// pillars that span at least 60 degrees of the circle.
inline constexpr std::size_t least_counted_readings = 10;
inline constexpr double least_counted_length = 0.5;                 // m
inline constexpr double least_counted_span = std::numbers::pi / 3;  // rad

/// Takes traced beams apart into pieces, in the order of the beams.
void find_pieces(const Scene& scene, std::span<const TracedBeam> beams,
                 std::vector<VisiblePiece>& pieces);

}  // namespace ilss
