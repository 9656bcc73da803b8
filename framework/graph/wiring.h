// Wiring: which node feeds which, in what order they are evaluated, and whether they fit.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "framework/graph/expression.h"
#include "framework/graph/plan.h"

namespace ilss {

/// Stands for a node that could not be read; what is connected to it cannot be checked.
constexpr std::size_t unknown_node = std::numeric_limits<std::size_t>::max();

/// What a name in a network stands for: one node, or the outputs of a nested system.
struct Instance {
  std::vector<std::size_t> outputs = {unknown_node};
  bool counted = true;  ///< whether it has as many outputs as `outputs`
  bool nested = false;
  bool used = false;
  Position position = {};
};

/// The instances that a network's expression may name.
using Scope = std::map<std::string, Instance, std::less<>>;

/// Connects the nodes of a plan that is being built; what is wrong goes to the diagnostics. Parts
/// that could not be read are unknown, and nothing more is said of what hangs on them.
class Wiring {
 public:
  /// All must outlive it. Nodes may be added between calls.
  Wiring(std::vector<PlanNode>& nodes, const Registry& registry, Diagnostics& diagnostics)
      : nodes_(nodes), registry_(registry), diagnostics_(diagnostics) {}

  /// Connects the nodes that a system's network names; every module of the scope must be used and
  /// fed. Returns the system's outputs, as the instance that the system is from outside.
  Instance wire(const Expression& network, Scope& scope);

  /// All nodes, each after those that feed it; reports every cycle.
  std::vector<std::size_t> evaluation_order();

  /// Checks number, payload and frame of each node's inputs, completes what takes any payload, and
  /// sets the nodes' frames.
  void check_connections(const std::vector<std::size_t>& order);

 private:
  /// What an expression gives to the next: outputs in order. Where a part of it could not be read,
  /// their number is not known, and no more is said of it.
  struct Flow {
    std::vector<PlanInput> outputs = {};
    bool counted = true;
  };
  /// Where a node's inputs come from.
  struct Connection {
    bool made = false;
    bool counted = true;  ///< whether all of the node's inputs are known, if only as unknown_node
    Position position = {};
  };

  static bool is_known(const Flow& flow);
  Flow follow(const Expression& expression, const Flow& feed, Scope& scope);
  Flow follow_name(const Expression& expression, const Flow& feed, Scope& scope);
  void connect(std::size_t node, const Expression& expression, const Flow& feed);
  void check_used(const Expression& network, const Scope& scope);
  void report_cycles(const std::vector<std::size_t>& waiting_for);
  void resolve(std::size_t index);
  void adopt_registered_payload(PlanNode& node);
  void check_payload_names(const std::vector<std::size_t>& order);
  void check_input(std::size_t index, std::size_t i);

  std::vector<PlanNode>& nodes_;
  const Registry& registry_;
  Diagnostics& diagnostics_;
  std::vector<Connection> connections_;  ///< of each node
};

}  // namespace ilss
