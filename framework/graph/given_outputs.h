// Outputs that are given from outside, in the place of modules.
#pragma once

#include <map>
#include <string>

#include "framework/graph/stand_in.h"

namespace ilss {

/// A module's output as given: with its own error where `has_error`, else with the error that the
/// module expects there. Components that are NaN are the module's to say.
struct OperatingPoint {
  Output value;
  bool has_error = false;
};

/// Lets operating points (by node) stand for their modules: at every tick, and in a prediction.
StandIns given_outputs(std::map<std::size_t, OperatingPoint> points);

/// A type whose modules exist only as what is given: a graph's input from outside.
ModuleType given_type(std::string name, const PayloadDescriptor& payload);

}  // namespace ilss
