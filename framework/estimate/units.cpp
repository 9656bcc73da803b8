#include "framework/estimate/units.h"

#include <fmt/format.h>
#include <udunits2.h>

#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

namespace ilss {
namespace {

struct UnitDeleter {
  void operator()(ut_unit* unit) const { ut_free(unit); }
};
using UnitPointer = std::unique_ptr<ut_unit, UnitDeleter>;

/// UDUNITS-2's database, read once and never freed: it lives as long as the program.
class UnitSystem {
 public:
  UnitSystem() {
    ut_set_error_message_handler(ut_ignore);
    system_ = ut_read_xml(nullptr);
    one_.reset(ut_get_dimensionless_unit_one(system_));
    // UDUNITS-2 knows the degree of arc by other names only.
    if (UnitPointer degree = parse("arc_degree"); degree && !parse("deg"))
      ut_map_symbol_to_unit("deg", UT_ASCII, degree.get());
  }
  bool available() const { return system_ != nullptr; }

  UnitPointer parse(std::string_view text) const {
    return UnitPointer(ut_parse(system_, std::string(text).c_str(), UT_UTF8));
  }
  /// The power of angle in a unit: UDUNITS-2 takes the radian for a number, so we ask its
  /// definition in base units, which keeps it ("0.0174532925199433 rad").
  static std::string angle_part(const ut_unit* unit) {
    char buffer[256];
    const int length = ut_format(unit, buffer, sizeof buffer, UT_ASCII | UT_DEFINITION);
    if (length <= 0 || length >= static_cast<int>(sizeof buffer)) return {};
    const std::string_view text(buffer, static_cast<std::size_t>(length));
    const std::size_t at = text.find("rad");
    if (at == std::string_view::npos) return {};
    std::string part = "rad";
    for (std::size_t i = at + 3; i < text.size(); ++i) {
      const char c = text[i];
      if (c != '-' && c != '^' && (c < '0' || c > '9')) break;
      part += c;
    }
    return part;
  }

 private:
  ut_system* system_ = nullptr;
  UnitPointer one_;
};

const UnitSystem& unit_system() {
  static const auto* system = new UnitSystem;
  return *system;
}

std::variant<UnitConversion, std::string> find_conversion(std::string_view unit,
                                                          std::string_view si_unit) {
  const UnitSystem& system = unit_system();
  if (!system.available()) return std::string("the UDUNITS-2 unit database cannot be read");
  const UnitPointer from = system.parse(unit);
  if (!from) return fmt::format("unknown unit '{}'; expected {}", unit, dimension_name(si_unit));
  const UnitPointer to = system.parse(si_unit);
  if (!to) return fmt::format("unknown unit '{}'", si_unit);
  const bool same_dimension =
      ut_are_convertible(from.get(), to.get()) != 0 &&
      UnitSystem::angle_part(from.get()) == UnitSystem::angle_part(to.get());
  cv_converter* converter = same_dimension ? ut_get_converter(from.get(), to.get()) : nullptr;
  if (converter == nullptr) return fmt::format("'{}' is not {}", unit, dimension_name(si_unit));
  UnitConversion result;
  result.offset = cv_convert_double(converter, 0.0);
  result.scale = cv_convert_double(converter, 1.0) - result.offset;
  cv_free(converter);
  return result;
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
  static std::mutex mutex;
  static std::map<std::pair<std::string, std::string>, std::variant<UnitConversion, std::string>,
                  std::less<>>
      known;
  const std::lock_guard lock(mutex);
  const std::pair<std::string, std::string> key{unit, si_unit};
  const auto found = known.find(key);
  if (found != known.end()) return found->second;
  return known.emplace(key, find_conversion(unit, si_unit)).first->second;
}

std::variant<QuantityText, std::string> split_quantity(std::string_view text) {
  text = trim(text);
  QuantityText result{};
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (begin != end && *begin == '+') ++begin;
  const auto [stop, error] = std::from_chars(begin, end, result.number);
  if (error == std::errc::result_out_of_range)
    return fmt::format("'{}' is too large or too small for a number", text);
  if (error != std::errc{} || !std::isfinite(result.number))
    return fmt::format(
        "'{}' is not a quantity; expected a finite number and a unit, such as "
        "'11 deg'",
        text);
  result.unit = trim({stop, static_cast<std::size_t>(end - stop)});
  return result;
}

std::variant<double, std::string> parse_quantity(std::string_view text, std::string_view si_unit) {
  const auto split = split_quantity(text);
  if (const auto* error = std::get_if<std::string>(&split)) return *error;
  const QuantityText quantity = std::get<QuantityText>(split);
  if (quantity.unit.empty()) {
    if (si_unit == "1" || quantity.number == 0.0) return quantity.number;
    return fmt::format("'{}' has no unit; expected {}", trim(text), dimension_name(si_unit));
  }
  const auto conversion = unit_conversion(quantity.unit, si_unit);
  if (const auto* error = std::get_if<std::string>(&conversion)) return *error;
  const auto [scale, offset] = std::get<UnitConversion>(conversion);
  const double value = scale * quantity.number + offset;
  if (!std::isfinite(value)) return fmt::format("'{}' is too large in {}", trim(text), si_unit);
  return value;
}

}  // namespace ilss
