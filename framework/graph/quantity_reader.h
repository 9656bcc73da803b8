// Quantities as users write them: a number, its unit, and what is said of its error.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "framework/estimate/distribution.h"
#include "framework/module/document.h"

namespace ilss {

/// A number in the unit it was written in, and its standard deviation in that unit.
struct WrittenQuantity {
  double number = 0;
  std::string unit = {};
  std::optional<double> standard_deviation = {};
  Position position = {};
  Distribution distribution = {};
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
};

/// Reads `11 deg` or `{value: 11 deg, std: 0.3 deg}`. A std without a unit is refused unless the
/// value has none either. The error may have a `distribution` (normal, uniform, triangular,
/// arcsine, t, or `{samples: FILE, column: NAME}`, a CSV file, relative to where the value stands),
/// a `half_width` instead of the std where the law is bounded, and `degrees_of_freedom`.
std::optional<WrittenQuantity> read_quantity(const Node& node, Diagnostics& diagnostics);

/// Its value and the scale of its errors in an SI unit; a wrong dimension goes to `diagnostics`.
struct SiQuantity {
  double value;
  double scale;
};
std::optional<SiQuantity> to_si(const WrittenQuantity& quantity, std::string_view si_unit,
                                Diagnostics& diagnostics);

}  // namespace ilss
