// What the fusion modules ask of their inputs, which may be any payload with components.
#pragma once

#include <string_view>

#include "framework/module/module_type.h"

namespace ilss {

/// One or more estimates of a payload that is known once they are connected; the output is the same
/// in the first one's frame.
Interface fusion_interface();

/// Sets the payload of the inputs, and of an output that has the inputs' payload, to the first
/// input's. Reports fewer than `least` inputs, and payloads that are not plain components: `module`
/// is for the message.
void resolve_fusion(const Connections& connections, std::size_t least, std::string_view module,
                    Interface& interface);

}  // namespace ilss
