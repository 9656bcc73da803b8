// What a system's outputs become when its sources of error take given values.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "framework/graph/system.h"

namespace ilss {

/// Which nodes give new values, rather than values moved along their stated errors.
enum class Redo {
  functions,   ///< only functions
  simulation,  ///< simulated sensors, too, and the estimators behind them
};

/// Takes a system as it stands after a tick or an expectation, and redoes its outputs under errors.
/// A sensor or estimator that is not redone is moved by its lineage, G e; a function behind it is
/// evaluated again with its parameters moved. A simulated sensor draws a reading with its nominal
/// parameters, which are the simulation's truth, and then moves what it says of itself by the
/// lineage of its parameters; an estimator that it feeds is reset and evaluated. Instances of
/// modules are its own, so that several may work side by side; no allocation once warm.
class Perturbation {
 public:
  /// `cut` names nodes whose outputs were given, and are moved in any case. Outputs come without
  /// lineages, which costs less, unless a module weighs the errors of its inputs or
  /// `with_lineages` asks for them: those that are stated at the moved values.
  Perturbation(const System& system, const std::vector<std::size_t>& cut, Redo redo,
               bool with_lineages = false);

  /// The sources that errors are to be given for, sorted.
  const std::vector<Source>& sources() const { return sources_; }

  /// Gives each source its error (standard deviations, in the order of `sources`), simulated
  /// sensors the seed of their noise, and redoes the outputs.
  void apply(std::span<const double> errors, std::uint64_t seed = 0);

  /// The output of a node that the system's outputs follow from.
  const Estimate& value(std::size_t node) const { return step(node).output.estimate; }
  /// Whether there is none, and why: the message names the node that the fault comes from.
  bool failed(std::size_t node) const { return step(node).failed; }
  Fault fault(std::size_t node) const;
  /// Whether a label changed on the way to the node: another case of a formula.
  bool changed_label(std::size_t node) const { return step(node).changed_label; }

  /// Nodes that outputs follow from, in order.
  std::vector<std::size_t> nodes() const;

 private:
  enum class Role { moved, redone, simulated };
  struct Step {
    std::size_t node;
    Role role;
    std::unique_ptr<Module> module = nullptr;
    Output output = {};
    Estimate parameters = {};
    std::vector<std::size_t> output_sources = {};     ///< the place of each column's source
    std::vector<std::size_t> parameter_sources = {};  ///< likewise
    std::vector<std::size_t> producers = {};          ///< steps that feed it
    std::vector<const Output*> inputs = {};
    std::vector<double> moved = {};  ///< the error that a simulated reading takes
    Fault fault = {};
    const Step* fault_from = nullptr;
    std::uint64_t seed = 0;
    bool failed = false;
    bool changed_label = false;
    bool dead = false;  ///< has no output to begin with
  };

  const Step& step(std::size_t node) const { return steps_[step_of_node_[node]]; }
  Role role_of(std::size_t node, bool cut, Redo redo) const;
  void prepare(Step& step);
  void collect(const Lineage& lineage, bool persistent_only);
  std::vector<std::size_t> places_of(const Lineage& lineage) const;
  void redo(Step& step, std::span<const double> errors, std::uint64_t seed);
  void move_simulated(Step& step, std::span<const double> errors) const;

  const System& system_;
  std::vector<Step> steps_;
  std::vector<std::size_t> step_of_node_;
  std::vector<Source> sources_;
  bool with_lineages_ = false;
};

}  // namespace ilss
