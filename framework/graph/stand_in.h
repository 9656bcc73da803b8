// What takes a module's place in a system: outputs that are given from outside, or a wrapper.
#pragma once

#include <functional>
#include <map>
#include <memory>

#include "framework/graph/plan.h"

namespace ilss {

/// A module in another's place. One that is `given` has its outputs from outside (an operating
/// point, a recording, another program): nothing is evaluated to feed it.
struct StandIn {
  std::unique_ptr<Module> module;
  bool is_given = false;
};

/// Asked for each node when a system is made; without a module the node has its type's own. A
/// wrapper makes that one itself (`node.type->create(node.settings)`), and calls it.
using StandIns = std::function<StandIn(std::size_t index, const PlanNode& node)>;

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
