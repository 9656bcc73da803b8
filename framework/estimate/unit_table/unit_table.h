// What UDUNITS-2 says of the units that graphs mostly use, so that its database need not be read
// for them. The tables are written by write_unit_table.cpp while ilss is built.
#pragma once

#include <span>
#include <string_view>

#include "framework/estimate/units.h"

namespace ilss {

/// A unit, and the base units of its dimension.
struct OrdinaryUnit {
  std::string_view unit;
  std::string_view base;
};
extern const std::span<const OrdinaryUnit> ordinary_units;

/// `si_unit` as modules write it, or base units.
struct OrdinaryConversion {
  std::string_view unit;
  std::string_view si_unit;
  UnitConversion conversion;
};
extern const std::span<const OrdinaryConversion> ordinary_conversions;

}  // namespace ilss
