#include "framework/estimate/payload.h"

#include <algorithm>
#include <deque>
#include <mutex>

namespace ilss {

const PayloadDescriptor& any_payload() {
  static const PayloadDescriptor any{
      "any numeric payload", "Whatever the module is connected to.", {}};
  return any;
}

bool same_payload(const PayloadDescriptor& a, const PayloadDescriptor& b) {
  const auto same_component = [](const Component& x, const Component& y) {
    return x.name == y.name && x.unit == y.unit && x.circular == y.circular;
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
  static std::mutex mutex;
  static auto* payloads = new std::deque<PayloadDescriptor>;
  const std::lock_guard lock(mutex);
  for (const PayloadDescriptor& known : *payloads)
    if (same_payload(known, payload)) return known;
  return payloads->emplace_back(std::move(payload));
}

}  // namespace ilss
