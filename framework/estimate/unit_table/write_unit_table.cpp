// Writes the source of the tables of ordinary units, by what UDUNITS-2 says of each: run while ilss
// is built, its standard output being the source. Its own tables are empty, so that it asks
// UDUNITS-2.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "framework/estimate/unit_table/unit_table.h"

constinit const std::span<const ilss::OrdinaryUnit> ilss::ordinary_units = {};
constinit const std::span<const ilss::OrdinaryConversion> ilss::ordinary_conversions = {};

namespace {

constexpr std::string_view units[] = {
    "1",       "%",       "m",      "km",      "cm",    "mm",    "um",      "µm",    "nm",
    "m2",      "m^2",     "mm2",    "mm^2",    "cm2",   "cm^2",  "rad",     "deg",   "degree",
    "degrees", "mrad",    "rad2",   "rad^2",   "deg2",  "s",     "ms",      "us",    "µs",
    "ns",      "min",     "h",      "Hz",      "kHz",   "MHz",   "1/s",     "s-1",   "m/s",
    "m.s-1",   "mm/s",    "cm/s",   "km/h",    "rad/s", "deg/s", "s-1.rad", "m/s2",  "m/s^2",
    "rad/s2",  "rad/s^2", "deg/s2", "deg/s^2", "A",     "mA",    "uA",      "µA",    "nA",
    "pA",      "V",       "mV",     "K",       "degC",  "kg",    "g",       "m/rad", "mm/rad",
    "m/deg",   "mm/deg",  "1/m",    "m-1",     "1/mm",  "W",     "mW"};
// As the components and options of modules say what unit they are in.
constexpr std::string_view si_units[] = {"1",     "m",     "m2",     "m^2",     "rad", "rad2",
                                         "rad^2", "s",     "Hz",     "1/s",     "m/s", "m/s2",
                                         "m/s^2", "rad/s", "rad/s2", "rad/s^2", "A",   "V",
                                         "K",     "kg",    "m/rad",  "1/m",     "W"};

}  // namespace

int main() {
  std::string bases;
  std::string conversions;
  for (const std::string_view unit : units) {
    const auto base = ilss::si_unit(unit);
    if (!base) {
      fmt::print(stderr, "UDUNITS-2 does not know the unit '{}'\n", unit);
      return 1;
    }
    bases += fmt::format("    {{\"{}\", \"{}\"}},\n", unit, *base);
    std::vector<std::string_view> targets(std::begin(si_units), std::end(si_units));
    if (std::find(targets.begin(), targets.end(), *base) == targets.end()) targets.push_back(*base);
    for (const std::string_view si_unit : targets) {
      const auto conversion = ilss::unit_conversion(unit, si_unit);
      if (const auto* known = std::get_if<ilss::UnitConversion>(&conversion))
        conversions += fmt::format("    {{\"{}\", \"{}\", {{{:a}, {:a}}}}},\n", unit, si_unit,
                                   known->scale, known->offset);
    }
  }
  fmt::print(R"(#include "framework/estimate/unit_table/unit_table.h"

namespace ilss {{

static constexpr OrdinaryUnit units[] = {{
{}}};
constinit const std::span<const OrdinaryUnit> ordinary_units = units;

static constexpr OrdinaryConversion conversions[] = {{
{}}};
constinit const std::span<const OrdinaryConversion> ordinary_conversions = conversions;

}}  // namespace ilss
)",
             bases, conversions);
  return 0;
}
