// Heights of a target's line on a camera's image plane.
#pragma once

#include "framework/estimate/payload.h"

namespace ilss {

/// The height on the image plane, up from the optical axis, of a wall target's horizontal line: at
/// the left stripe, at the image's centre column and at the right stripe (Henderson & Dekhil 1997,
/// sec. 2.2). A line at height Y0 above the axis and depth z shows at y = f Y0 / z.
template <typename T>
struct TargetRows {
  T y_l, y_c, y_r;

  static constexpr std::string_view name = "target_rows";
  static constexpr std::string_view documentation =
      "height of a target's line on the image plane at three columns";
  static constexpr auto fields = Fields{{"y_l", "m", "at the left stripe"},
                                        {"y_c", "m", "at the column of the optical axis"},
                                        {"y_r", "m", "at the right stripe"}};
};

}  // namespace ilss
