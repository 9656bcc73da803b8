// The JSON Schema of graph files, for editors that check and complete YAML.
#pragma once

#include <string>

#include "framework/module/registry.h"

namespace ilss {

/// A JSON Schema (draft 2020-12) of graph files whose modules are of the registry's types, made
/// from the same declarations that graphs are read by. It accepts every graph that `check` accepts;
/// what a schema cannot tell (dimensions, names, wiring) is left to `check`.
std::string graph_schema(const Registry& registry);

}  // namespace ilss
