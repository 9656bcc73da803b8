#include "framework/estimate/payload.h"

#include <algorithm>
#include <deque>
#include <mutex>
#include <stdexcept>

namespace ilss {
namespace {

void check_rotations(const PayloadDescriptor& payload) {
  std::size_t in_a_row = 0;
  const auto whole = [&] {
    if (in_a_row % 3 != 0)
      throw std::invalid_argument("a rotation of " + payload.name +
                                  " does not have three consecutive components");
  };
  for (const Component& component : payload.components) {
    if (component.geometry != Geometry::rotation) {
      whole();
      continue;
    }
    ++in_a_row;
    if (component.unit != "rad")
      throw std::invalid_argument("'" + component.name + "' of " + payload.name +
                                  " is part of a rotation, and so is in rad, not " +
                                  component.unit);
  }
  whole();
}

}  // namespace

const PayloadDescriptor& any_payload() {
  static const PayloadDescriptor any{
      "any numeric payload", "Whatever the module is connected to.", {}};
  return any;
}

std::string_view sample_type_name(SampleType type) {
  switch (type) {
    case SampleType::uint8:
      return "uint8";
    case SampleType::uint16:
      return "uint16";
    case SampleType::float32:
      return "float32";
    case SampleType::float64:
      return "float64";
  }
  return "float64";
}

namespace {

template <typename T, typename Same>
bool all_same(const std::vector<T>& a, const std::vector<T>& b, Same same) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

bool same_samples(const SamplesDescriptor& a, const SamplesDescriptor& b) {
  return a.axes == b.axes &&
         all_same(a.columns, b.columns, [](const SampleColumn& x, const SampleColumn& y) {
           return x.name == y.name && x.unit == y.unit && x.type == y.type && x.count == y.count &&
                  x.may_be_missing == y.may_be_missing;
         });
}

}  // namespace

bool same_payload(const PayloadDescriptor& a, const PayloadDescriptor& b) {
  if (&a == &b) return true;
  if (a.name != b.name || a.element != b.element || a.samples.has_value() != b.samples.has_value())
    return false;
  if (a.samples && !same_samples(*a.samples, *b.samples)) return false;
  return all_same(a.components, b.components,
                  [](const Component& x, const Component& y) {
                    return x.name == y.name && x.unit == y.unit && x.geometry == y.geometry;
                  }) &&
         all_same(a.labels, b.labels,
                  [](const Label& x, const Label& y) {
                    return x.name == y.name && x.values == y.values;
                  }) &&
         all_same(a.elements, b.elements,
                  [](const PayloadDescriptor* x, const PayloadDescriptor* y) {
                    return same_payload(*x, *y);
                  });
}

const PayloadDescriptor& intern_payload(PayloadDescriptor payload) {
  check_rotations(payload);
  static std::mutex mutex;
  static auto* payloads = new std::deque<PayloadDescriptor>;
  const std::lock_guard lock(mutex);
  for (const PayloadDescriptor& known : *payloads)
    if (same_payload(known, payload)) return known;
  return payloads->emplace_back(std::move(payload));
}

}  // namespace ilss
