#include "framework/estimate/dimension.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "framework/estimate/units.h"

namespace ilss {
namespace {

constexpr double exponent_rounding = 1e-9;

/// "m2", "m^0.5", "m".
std::string power_text(std::string_view unit, double power) {
  if (std::abs(power - 1) < exponent_rounding) return std::string(unit);
  if (std::abs(power - std::round(power)) < exponent_rounding)
    return fmt::format("{}{}", unit, std::lround(power));
  return fmt::format("{}^{:.4g}", unit, power);
}

}  // namespace

std::optional<Dimension> Dimension::of(std::string_view unit) {
  const std::optional<std::string> si = si_unit(unit);
  if (!si) return std::nullopt;
  // In base units, as UDUNITS-2 writes them: "m.kg.s-2", "1".
  Dimension result;
  for (std::string_view rest = *si; !rest.empty() && rest != "1";) {
    const std::string_view factor = rest.substr(0, rest.find('.'));
    rest.remove_prefix(std::min(rest.size(), factor.size() + 1));
    const std::size_t letters = std::min(factor.find_first_of("-0123456789"), factor.size());
    const auto* base = std::find(base_units.begin(), base_units.end(), factor.substr(0, letters));
    int power = 1;
    if (letters < factor.size())
      std::from_chars(factor.data() + letters, factor.data() + factor.size(), power);
    if (base == base_units.end()) return std::nullopt;
    result.powers_[static_cast<std::size_t>(base - base_units.begin())] += power;
  }
  return result;
}

Dimension Dimension::angle() {
  Dimension result;
  result.powers_.back() = 1;
  return result;
}

Dimension Dimension::power(double exponent) const {
  Dimension result = *this;
  for (double& power : result.powers_) power *= exponent;
  return result;
}

std::string Dimension::unit() const {
  std::string above;
  std::string below;
  for (std::size_t i = 0; i < powers_.size(); ++i) {
    if (powers_[i] > exponent_rounding)
      above += (above.empty() ? "" : ".") + power_text(base_units[i], powers_[i]);
    if (powers_[i] < -exponent_rounding) below += "/" + power_text(base_units[i], -powers_[i]);
  }
  return (above.empty() ? "1" : above) + below;
}

std::string Dimension::name() const { return dimension_name(unit()); }

Dimension operator*(const Dimension& a, const Dimension& b) {
  Dimension result = a;
  for (std::size_t i = 0; i < b.powers_.size(); ++i) result.powers_[i] += b.powers_[i];
  return result;
}

Dimension operator/(const Dimension& a, const Dimension& b) { return a * b.power(-1); }

bool operator==(const Dimension& a, const Dimension& b) {
  return std::equal(a.powers_.begin(), a.powers_.end(), b.powers_.begin(),
                    [](double x, double y) { return std::abs(x - y) < exponent_rounding; });
}

}  // namespace ilss
