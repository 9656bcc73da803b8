// Angles on the circle.
#pragma once

#include <cmath>
#include <numbers>

namespace ilss {

inline constexpr double radians_per_degree = std::numbers::pi / 180;
inline constexpr double degrees_per_radian = 180 / std::numbers::pi;

/// The same angle in [-pi, pi). Only whole turns are subtracted, so derivatives pass unchanged.
template <typename T>
T wrap_angle(T angle) {
  using std::floor;
  constexpr double turn = 2 * std::numbers::pi;
  T wrapped = angle - turn * floor((angle + std::numbers::pi) / turn);
  // The quotient may round up to the next whole number, or down from it.
  if (wrapped < -std::numbers::pi) wrapped += turn;
  if (wrapped >= std::numbers::pi) wrapped -= turn;
  return wrapped;
}

}  // namespace ilss
