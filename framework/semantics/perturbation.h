// What a system's outputs become when its sources of error take given values.
#pragma once

#include <memory>
#include <optional>
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

/// Takes a system as it stands after a tick or an expectation, and redoes some of its nodes, the
/// targets, under errors. A sensor or estimator that is not redone is moved by its lineage, G e; a
/// function behind it is evaluated again with its parameters moved. A simulated sensor draws a
/// reading with its nominal parameters, which are the simulation's truth, and then moves what it
/// says of itself by the lineage of its parameters; an estimator that it feeds is reset and
/// evaluated; a selector passes on the branch that it had selected. Knows only the nodes that the
/// targets follow from, and of these redoes those that follow from what has changed: what no error
/// reaches is neither copied nor evaluated. Instances of modules are its own, made when first
/// needed, so that several may work side by side; no allocation once warm.
class Perturbation {
 public:
  /// Takes the system as it stands. `cut` names nodes (sorted) that are moved in any case, as
  /// are those whose outputs come from outside. Outputs come without lineages, which costs less,
  /// unless a module weighs the errors of its inputs or `with_lineages` asks for them: those that
  /// are stated at the moved values.
  Perturbation(const System& system, std::span<const std::size_t> targets,
               std::span<const std::size_t> cut, Redo redo, bool with_lineages = false);

  /// Takes the system as it stands now, after another tick; all errors are 0 again.
  void refresh();

  /// The sources that errors are to be given for, sorted.
  std::span<const Source> sources() const { return sources_; }

  /// Gives each source its error (standard deviations, in the order of `sources`), simulated
  /// sensors the seed of their noise, and redoes what follows from errors other than before.
  void apply(std::span<const double> errors, std::uint64_t seed = 0);

  std::size_t target_count() const { return targets_.size(); }
  std::size_t target_node(std::size_t target) const { return target_step(target).node; }
  /// A target's output; as it was stated where no error reaches it.
  const Estimate& value(std::size_t target) const { return target_step(target).shown->estimate; }
  /// How much it differs from what was stated (M), as `difference` has it.
  void offset(std::size_t target, std::span<double> out) const;
  /// Whether any error reaches it.
  bool movable(std::size_t target) const { return target_step(target).movable; }
  /// Whether `apply` redid it, the last time.
  bool changed(std::size_t target) const { return target_step(target).changed; }
  /// Whether it has no output, and why: the message names the node that the fault comes from.
  bool failed(std::size_t target) const { return target_step(target).failed; }
  Fault fault(std::size_t target) const;
  /// Whether a label changed on the way to it: another case of a formula.
  bool changed_label(std::size_t target) const { return target_step(target).changed_label; }

  /// A node that targets follow from, and which of these nodes it is evaluated from.
  struct Step {
    std::size_t node = 0;
    std::vector<std::size_t> producers = {};

    /// Whether the system has an output of it to begin with, that the targets follow from.
    bool is_there() const { return there; }
    /// Those of the producers that its output follows from now.
    std::span<const std::size_t> feeds() const {
      if (acts == Role::selected) return {&producers[selected], 1};
      return acts == role ? std::span(producers) : std::span<const std::size_t>();
    }

   private:
    friend class Perturbation;
    enum class Role { moved, redone, simulated, selected };
    Role role = Role::moved;
    Role acts =
        Role::moved;  ///< the same, but moved where the system holds an earlier tick's value
    std::unique_ptr<Module> module = nullptr;
    const Output* shown = nullptr;  ///< `output`, or the system's where no error reaches it
    Output output = {};
    Estimate parameters = {};
    std::vector<std::size_t> places = {};  ///< of the sources that move it or its parameters
    std::vector<const Output*> inputs = {};
    std::vector<double> moved = {};  ///< the error that a simulated reading takes
    Fault fault = {};
    const Step* fault_from = nullptr;
    std::uint64_t seed = 0;
    std::size_t selected = 0;  ///< of a selector: the producer whose output it passes on
    bool needed = false;       ///< no target follows from the branches that are not selected
    bool there = false;        ///< has an output to begin with
    bool movable = false;      ///< some error reaches it
    bool changed = false;
    bool failed = false;
    bool changed_label = false;
  };
  /// In order of evaluation.
  std::span<const Step> steps() const { return steps_; }
  /// The place of a target among them.
  std::size_t step_of(std::size_t target) const { return targets_[target]; }

 private:
  const Step& target_step(std::size_t target) const { return steps_[targets_[target]]; }
  std::size_t place_of_node(std::size_t node) const;
  void find_region(std::span<const std::size_t> targets, std::span<const std::size_t> cut,
                   Redo redo);
  Step::Role role_of(std::size_t node, bool cut, Redo redo) const;
  void drop_unneeded(std::span<const std::size_t> targets);
  void find_needed();
  bool is_there(const Step& step) const;
  void collect(const Step& step);
  void find_places(const Lineage& lineage, std::vector<std::size_t>& places) const;
  void prepare(Step& step);
  void pass_on(Step& step) const;
  void redo(Step& step, std::uint64_t seed);
  void move_simulated(Step& step) const;

  const System& system_;
  std::vector<Step> steps_;
  std::vector<std::size_t> targets_;  ///< their steps
  std::vector<Source> sources_;
  std::vector<double> errors_;
  std::vector<char> changed_;          ///< of the sources, by the last `apply`
  std::optional<std::uint64_t> seed_;  ///< of the last `apply`
  bool with_lineages_ = false;
};

}  // namespace ilss
