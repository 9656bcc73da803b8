// What takes a module's place in a system: outputs that are given from outside, or a wrapper of the
// module, such as one that injects faults.
#pragma once

#include <functional>
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

}  // namespace ilss
