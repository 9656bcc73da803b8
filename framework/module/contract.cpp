#include "framework/module/contract.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>

namespace ilss {
namespace {

/// Whether all numbers are finite: a sum of zeros, in lanes that do not wait for each other, is NaN
/// once one is not. `first` need not be aligned.
template <typename Number>
bool all_finite(const std::byte* first, std::size_t count) {
  constexpr std::size_t lanes = 8;
  std::array<Number, lanes> zeros{};
  std::array<Number, lanes> block;
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    std::memcpy(block.data(), first + i * sizeof(Number), sizeof block);
    for (std::size_t lane = 0; lane < lanes; ++lane) zeros[lane] += 0 * block[lane];
  }
  for (; i < count; ++i) {
    std::memcpy(block.data(), first + i * sizeof(Number), sizeof(Number));
    zeros[0] += 0 * block[0];
  }
  Number sum = 0;
  for (const Number zero : zeros) sum += zero;
  return sum == 0;
}

bool all_finite(std::span<const double> numbers) {
  double zero = 0;
  for (const double number : numbers) zero += 0 * number;
  return zero == 0;
}

bool must_be_finite(const SampleColumn& column) {
  return !column.may_be_missing &&
         (column.type == SampleType::float32 || column.type == SampleType::float64);
}

bool is_finite(const SampleColumn& column, const std::byte* first) {
  return column.type == SampleType::float64 ? all_finite<double>(first, column.count)
                                            : all_finite<float>(first, column.count);
}

/// The first column that has a number which is not finite and must be; null where none has.
const SampleColumn* find_not_finite(const Samples& samples, const SamplesDescriptor& declared) {
  const auto is_plain = [](const SampleColumn& column) {
    return column.type == SampleType::float64 && !column.may_be_missing;
  };
  if (std::all_of(declared.columns.begin(), declared.columns.end(), is_plain) &&
      all_finite<double>(samples.bytes.data(), samples.bytes.size() / sizeof(double)))
    return nullptr;
  const std::size_t step = declared.bytes();
  std::size_t place = 0;
  for (const SampleColumn& column : declared.columns) {
    if (must_be_finite(column))
      for (std::size_t at = place; at < samples.bytes.size(); at += step)
        if (!is_finite(column, samples.bytes.data() + at)) return &column;
    place += column.bytes();
  }
  return nullptr;
}

bool has_shape(const Samples& samples, const SamplesDescriptor& declared) {
  if (samples.shape.empty()) return samples.bytes.empty();
  if (samples.shape.size() != declared.axes.size()) return false;
  std::size_t count = 1;
  for (const std::size_t size : samples.shape) count *= size;
  const std::size_t deviations = samples.standard_deviations.size();
  return samples.bytes.size() == count * declared.bytes() &&
         (deviations <= 1 || deviations == count);
}

Breach breach_of(const Samples& samples, const PayloadDescriptor& payload) {
  if (!payload.samples)
    return samples.shape.empty() && samples.bytes.empty() ? Breach::none : Breach::other_shape;
  if (!has_shape(samples, *payload.samples)) return Breach::other_shape;
  return find_not_finite(samples, *payload.samples) == nullptr &&
                 all_finite(samples.standard_deviations)
             ? Breach::none
             : Breach::not_finite;
}

bool has_labels(const Estimate& estimate, const PayloadDescriptor& payload) {
  if (estimate.labels.size() != payload.labels.size()) return false;
  for (std::size_t i = 0; i < estimate.labels.size(); ++i)
    if (static_cast<std::size_t>(estimate.labels[i]) >= payload.labels[i].values.size())
      return false;
  return true;
}

Breach breach_of(const Estimate& estimate, const PayloadDescriptor& payload) {
  if (estimate.value.size() != payload.dimension() ||
      estimate.lineage.dimension() != payload.dimension() || !has_labels(estimate, payload))
    return Breach::other_shape;
  const std::span<const double> factor(estimate.lineage.factor().data(),
                                       payload.dimension() * estimate.lineage.size());
  return all_finite(estimate.value) && all_finite(factor) ? Breach::none : Breach::not_finite;
}

/// Whether a set may hold elements of a type; any, where it does not declare them.
bool may_hold(const PayloadDescriptor& set, const PayloadDescriptor& type) {
  return set.elements.empty() ||
         std::any_of(set.elements.begin(), set.elements.end(), [&](const PayloadDescriptor* known) {
           return known == &type || same_payload(*known, type);
         });
}

Breach breach_of_element(const Estimate& element, const PayloadDescriptor& set) {
  if (element.type == nullptr || !may_hold(set, *element.type)) return Breach::other_shape;
  return breach_of(element, *element.type);
}

Breach breach_of(const Elements& elements, const PayloadDescriptor& set) {
  if (set.element.empty()) return elements.empty() ? Breach::none : Breach::other_shape;
  for (const Estimate& element : elements)
    if (const Breach breach = breach_of_element(element, set); breach != Breach::none)
      return breach;
  return Breach::none;
}

Fault fault_of(Breach breach, const std::string& where, const std::string& what) {
  return breach == Breach::not_finite
             ? Fault{FaultKind::not_finite, where + "a value or its error is not finite"}
             : Fault{FaultKind::internal, where + "the output has other " + what};
}

Fault describe_samples(const Samples& samples, const PayloadDescriptor& payload, Breach breach) {
  if (breach == Breach::other_shape)
    return fault_of(breach, "", "samples than " + payload.name + " declares");
  const SampleColumn* column = find_not_finite(samples, *payload.samples);
  return {FaultKind::not_finite, column != nullptr
                                     ? fmt::format("a sample's {} is not finite", column->name)
                                     : "a standard deviation of the samples is not finite"};
}

}  // namespace

Breach find_breach_in_parts(const Output& output, const PayloadDescriptor& payload) {
  const Breach breach = breach_of(output.samples, payload);
  return breach != Breach::none ? breach : breach_of(output.elements, payload);
}

Breach find_breach(const Output& output, const PayloadDescriptor& payload) {
  const Breach breach = breach_of(output.estimate, payload);
  return breach != Breach::none ? breach : find_breach_in_parts(output, payload);
}

Fault describe_breach(const Output& output, const PayloadDescriptor& payload) {
  if (const Breach breach = breach_of(output.estimate, payload); breach != Breach::none)
    return fault_of(breach, "", "components or labels than " + payload.name);
  if (const Breach breach = breach_of(output.samples, payload); breach != Breach::none)
    return describe_samples(output.samples, payload, breach);
  for (std::size_t i = 0; i < output.elements.size(); ++i) {
    const Estimate& element = output.elements[i];
    const Breach breach =
        payload.element.empty() ? Breach::other_shape : breach_of_element(element, payload);
    if (breach == Breach::none) continue;
    const std::string type = element.type != nullptr ? element.type->name : "no type";
    return fault_of(breach, fmt::format("element {} ({}): ", i + 1, type),
                    "elements than " + payload.name + " declares");
  }
  return {FaultKind::internal, "the output keeps to its payload"};
}

}  // namespace ilss
