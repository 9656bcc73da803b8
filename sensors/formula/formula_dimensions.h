// Whether a formula's units fit together.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "framework/estimate/dimension.h"
#include "sensors/formula/tape.h"

namespace ilss {

/// What is wrong with the dimensions of a tape's formula, as sentences such as "adds a length (m)
/// and an angle (rad)": what is added or compared must be alike, sin, cos and tan take angles, exp
/// and log pure numbers; a power of what is not a pure number has an exponent without variables.
/// The number 0 fits anywhere. `result` is the dimension that the formula must have, if it is
/// known.
std::vector<std::string> check_dimensions(const Tape& tape, std::size_t formula,
                                          const std::vector<Dimension>& arguments,
                                          const std::optional<Dimension>& result);

}  // namespace ilss
