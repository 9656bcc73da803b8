// The components of a numeric payload, declared once as a struct template over its scalar.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <span>
#include <stdexcept>
#include <string_view>
#include <type_traits>

namespace ilss {

/// The default of a component that has none: it must be given.
inline constexpr double required = std::numeric_limits<double>::quiet_NaN();

/// How the values of a component lie.
enum class Geometry {
  plain,     ///< on a line
  circular,  ///< an angle on the circle, in [-pi, pi)
  rotation,  ///< one of three consecutive ones in radians, the rotation vector of a rotation in
             ///< space: axis times angle, at most pi long
};

/// One component: its name (dots nest it in YAML: `mount.x`), SI unit, meaning and default.
struct Field {
  std::string_view name;
  std::string_view unit;
  std::string_view documentation = {};
  double default_value = required;
  Geometry geometry = Geometry::plain;
};

/// The components of a payload in their order, at most `capacity` of them; those of rotations come
/// in threes.
class Fields {
 public:
  static constexpr std::size_t capacity = 16;

  constexpr Fields(std::initializer_list<Field> fields) {
    if (fields.size() > capacity) throw std::length_error("a payload has at most 16 components");
    std::size_t of_rotation = 0;
    for (const Field& field : fields) {
      if (field.geometry == Geometry::rotation)
        ++of_rotation;
      else if (of_rotation % 3 != 0)
        throw std::length_error("a rotation has three consecutive components");
      fields_[size_++] = field;
    }
    if (of_rotation % 3 != 0)
      throw std::length_error("a rotation has three consecutive components");
  }
  constexpr std::size_t size() const { return size_; }
  constexpr const Field& operator[](std::size_t i) const { return fields_[i]; }
  constexpr const Field* begin() const { return fields_.data(); }
  constexpr const Field* end() const { return fields_.data() + size_; }

 private:
  std::array<Field, capacity> fields_{};
  std::size_t size_ = 0;
};

/// A discrete value that rides along with a payload, such as the case a solution belongs to.
struct LabelField {
  std::string_view name;
  std::span<const std::string_view> values;
};

/// A struct template over its scalar whose first members are its components, all of type T:
/// `template <typename T> struct Range { T range; static constexpr auto name = "range";
///  static constexpr auto fields = Fields{{"range", "m"}}; };`
/// It may declare `labels` (an array of LabelField) and then ends with `std::array<int, n> label`.
template <template <typename> class Payload>
concept NumericPayload = requires {
  { Payload<double>::fields.size() } -> std::convertible_to<std::size_t>;
};

template <template <typename> class Payload>
inline constexpr std::size_t dimension_of = Payload<double>::fields.size();

/// The index of a component by its name: `index_of<LineSegment>("phi")`. A name that the payload
/// does not have is an error where it stands.
template <template <typename> class Payload>
consteval std::size_t index_of(std::string_view component) {
  const auto& fields = Payload<double>::fields;
  for (std::size_t i = 0; i < fields.size(); ++i)
    if (fields[i].name == component) return i;
  throw std::invalid_argument("the payload has no such component");
}

/// The components of a payload as contiguous scalars.
template <template <typename> class Payload, typename T>
std::span<T, dimension_of<Payload>> components(Payload<T>& payload) {
  static_assert(std::is_standard_layout_v<Payload<double>>);
  static_assert(sizeof(Payload<double>) >= dimension_of<Payload> * sizeof(double));
  return std::span<T, dimension_of<Payload>>(reinterpret_cast<T*>(&payload), dimension_of<Payload>);
}
template <template <typename> class Payload, typename T>
std::span<const T, dimension_of<Payload>> components(const Payload<T>& payload) {
  return components(const_cast<Payload<T>&>(payload));
}

}  // namespace ilss
