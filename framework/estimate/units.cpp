#include "framework/estimate/units.h"

#include <fmt/format.h>
#include <udunits2.h>

#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "framework/estimate/unit_table/unit_table.h"

namespace ilss {
namespace {

struct UnitDeleter {
  void operator()(ut_unit* unit) const { ut_free(unit); }
};
using UnitPointer = std::unique_ptr<ut_unit, UnitDeleter>;

/// UDUNITS-2's database, read once, where it is first needed (15 ms), and never freed: it lives as
/// long as the program.
class UnitSystem {
 public:
  UnitSystem() {
    ut_set_error_message_handler(ut_ignore);
    system_ = ut_read_xml(nullptr);
    // UDUNITS-2 knows the degree of arc by other names only.
    if (UnitPointer degree = parse("arc_degree"); degree && !parse("deg"))
      ut_map_symbol_to_unit("deg", UT_ASCII, degree.get());
  }
  bool available() const { return system_ != nullptr; }

  UnitPointer parse(std::string_view text) const {
    return UnitPointer(ut_parse(system_, std::string(text).c_str(), UT_UTF8));
  }
  /// The power of angle in a unit. UDUNITS-2 takes the radian for a number, but its definition of a
  /// unit keeps it as a base unit ("0.0174532925199433 rad", "s-1.rad", "cd.rad2"; none of the
  /// other base units contains these letters). Nothing where the definition cannot be told.
  static std::optional<int> angle_power(const ut_unit* unit) {
    char buffer[512];
    const int length = ut_format(unit, buffer, sizeof buffer, UT_ASCII | UT_DEFINITION);
    if (length <= 0 || length >= static_cast<int>(sizeof buffer)) return std::nullopt;
    const std::string_view text(buffer, static_cast<std::size_t>(length));
    const std::size_t at = text.find("rad");
    if (at == std::string_view::npos) return 0;
    int power = 1;
    std::from_chars(text.data() + at + 3, text.data() + text.size(), power);
    return power;
  }

