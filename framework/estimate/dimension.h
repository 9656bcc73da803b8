// Dimensions of quantities: what a sum needs alike and a product adds up.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace ilss {

/// Powers of the SI base units and the radian: angle counts as a dimension of its own. Powers may
/// be any real number, so that a square root always has a dimension.
class Dimension {
 public:
  /// Of a pure number.
  Dimension() = default;
  /// The dimension of a unit, whatever its scale; nothing where the unit is unknown.
  static std::optional<Dimension> of(std::string_view unit);
  static Dimension angle();

  bool is_pure_number() const { return *this == Dimension(); }
  Dimension power(double exponent) const;
  /// Its SI unit: "m", "m/s", "kg.m2/s2", "1"; "m^0.5" where a power is not whole.
  std::string unit() const;
  /// For messages: "a length (m)".
  std::string name() const;

  friend Dimension operator*(const Dimension& a, const Dimension& b);
  friend Dimension operator/(const Dimension& a, const Dimension& b);
  /// Powers that differ by rounding are the same.
  friend bool operator==(const Dimension& a, const Dimension& b);

 private:
  static constexpr std::array<std::string_view, 8> base_units = {"kg", "m",   "s",  "A",
                                                                 "K",  "mol", "cd", "rad"};
  std::array<double, base_units.size()> powers_{};
};

}  // namespace ilss
