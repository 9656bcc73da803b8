// Readings two by two: passes over them take half the time.
#pragma once

#include <cmath>
#include <span>

#include "sensors/laser/scan_points.h"

namespace ilss {

/// Two numbers that the processor works with at once (a vector of GCC's and Clang's, on any
/// processor); arithmetic is by element.
using Pair = double __attribute__((vector_size(2 * sizeof(double))));

inline double sum(const Pair& pair) { return pair[0] + pair[1]; }

/// Whether a comparison holds for both.
template <typename Comparison>
bool both(const Comparison& holds) {
  return (holds[0] & holds[1]) != 0;
}

inline Pair magnitude(const Pair& pair) { return Pair{std::abs(pair[0]), std::abs(pair[1])}; }

inline double square_root(double value) { return std::sqrt(value); }
inline Pair square_root(const Pair& pair) { return Pair{std::sqrt(pair[0]), std::sqrt(pair[1])}; }

/// Calls `add(p, q, present)` for every two readings; `present` holds ones. An odd reading at the
/// end comes as both, and `present` is 1 and 0.
template <typename Add>
void for_pairs(std::span<const ScanPoint> points, const Add& add) {
  std::size_t i = 0;
  for (; i + 1 < points.size(); i += 2) add(points[i], points[i + 1], Pair{1, 1});
  if (i < points.size()) add(points[i], points[i], Pair{1, 0});
}

}  // namespace ilss
