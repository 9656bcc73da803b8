// Registers the modules that come with ilss.
#pragma once

#include "framework/module/registry.h"

namespace ilss {

/// Adds every built-in sensor, function and estimator.
void register_sensors(Registry& registry);

}  // namespace ilss
