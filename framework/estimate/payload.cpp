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

bool same_payload(const PayloadDescriptor& a, const PayloadDescriptor& b) {
  const auto same_component = [](const Component& x, const Component& y) {
    return x.name == y.name && x.unit == y.unit && x.geometry == y.geometry;
  };
  const auto same_label = [](const Label& x, const Label& y) {
    return x.name == y.name && x.values == y.values;
  };
  return &a == &b || (a.name == b.name &&
                      std::equal(a.components.begin(), a.components.end(), b.components.begin(),
                                 b.components.end(), same_component) &&
                      std::equal(a.labels.begin(), a.labels.end(), b.labels.begin(), b.labels.end(),
                                 same_label));
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
