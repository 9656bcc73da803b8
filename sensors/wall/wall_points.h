// Two points on a wall's trace in the plane of motion.
#pragma once

#include "framework/estimate/payload.h"

namespace ilss {

/// How a pair of sonars touched the wall: for each, at the beam's lower edge (-), as a tangent (0)
/// or at its upper edge (+). `none` where no sonar pair was involved.
inline constexpr std::string_view wall_contacts[] = {"none",  "(-,-)", "(-,0)", "(-,+)", "(0,-)",
                                                     "(0,0)", "(0,+)", "(+,-)", "(+,0)", "(+,+)"};
inline constexpr LabelField wall_points_labels[] = {{"contact", wall_contacts}};

/// Two points on the wall's trace, in the axes of their frame: in `camera` x is to the right and z
/// forward, in `robot` x is forward and z to the right (the papers' planes). The four components
/// come from two unknowns, so the covariance has rank 2 at most where nothing else is uncertain.
template <typename T>
struct WallPoints {
  T x1, z1, x2, z2;
  std::array<int, 1> label{};

  static constexpr std::string_view name = "wall_points";
  static constexpr std::string_view documentation = "two points on a wall's trace";
  static constexpr auto fields = Fields{{"x1", "m", "first point"},
                                        {"z1", "m", "first point"},
                                        {"x2", "m", "second point"},
                                        {"z2", "m", "second point"}};
  static constexpr std::span<const LabelField> labels = wall_points_labels;
};

}  // namespace ilss