 private:
  ut_system* system_ = nullptr;
};

const UnitSystem& unit_system() {
  static const auto* system = new UnitSystem;
  return *system;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }
/// Of a unit's name; bytes beyond ASCII are parts of letters such as µ.
bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
         static_cast<unsigned char>(c) >= 0x80;
}

/// The text in quotes for a message, cut where it is very long.
std::string quoted(std::string_view text) {
  constexpr std::size_t longest = 60;
  return text.size() <= longest ? fmt::format("'{}'", text)
                                : fmt::format("'{}...'", text.substr(0, longest));
}

/// Whether a text can be a unit as people write them: "m/s", "kg.m-2", "1/m". UDUNITS-2 takes more
/// than that: numbers as factors, so that "11 12 deg" would be 132 deg, and origins ("K @ 273").
bool is_unit_text(std::string_view text) {
  constexpr std::size_t longest = 100;
  if (text.size() > longest) return false;
  if (text.starts_with("1/")) text.remove_prefix(2);
  int open = 0;
  char previous = ' ';
  for (const char c : text) {
    const bool after_unit = is_letter(previous) || previous == ')' || previous == '^';
    if (is_digit(c) && !(after_unit || is_digit(previous) || previous == '-')) return false;
    if (c == '-' && !after_unit) return false;
    if (!is_letter(c) && !is_digit(c) &&
        std::string_view(" -^*./()%'\"").find(c) == std::string_view::npos)
      return false;
    if (c == '(') ++open;
    if (c == ')' && --open < 0) return false;
    previous = c;
  }
  return open == 0;
}

/// The affine map that a converter is, if it is one: UDUNITS-2 also converts a time to a frequency
/// (by its reciprocal) and decibels to watts.
std::optional<UnitConversion> affine_map(const cv_converter* converter) {
  const double at_0 = cv_convert_double(converter, 0.0);
  const double at_1 = cv_convert_double(converter, 1.0);
  const double at_2 = cv_convert_double(converter, 2.0);
  const double bend = std::abs(at_2 - 2 * at_1 + at_0);
  const double size = std::abs(at_0) + std::abs(at_1) + std::abs(at_2);
  constexpr double rounding = 1e-12;
  if (!std::isfinite(size) || bend > rounding * size) return std::nullopt;
  return UnitConversion{at_1 - at_0, at_0};
}

std::optional<UnitConversion> ordinary_conversion(std::string_view unit, std::string_view si_unit) {
  for (const OrdinaryConversion& ordinary : ordinary_conversions)
    if (ordinary.unit == unit && ordinary.si_unit == si_unit) return ordinary.conversion;
  return std::nullopt;
}

std::variant<UnitConversion, std::string> find_conversion(std::string_view unit,
                                                          std::string_view si_unit) {
  const UnitSystem& system = unit_system();
  if (!system.available()) return std::string("the UDUNITS-2 unit database cannot be read");
  const UnitPointer from = is_unit_text(unit) ? system.parse(unit) : nullptr;
  if (!from)
    return fmt::format("unknown unit {}; expected {}", quoted(unit), dimension_name(si_unit));
  const UnitPointer to = system.parse(si_unit);
  if (!to) return fmt::format("unknown unit {}", quoted(si_unit));
  const auto angle = UnitSystem::angle_power(from.get());
  const bool same_dimension = ut_are_convertible(from.get(), to.get()) != 0 && angle.has_value() &&
                              angle == UnitSystem::angle_power(to.get());
  cv_converter* converter = same_dimension ? ut_get_converter(from.get(), to.get()) : nullptr;
  std::optional<UnitConversion> result;
  if (converter != nullptr) result = affine_map(converter);
  if (converter != nullptr) cv_free(converter);
  if (!result) return fmt::format("{} is not {}", quoted(unit), dimension_name(si_unit));
  return *result;
}

/// UDUNITS-2 is not thread-safe.
std::mutex& udunits_mutex() {
  static std::mutex mutex;
  return mutex;
}

/// A unit's definition in base units, without the factor before and the origin behind: "rad" of
/// "0.017 rad", "K" of "K @ 273.15".
std::optional<std::string> base_units_of(std::string_view unit) {
  const UnitSystem& system = unit_system();
  const UnitPointer parsed =
      system.available() && is_unit_text(unit) ? system.parse(unit) : nullptr;
  if (!parsed) return std::nullopt;
  char buffer[512];
  const int length = ut_format(parsed.get(), buffer, sizeof buffer, UT_ASCII | UT_DEFINITION);
  if (length <= 0 || length >= static_cast<int>(sizeof buffer)) return std::nullopt;
  std::string_view text(buffer, static_cast<std::size_t>(length));
  text = text.substr(0, text.find(" @ "));
  if (const std::size_t space = text.rfind(' '); space != std::string_view::npos)
    text.remove_prefix(space + 1);
  if (!text.empty() && (is_digit(text.front()) || text.front() == '-')) return "1";
  return std::string(text);
}

std::string_view trim(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

}  // namespace

std::string dimension_name(std::string_view si_unit) {
  static constexpr std::pair<std::string_view, std::string_view> names[] = {
      {"m", "a length"},
      {"rad", "an angle"},
      {"s", "a time"},
      {"Hz", "a frequency"},
      {"1", "a pure number"},
      {"m/s", "a speed"},
      {"rad/s", "an angular rate"},
      {"m2", "an area"},
      {"A", "a current"},
      {"K", "a temperature"},
      {"kg", "a mass"},
      {"m/rad", "a length per angle"}};
  for (const auto& [unit, name] : names)
    if (unit == si_unit)
      return si_unit == "1" ? std::string(name) : fmt::format("{} ({})", name, unit);
  return fmt::format("a quantity in {}", si_unit);
}

std::variant<UnitConversion, std::string> unit_conversion(std::string_view unit,
                                                          std::string_view si_unit) {
  if (unit == si_unit) return UnitConversion{};
  if (const auto ordinary = ordinary_conversion(unit, si_unit)) return *ordinary;
  static std::map<std::pair<std::string, std::string>, std::variant<UnitConversion, std::string>,
                  std::less<>>
      known;
  const std::lock_guard lock(udunits_mutex());
  const std::pair<std::string, std::string> key{unit, si_unit};
  const auto found = known.find(key);
  if (found != known.end()) return found->second;
  return known.emplace(key, find_conversion(unit, si_unit)).first->second;
}

std::optional<std::string> si_unit(std::string_view unit) {
  if (unit.empty() || unit == "1") return "1";
  for (const OrdinaryUnit& ordinary : ordinary_units)
    if (ordinary.unit == unit) return std::string(ordinary.base);
  std::optional<std::string> base;
  {
    const std::lock_guard lock(udunits_mutex());
    base = base_units_of(unit);
  }
  if (!base || !std::holds_alternative<UnitConversion>(unit_conversion(unit, *base)))
    return std::nullopt;
  return base;
}

std::variant<QuantityText, std::string> split_quantity(std::string_view text) {
  text = trim(text);
  QuantityText result{};
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (text.starts_with('+') && !text.starts_with("+-")) ++begin;
  const auto [stop, error] = std::from_chars(begin, end, result.number);
  if (error == std::errc::result_out_of_range)
    return fmt::format("{} is too large or too small for a number", quoted(text));
  if (error != std::errc{} || !std::isfinite(result.number))
    return fmt::format(
        "{} is not a quantity; expected a finite number and a unit, such as '11 deg'",
        quoted(text));
  result.unit = trim({stop, static_cast<std::size_t>(end - stop)});
  return result;
}

std::variant<double, std::string> parse_quantity(std::string_view text, std::string_view si_unit) {
  const auto split = split_quantity(text);
  if (const auto* error = std::get_if<std::string>(&split)) return *error;
  const QuantityText quantity = std::get<QuantityText>(split);
  if (quantity.unit.empty()) {
    if (si_unit == "1" || quantity.number == 0.0) return quantity.number;
    return fmt::format("{} has no unit; expected {}", quoted(trim(text)), dimension_name(si_unit));
  }
  const auto conversion = unit_conversion(quantity.unit, si_unit);
  if (const auto* error = std::get_if<std::string>(&conversion)) return *error;
  const auto [scale, offset] = std::get<UnitConversion>(conversion);
  const double value = scale * quantity.number + offset;
  if (!std::isfinite(value))
    return fmt::format("{} is too large in {}", quoted(trim(text)), si_unit);
  return value;
}

}  // namespace ilss
