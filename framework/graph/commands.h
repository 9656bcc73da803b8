// A system's `commands:`: which of its modules follow them, and which outputs drive them.
#pragma once

#include <string>
#include <vector>

#include "framework/graph/plan.h"
#include "framework/graph/wiring.h"

namespace ilss {

/// Reads the commands of a plan's systems while the plan is being built; what is wrong goes to the
/// diagnostics. Of modules that could not be read nothing more is said.
class CommandReader {
 public:
  /// Both must outlive it. Nodes may be added between calls.
  CommandReader(const std::vector<PlanNode>& nodes, Diagnostics& diagnostics)
      : nodes_(nodes), diagnostics_(diagnostics) {}

  /// Reads one system's `commands:` over the modules of its scope; `prefix` is that of their names.
  /// Systems inside it come first, since it may map their commands.
  void read(const Node& commands, const std::string& prefix, const Scope& scope);

  /// Checks what drives commands against them, once it is known what every node gives.
  void check_drivers();

  /// All commands, if nothing was wrong; `place` says where each node stands in the plan.
  std::vector<PlanCommand> finish(const std::vector<std::size_t>& place);

 private:
  /// A `from:` as written.
  struct Driver {
    std::size_t command = 0;
    std::size_t node = 0;
    std::string component;
    Position position;
  };

  void read_command(const Node& key, const Node& value, const std::string& prefix,
                    const Scope& scope);
  void find_target(const Node& to, const std::string& prefix, const Scope& scope,
                   PlanCommand& command);
  void find_target_in_system(const Node& to, const std::string& prefix, PlanCommand& command);
  void find_driver(const Node& from, const std::string& prefix, const Scope& scope);
  void find_driver_in_system(const Node& from, const std::string& prefix, const Instance& system);
  const Instance* find_instance(const Node& path, const Scope& scope);
  std::optional<std::size_t> find_component(const Driver& driver);
  void check_fit(const Driver& driver, std::size_t component);
  void check_driven_once(std::size_t driver);

  const std::vector<PlanNode>& nodes_;
  Diagnostics& diagnostics_;
  std::vector<PlanCommand> commands_;  ///< of unknown_node where it could not be read
  std::vector<Driver> drivers_;
};

}  // namespace ilss
