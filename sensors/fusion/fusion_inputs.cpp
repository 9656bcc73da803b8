#include "sensors/fusion/fusion_inputs.h"

#include <fmt/format.h>

namespace ilss {

Interface fusion_interface() {
  return {{{"estimates", &any_payload(), {}, true}}, &any_payload(), {}, 0};
}

void resolve_fusion(const Connections& connections, std::size_t least, std::string_view module,
                    Interface& interface) {
  const PayloadDescriptor& payload = *connections.inputs.front();
  if (connections.inputs.size() < least)
    connections.diagnostics->add(connections.position,
                                 fmt::format("'{}' takes at least {} estimates, but is fed by {}",
                                             module, least, connections.inputs.size()));
  if (payload.components.empty())
    connections.diagnostics->add(
        connections.position,
        fmt::format("'{}' takes estimates, but {} has no components", module, payload.name));
  else if (payload.samples || !payload.element.empty())
    connections.diagnostics->add(
        connections.position,
        fmt::format("'{}' takes estimates of components alone, but {} has {}", module, payload.name,
                    payload.samples ? "samples" : "a set of elements"));
  interface.inputs[0].payload = &payload;
  if (interface.output == &any_payload()) interface.output = &payload;
}

}  // namespace ilss
