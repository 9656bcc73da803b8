// What a payload is at run time: its name, components, labels and samples. Types are told apart by
// name, never by C++ identity, so that plug-ins, YAML and other hosts can have payloads too.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "framework/estimate/fields.h"

namespace ilss {

/// One number of a payload.
struct Component {
  std::string name;
  std::string unit;  ///< SI: "m", "rad", "1", ...
  std::string documentation;
  std::optional<double> default_value;
  Geometry geometry = Geometry::plain;
};

/// A discrete value with its possible values.
struct Label {
  std::string name;
  std::vector<std::string> values;
};

/// What the numbers of samples are stored as.
enum class SampleType : std::uint8_t { uint8, uint16, float32, float64 };

/// "uint8", "uint16", "float32" or "float64".
std::string_view sample_type_name(SampleType type);

constexpr std::size_t bytes_of(SampleType type) {
  return type == SampleType::uint8     ? 1
         : type == SampleType::uint16  ? 2
         : type == SampleType::float32 ? 4
                                       : 8;
}

/// One quantity of every sample: a beam's range, an image's grey level.
struct SampleColumn {
  std::string name;
  std::string unit;  ///< SI: "m", "rad", "1", ...
  std::string documentation;
  SampleType type = SampleType::float64;
  std::size_t count = 1;        ///< numbers side by side: an image's channels, a gradient's parts
  bool may_be_missing = false;  ///< NaN where a sample has none; otherwise always finite

  std::size_t bytes() const { return count * bytes_of(type); }
};

/// A large array that comes with the components: an image's grey levels, a scan's readings. The
/// noise of its elements is independent. Samples stand one after another, row-major by the axes,
/// each with its columns in their order and without gaps.
struct SamplesDescriptor {
  std::vector<std::string> axes;  ///< what each index counts: {"row", "column"}, {"beam"}
  std::vector<SampleColumn> columns;

  /// Of one sample.
  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const SampleColumn& column : columns) sum += column.bytes();
    return sum;
  }
};

/// A payload's type. `element` names the payloads that a set's elements may have, empty where it is
/// not a set; `elements` are these, where they are declared.
struct PayloadDescriptor {
  std::string name;
  std::string documentation;
  std::vector<Component> components;
  std::vector<Label> labels = {};
  std::optional<SamplesDescriptor> samples = {};
  std::string element = {};
  std::vector<const PayloadDescriptor*> elements = {};

  std::size_t dimension() const { return components.size(); }
  /// The index of a component, if there is one of that name.
  std::optional<std::size_t> find(std::string_view component) const {
    for (std::size_t i = 0; i < components.size(); ++i)
      if (components[i].name == component) return i;
    return std::nullopt;
  }
};

/// Stands where a module takes, or passes on, any numeric payload: which one is known once the
/// module is connected.
const PayloadDescriptor& any_payload();

/// Whether two payloads are one: the same name, components, units, geometry, labels, samples and
/// elements.
bool same_payload(const PayloadDescriptor& a, const PayloadDescriptor& b);

/// The descriptor to use for a payload that is made at run time, such as one that a graph defines:
/// equal ones are one object, which lives as long as the program. Thread-safe.
/// @throws std::invalid_argument where components of a rotation are not three in a row, in radians.
const PayloadDescriptor& intern_payload(PayloadDescriptor payload);

/// The descriptor of a struct payload, made from its `name` and `fields` (and `labels`,
/// `samples`, `element`, `elements()`).
template <template <typename> class Payload>
requires NumericPayload<Payload>
const PayloadDescriptor& descriptor() {
  static const PayloadDescriptor result = [] {
    PayloadDescriptor d;
    using P = Payload<double>;
    d.name = P::name;
    if constexpr (requires { P::documentation; }) d.documentation = P::documentation;
    for (const Field& field : P::fields) {
      Component c{std::string(field.name), std::string(field.unit),
                  std::string(field.documentation), std::nullopt, field.geometry};
      if (field.default_value == field.default_value) c.default_value = field.default_value;
      d.components.push_back(std::move(c));
    }
    if constexpr (requires { P::labels; })
      for (const LabelField& label : P::labels)
        d.labels.push_back({std::string(label.name), {label.values.begin(), label.values.end()}});
    if constexpr (requires { P::samples; }) d.samples = P::samples();
    if constexpr (requires { P::element; }) d.element = P::element;
    if constexpr (requires { P::elements(); }) d.elements = P::elements();
    return d;
  }();
  return result;
}

}  // namespace ilss
