// Quantities with units, read by UDUNITS-2; angle counts as a dimension of its own.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace ilss {

/// How a unit relates to an SI unit: si = scale * x + offset.
struct UnitConversion {
  double scale = 1;
  double offset = 0;
};

/// The conversion from `unit` to `si_unit`, or what is wrong: an unknown unit, or another dimension
/// ("deg" is an angle, where a length (m) is expected). Thread-safe; remembers what it has read.
std::variant<UnitConversion, std::string> unit_conversion(std::string_view unit,
                                                          std::string_view si_unit);

/// The SI unit of the same dimension: "m" of "nm", "rad" of "deg", "m.s-1" of "km/h", "1" of none;
/// nothing where the unit is unknown or none that a number can be converted to (decibels).
std::optional<std::string> si_unit(std::string_view unit);

/// A number followed by a unit, or a bare number: "11 deg", "-3.5e-2 m/s", "0.5".
struct QuantityText {
  double number;
  std::string_view unit;  ///< empty where there is none
};

/// Splits a quantity's text; the error says what was expected.
std::variant<QuantityText, std::string> split_quantity(std::string_view text);

/// The value of a quantity in the SI unit, or what is wrong with it. A bare number is refused
/// unless `si_unit` is "1", or the number is 0.
std::variant<double, std::string> parse_quantity(std::string_view text, std::string_view si_unit);

/// A name for the dimension of an SI unit: "a length (m)".
std::string dimension_name(std::string_view si_unit);

}  // namespace ilss
