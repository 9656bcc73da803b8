// Quantities: what is read, what is refused and why.
#include "framework/estimate/units.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "framework/estimate/random.h"

namespace ilss {
namespace {

using namespace std::string_view_literals;

std::string error_of(std::string_view text, std::string_view unit) {
  const auto result = parse_quantity(text, unit);
  const auto* error = std::get_if<std::string>(&result);
  return error == nullptr ? "read as " + std::to_string(std::get<double>(result)) : *error;
}

TEST(ParseQuantity, ReadsQuantitiesInTheirUnits) {
  constexpr double degree = std::numbers::pi / 180;
  const struct {
    std::string_view text, unit;
    double value;
  } table[] = {
      {"1e-3 m", "m", 1e-3},
      {"34.2 mm", "m", 0.0342},
      {"34.2mm", "m", 0.0342},
      {"  5   km\t", "m", 5000},
      {"+5 m", "m", 5},
      {"-5 m", "m", -5},
      {"5 um", "m", 5e-6},
      {"5 \u00b5m", "m", 5e-6},
      {"5 \u03bcm", "m", 5e-6},
      {"5 inch", "m", 0.127},
      {"0", "m", 0},
      {"-0", "m", 0},
      {"0.0", "rad", 0},
      {"11 deg", "rad", 11 * degree},
      {"11deg", "rad", 11 * degree},
      {"11 \u00b0", "rad", 11 * degree},
      {"1 mrad", "rad", 1e-3},
      {"1 turn", "rad", 2 * std::numbers::pi},
      {"90 deg/s", "rad/s", 90 * degree},
      {"60 rpm", "rad/s", 2 * std::numbers::pi},
      {"2 mm/deg", "m/rad", 2e-3 / degree},
      {"4 deg2", "rad2", 4 * degree * degree},
      {"4 sr", "rad2", 4},
      {"3 lm", "cd.rad2", 3},
      {"3 gray", "m2.s-2", 3},
      {"5 mm/s", "m/s", 5e-3},
      {"5 kHz", "Hz", 5000},
      {"5 1/s", "Hz", 5},
      {"0.5 1/m", "1/m", 0.5},
      {"0.5 m-1", "1/m", 0.5},
      {"0.5 m^-1", "1/m", 0.5},
      {"2 cm^2", "m2", 2e-4},
      {"2 kg.m2/s2", "J", 2},
      {"2 kg/(m.s2)", "Pa", 2},
      {"20 ms", "s", 0.02},
      {"300 K", "K", 300},
      {"20 degC", "K", 293.15},
      {"50 degF", "K", 283.15},
      {"7 nA", "A", 7e-9},
      {"0.5", "1", 0.5},
      {"5 %", "1", 0.05},
  };
  for (const auto& entry : table) {
    const auto result = parse_quantity(entry.text, entry.unit);
    const double* value = std::get_if<double>(&result);
    ASSERT_NE(value, nullptr) << entry.text << ": " << std::get<std::string>(result);
    EXPECT_NEAR(*value, entry.value, 1e-12 * std::abs(entry.value)) << entry.text;
  }
}

TEST(ParseQuantity, SaysWhatIsWrong) {
  const struct {
    std::string_view text, unit, error;
  } table[] = {
      {"5 mm/s", "m", "'mm/s' is not a length (m)"},
      {"11 deg", "m", "'deg' is not a length (m)"},
      {"11 deg", "1", "'deg' is not a pure number"},
      {"11 rad", "1", "'rad' is not a pure number"},
      {"11", "rad", "'11' has no unit; expected an angle (rad)"},
      {"11 %", "rad", "'%' is not an angle (rad)"},
      {"1 sr", "rad", "'sr' is not an angle (rad)"},
      {"1 sr", "1", "'sr' is not a pure number"},
      {"1 rad/s", "Hz", "'rad/s' is not a frequency (Hz)"},
      {"1 Hz", "rad/s", "'Hz' is not an angular rate (rad/s)"},
      {"1 1/s", "rad/s", "'1/s' is not an angular rate (rad/s)"},
      {"1 m", "m/rad", "'m' is not a length per angle (m/rad)"},
      {"1 m/rad", "m", "'m/rad' is not a length (m)"},
      {"1 deg2", "rad", "'deg2' is not an angle (rad)"},
      {"1 1/rad", "rad", "'1/rad' is not an angle (rad)"},
      {"1 s", "Hz", "'s' is not a frequency (Hz)"},
      {"1 Hz", "s", "'Hz' is not a time (s)"},
      {"1 dBm", "W", "'dBm' is not a quantity in W"},
      {"5", "m", "'5' has no unit; expected a length (m)"},
      {"nan m", "m",
       "'nan m' is not a quantity; expected a finite number and a unit, such as '11 deg'"},
      {"inf m", "m",
       "'inf m' is not a quantity; expected a finite number and a unit, such as '11 deg'"},
      {"-infinity", "1",
       "'-infinity' is not a quantity; expected a finite number and a unit, such as '11 deg'"},
      {"m", "m", "'m' is not a quantity; expected a finite number and a unit, such as '11 deg'"},
      {"", "m", "'' is not a quantity; expected a finite number and a unit, such as '11 deg'"},
      {"+-5 m", "m",
       "'+-5 m' is not a quantity; expected a finite number and a unit, such as '11 deg'"},
      {"1e999 m", "m", "'1e999 m' is too large or too small for a number"},
      {"1e308 km", "m", "'1e308 km' is too large in m"},
      {"1/2 m", "m", "unknown unit '/2 m'; expected a length (m)"},
      {"1,5 m", "m", "unknown unit ',5 m'; expected a length (m)"},
      {"1 000 mm", "m", "unknown unit '000 mm'; expected a length (m)"},
      {"11 12 deg", "rad", "unknown unit '12 deg'; expected an angle (rad)"},
      {"5 -3 m", "m", "unknown unit '-3 m'; expected a length (m)"},
      {"5 m 3", "m", "unknown unit 'm 3'; expected a length (m)"},
      {"5 m)", "m", "unknown unit 'm)'; expected a length (m)"},
      {"5 rad @ 5", "rad", "unknown unit 'rad @ 5'; expected an angle (rad)"},
      {"5 s since 2000-01-01", "s", "unknown unit 's since 2000-01-01'; expected a time (s)"},
      {"5 lightyearz", "m", "unknown unit 'lightyearz'; expected a length (m)"},
  };
  for (const auto& entry : table) EXPECT_EQ(error_of(entry.text, entry.unit), entry.error);
}

TEST(ParseQuantity, DoesNotStopAtAnEmbeddedZero) {
  EXPECT_EQ(error_of("5 m\0s"sv, "m"), "unknown unit 'm\0s'; expected a length (m)"sv);
}

TEST(ParseQuantity, CutsVeryLongTextsInItsMessages) {
  EXPECT_LT(error_of("5 " + std::string(100'000, 'm'), "m").size(), 200u);
  EXPECT_LT(error_of(std::string(100'000, 'x'), "m").size(), 200u);
  const auto digits = parse_quantity("1." + std::string(100'000, '3') + " m", "m");
  EXPECT_DOUBLE_EQ(std::get<double>(digits), 4.0 / 3);
}

TEST(ParseQuantity, NeverGivesWhatIsNotFiniteForRandomText) {
  constexpr std::string_view pieces[] = {
      "1",    "2.5",  "e",   "-",    "+", " ",   "m",        "rad",   "deg",
      "/",    "^",    "*",   "(",    ")", ".",   "s",        "K",     "degC",
      "nan",  "inf",  "999", "\0"sv, "@", "lg",  "(re 1 m)", "since", "\xc2\xb5",
      "\xff", "\xc3", "'",   "\"",   "%", "0x1", "kg"};
  for (std::uint64_t seed = 0; seed < 10'000; ++seed) {
    SCOPED_TRACE(seed);
    RandomBits bits(seed);
    std::string text = seed % 2 == 0 ? "" : "1 ";
    for (std::uint64_t length = bits() % 12; length > 0; --length)
      text += bits() % 8 == 0 ? std::string(1, static_cast<char>(bits() % 256))
                              : std::string(pieces[bits() % std::size(pieces)]);
    for (const std::string_view unit : {"m", "rad", "1", "K"}) {
      const auto result = parse_quantity(text, unit);
      const double* value = std::get_if<double>(&result);
      ASSERT_TRUE(value == nullptr || std::isfinite(*value)) << text;
    }
  }
}

TEST(SplitQuantity, SeparatesNumberAndUnit) {
  const QuantityText q = std::get<QuantityText>(split_quantity(" -3.5e-2 m/s "));
  EXPECT_EQ(q.number, -3.5e-2);
  EXPECT_EQ(q.unit, "m/s");
  EXPECT_EQ(std::get<QuantityText>(split_quantity("0.5")).unit, "");
}

TEST(UnitConversion, HasAnOffsetForTemperatureScales) {
  const auto celsius = std::get<UnitConversion>(unit_conversion("degC", "K"));
  EXPECT_NEAR(celsius.scale, 1, 1e-12);
  EXPECT_NEAR(celsius.offset, 273.15, 1e-12);
  EXPECT_EQ(std::get<UnitConversion>(unit_conversion("km", "m")).offset, 0);
}

TEST(SiUnit, IsThatOfTheSameDimension) {
  EXPECT_EQ(si_unit("nm"), "m");
  EXPECT_EQ(si_unit("deg"), "rad");
  EXPECT_EQ(si_unit("degC"), "K");
  EXPECT_EQ(si_unit(""), "1");
  EXPECT_EQ(si_unit("1"), "1");
  EXPECT_EQ(si_unit("%"), "1");
  for (const char* unit : {"km/h", "N", "nm/K", "1/m", "deg/s"}) {
    const auto si = si_unit(unit);
    ASSERT_TRUE(si) << unit;
    EXPECT_TRUE(std::holds_alternative<UnitConversion>(unit_conversion(unit, *si))) << unit;
  }
}

TEST(SiUnit, IsNoneOfWhatIsNoUnit) {
  for (const char* unit : {"xyz", "11", "m m2 (", "@"}) EXPECT_FALSE(si_unit(unit)) << unit;
}

}  // namespace
}  // namespace ilss
