// The cases of a study of graphs: which constants are set to what, from a list or a sweep.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "framework/graph/plan.h"

namespace ilss {

/// A case of systems: constants of their graphs to set.
struct Setting {
  std::string name;
  std::vector<Override> constants;
};

/// Reports keys of `map` that are not `known`. `owner` is for the message: "a study".
void check_map_keys(const Node& map, std::string_view owner, const std::vector<std::string>& known,
                    Diagnostics& diagnostics);

/// Reads `cases` or `sweep` of a study's file, of which it must have one.
std::vector<Setting> read_settings(const Node& study, Diagnostics& diagnostics);

}  // namespace ilss
