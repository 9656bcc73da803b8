// Where exactly one segment ends and the next begins.
#pragma once

#include <algorithm>
#include <cmath>

#include "sensors/range/reading_run.h"

namespace ilss {

/// How far a boundary is moved, and by how many readings of each side it is judged.
inline constexpr std::size_t boundary_reach = 8;
inline constexpr std::size_t boundary_support = 40;

/// The boundary between two neighbouring runs, moved to where the two sides are explained best
/// (Núñez et al. 2009, sec. 3.2, after Diosi & Kleeman 2003: the point in the neighbourhood of a
/// corner where the sum of both lines' error variances is least). `cost_before(run)` and
/// `cost_after(run)` say how badly one side's curve explains a run. Both runs keep two readings,
/// and must have them.
template <typename CostBefore, typename CostAfter>
std::size_t placed_boundary(const ReadingRun& before, const ReadingRun& after, std::size_t reach,
                            const CostBefore& cost_before, const CostAfter& cost_after) {
  const std::size_t boundary = after.begin;
  const std::size_t begin = boundary - std::min(before.size(), boundary_support + reach);
  const std::size_t end = boundary + std::min(after.size(), boundary_support + reach);
  const std::size_t first = std::max(begin + 2, boundary - std::min(boundary, reach));
  const std::size_t last = std::min(end, boundary + reach + 2) - 2;
  double least = INFINITY;
  std::size_t best = boundary;
  for (std::size_t i = first; i <= last; ++i) {
    const double cost = cost_before(ReadingRun{begin, i}) + cost_after(ReadingRun{i, end});
    if (cost >= least) continue;
    least = cost;
    best = i;
  }
  return best;
}

}  // namespace ilss
