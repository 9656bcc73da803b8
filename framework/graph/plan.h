// The plan: a graph after every check has passed, immutable and in evaluation order.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "framework/module/registry.h"

namespace ilss {

/// How long a module takes (s): as declared, or as profiled.
struct ModuleTime {
  double typical = 0;
  double worst = 0;
};

/// A connection: which node's output, and how old a held value may be.
struct PlanInput {
  std::size_t node = 0;
  std::optional<Duration> max_age = {};
};

/// One module instance. Sources that it makes carry its index as owner.
struct PlanNode {
  std::string name;  ///< with the systems it stands in: "vision.camera"
  const ModuleType* type = nullptr;
  Settings settings = {};
  Interface interface = {};
  Estimate parameters = {};  ///< quantities, with the persistent sources of their errors
  std::vector<PlanInput> inputs = {};
  std::string frame = {};  ///< of the output
  std::optional<ModuleTime> time = {};
  /// Some two of its inputs, or ticks of one input, are correlated in a way that is not known.
  bool correlation_unknown = false;
  bool readable = true;  ///< while a plan is made: whether its settings could be read
  Position position = {};
};

/// Where estimates meet whose correlation no lineage tells: two nodes that each join random errors
/// of a common origin in a block (two filters fed by one sensor), one that does and another that
/// holds these errors as they are, or one (`first` and `second` alike) that keeps those of earlier
/// ticks and feeds another that treats its ticks as independent.
struct UnknownCorrelation {
  std::size_t at = 0;     ///< the node where they meet
  std::size_t first = 0;  ///< the nodes that hold them
  std::size_t second = 0;
  std::size_t origin = 0;  ///< a node whose errors both have
};

/// Where a driven command's value comes from: a component of a node's output.
struct CommandDriver {
  std::size_t node = 0;
  std::size_t component = 0;
};

/// A command of the system, which one of its modules follows.
struct PlanCommand {
  std::string name;  ///< with the systems it stands in: "inner.look_at"
  std::size_t node = 0;
  const CommandDeclaration* declaration = nullptr;  ///< the module type's
  std::optional<CommandDriver> driver = {};
};

/// Nodes in evaluation order: a node's inputs come before it.
struct Plan {
  std::string name;
  std::string description;
  std::vector<PlanNode> nodes;
  std::vector<std::size_t> outputs;  ///< nodes whose outputs are the system's, in order
  SourceOwners owners;               ///< the nodes first, then constants and parameters
  std::vector<UnknownCorrelation> unknown_correlations;
  std::vector<PlanCommand> commands;  ///< in the order of the file; those of nested systems first

  std::optional<std::size_t> find(std::string_view node) const {
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (nodes[i].name == node) return i;
    return std::nullopt;
  }
};

/// A value to set instead of what a graph's file says: `path` is `MODULE.PARAMETER` (deeper names
/// for groups and nested systems), or `constants.NAME`.
struct Override {
  std::string path;
  Node value;
  Position position = {};
};

/// Reads "PATH=VALUE" as users write it on a command line; `origin` is what to call it in messages.
std::optional<Override> parse_override(const std::string& text, const std::string& origin,
                                       Diagnostics& diagnostics);

/// Reads a graph file into a plan. Everything that is wrong goes to `diagnostics`, all in one go;
/// no module's code runs. Nothing is returned if anything is wrong.
std::optional<Plan> read_plan(const std::filesystem::path& file, const Registry& registry,
                              const std::vector<Override>& overrides, Diagnostics& diagnostics);

/// As above from a graph that stands inside another document; relative paths start at `directory`.
std::optional<Plan> build_plan(const Node& graph, const std::filesystem::path& directory,
                               const Registry& registry, const std::vector<Override>& overrides,
                               Diagnostics& diagnostics);

}  // namespace ilss
