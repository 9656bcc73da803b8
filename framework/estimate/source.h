// Sources of error: the independent elementary errors that estimates inherit.
#pragma once

#include <compare>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "framework/estimate/distribution.h"

namespace ilss {

/// The tick of a persistent source: an error that is the same at every tick.
inline constexpr std::int64_t persistent_tick = -1;

/// One independent error of zero mean and unit variance. Two estimates that hold the same Source
/// share that error; a source of one owner at another tick is another error, unless persistent.
struct Source {
  std::uint32_t owner = 0;   ///< who is to blame: an index into the plan's SourceOwners
  std::uint32_t column = 0;  ///< which of the owner's errors
  std::int64_t tick = 0;     ///< when it was drawn, or `persistent_tick`

  bool persistent() const { return tick == persistent_tick; }
  auto operator<=>(const Source&) const = default;
};

/// Who owns sources: a module (its noise), a constant or a parameter (its limited accuracy).
struct SourceOwner {
  std::string name;
  bool persistent = false;
  Distribution distribution = {};  ///< of each of its sources
  /// Of the standard deviation, where that was itself estimated; infinite where it is known.
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
};

/// Every owner of a plan; a Source's `owner` is an index into it.
using SourceOwners = std::vector<SourceOwner>;

}  // namespace ilss
