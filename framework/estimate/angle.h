// Angles on the circle.
#pragma once

#include <cmath>
#include <numbers>

namespace ilss {

/// The same angle in [-pi, pi). Only whole turns are subtracted, so derivatives pass unchanged.
template <typename T>
T wrap_angle(T angle) {
  using std::floor;
  constexpr double turn = 2 * std::numbers::pi;
  return angle - turn * floor((angle + std::numbers::pi) / turn);
}

}  // namespace ilss
