#include "framework/semantics/perturbation.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <unordered_set>

#include "framework/graph/guarded.h"
#include "framework/module/carried_correlation.h"
#include "framework/module/contract.h"

namespace ilss {
namespace {

constexpr std::size_t no_source = std::numeric_limits<std::size_t>::max();

/// `to` = `from` ⊕ G e.
void move(const Estimate& from, std::span<const std::size_t> places, std::span<const double> errors,
          std::vector<double>& to) {
  std::fill(to.begin(), to.end(), 0.0);
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (places[k] == no_source) continue;
    const double error = errors[places[k]];
    if (error == 0) continue;
    const auto column = from.lineage.column(k);
    for (std::size_t c = 0; c < column.size(); ++c) to[c] += error * column[c];
  }
  retract(*from.type, from.value, to, to);
}

}  // namespace

Perturbation::Perturbation(const System& system, std::span<const std::size_t> targets,
                           std::span<const std::size_t> cut, Redo redo, bool with_lineages)
    : system_(system), with_lineages_(with_lineages) {
  find_region(targets, cut, redo);
  for (const std::size_t target : targets) targets_.push_back(place_of_node(target));
  for (Step& step : steps_) {
    const PlanNode& node = system.plan().nodes[step.node];
    with_lineages_ |= step.role == Step::Role::redone &&
                      (node.type->weighs_errors || node.type->kind == ModuleKind::estimator);
    step.seed = derive_seed(0, node.name);
    if (step.role != Step::Role::redone && step.role != Step::Role::selected) continue;
    for (const PlanInput& input : node.inputs) step.producers.push_back(place_of_node(input.node));
  }
  refresh();
}

std::size_t Perturbation::place_of_node(std::size_t node) const {
  const auto at = std::lower_bound(steps_.begin(), steps_.end(), node,
                                   [](const Step& step, std::size_t n) { return step.node < n; });
  return static_cast<std::size_t>(at - steps_.begin());
}

/// Steps for the nodes that the targets follow from, as far up as anything is redone.
void Perturbation::find_region(std::span<const std::size_t> targets,
                               std::span<const std::size_t> cut, Redo redo) {
  const Plan& plan = system_.plan();
  const auto is_cut = [&](std::size_t node) {
    return system_.is_given(node) || std::binary_search(cut.begin(), cut.end(), node);
  };
  std::vector<std::size_t> waiting(targets.begin(), targets.end());
  std::unordered_set<std::size_t> region(waiting.begin(), waiting.end());
  while (!waiting.empty()) {
    const std::size_t node = waiting.back();
    waiting.pop_back();
    const ModuleType& type = *plan.nodes[node].type;
    const bool is_function = type.kind == ModuleKind::function || type.selects;
    if ((!is_function && redo == Redo::functions) || is_cut(node)) continue;
    for (const PlanInput& input : plan.nodes[node].inputs)
      if (region.insert(input.node).second) waiting.push_back(input.node);
  }
  std::vector<std::size_t> nodes(region.begin(), region.end());
  std::sort(nodes.begin(), nodes.end());
  steps_.reserve(nodes.size());
  for (const std::size_t node : nodes) {
    const Step::Role role = role_of(node, is_cut(node), redo);
    steps_.emplace_back().node = node;
    steps_.back().role = role;
  }
  drop_unneeded(targets);
}

/// What an estimator needs is known once it is known whether its sensors are simulated; drops what
/// is needed only by one that is moved.
void Perturbation::drop_unneeded(std::span<const std::size_t> targets) {
  std::vector<char> needed(steps_.size(), 0);
  for (const std::size_t target : targets) needed[place_of_node(target)] = 1;
  for (std::size_t s = steps_.size(); s-- > 0;)
    if (needed[s] &&
        (steps_[s].role == Step::Role::redone || steps_[s].role == Step::Role::selected))
      for (const PlanInput& input : system_.plan().nodes[steps_[s].node].inputs)
        needed[place_of_node(input.node)] = 1;
  std::size_t kept = 0;
  for (std::size_t s = 0; s < steps_.size(); ++s)
    if (needed[s] && kept++ != s) steps_[kept - 1] = std::move(steps_[s]);
  steps_.resize(kept);
}

Perturbation::Step::Role Perturbation::role_of(std::size_t node, bool cut, Redo redo) const {
  using Role = Step::Role;
  const PlanNode& plan_node = system_.plan().nodes[node];
  if (cut) return Role::moved;
  const bool selects = plan_node.type->selects;
  if (plan_node.type->kind == ModuleKind::function && !selects) return Role::redone;
  if (redo == Redo::functions && !selects) return Role::moved;
  if (plan_node.type->kind == ModuleKind::sensor && !selects)
    return plan_node.interface.draws_readings ? Role::simulated : Role::moved;
  // An estimator can be redone, and a selector passes on what is, where everything that feeds it is
  // new or merely numbers, and something is new.
  bool any_new = false;
  for (const PlanInput& input : plan_node.inputs) {
    const Role role = steps_[place_of_node(input.node)].role;
    const bool has_samples = system_.plan().nodes[input.node].interface.output->samples.has_value();
    if (role == Role::moved && has_samples) return Role::moved;
    any_new |= role != Role::moved;
  }
  if (!any_new) return Role::moved;
  return selects ? Role::selected : Role::redone;
}

void Perturbation::refresh() {
  sources_.clear();
  find_needed();
  for (Step& step : steps_) {
    step.there = step.needed && is_there(step);
    if (step.there) collect(step);
  }
  std::sort(sources_.begin(), sources_.end());
  sources_.erase(std::unique(sources_.begin(), sources_.end()), sources_.end());
  errors_.assign(sources_.size(), 0.0);
  changed_.assign(sources_.size(), 0);
  seed_.reset();
  for (Step& step : steps_) prepare(step);
}

/// Marks what the targets follow from, as selectors have selected.
void Perturbation::find_needed() {
  for (Step& step : steps_) {
    step.needed = false;
    step.acts = system_.is_left_out(step.node) ? Step::Role::moved : step.role;
  }
  for (const std::size_t target : targets_) steps_[target].needed = true;
  for (std::size_t s = steps_.size(); s-- > 0;) {
    Step& step = steps_[s];
    if (!step.needed) continue;
    step.selected = system_.node(step.node).selected;
    for (const std::size_t producer : step.feeds()) steps_[producer].needed = true;
  }
}

/// Whether there is an output to begin with, and all that it is redone from. One that is held from
/// an earlier tick is as good as one of this tick.
bool Perturbation::is_there(const Step& step) const {
  const auto feeds = step.feeds();
  return system_.node(step.node).has_value &&
         std::all_of(feeds.begin(), feeds.end(), [this](std::size_t p) { return steps_[p].there; });
}

/// Adds the sources that move a step, or its parameters.
void Perturbation::collect(const Step& step) {
  if (step.acts == Step::Role::selected) return;
  const Lineage& lineage = step.acts == Step::Role::moved
                               ? system_.node(step.node).output().estimate.lineage
                               : system_.plan().nodes[step.node].parameters.lineage;
  for (const Source& source : lineage.sources())
    if (step.acts != Step::Role::simulated || source.persistent()) sources_.push_back(source);
}

void Perturbation::find_places(const Lineage& lineage, std::vector<std::size_t>& places) const {
  places.clear();
  for (const Source& source : lineage.sources()) {
    const auto at = std::lower_bound(sources_.begin(), sources_.end(), source);
    const bool known = at != sources_.end() && *at == source;
    places.push_back(known ? static_cast<std::size_t>(at - sources_.begin()) : no_source);
  }
}

/// Takes a node's output, and what moves it, from the system as it stands.
void Perturbation::prepare(Step& step) {
  const NodeState& state = system_.node(step.node);
  const PlanNode& node = system_.plan().nodes[step.node];
  step.changed = false;
  step.changed_label = false;
  step.failed = !step.there;
  step.fault_from = nullptr;
  step.shown = &state.output();
  step.movable = false;
  if (!step.there) return;
  if (step.acts == Step::Role::selected) {
    const Step& selected = steps_[step.producers[step.selected]];
    step.shown = selected.shown;
    step.movable = selected.movable;
    return;
  }
  find_places(
      step.acts == Step::Role::moved ? state.output().estimate.lineage : node.parameters.lineage,
      step.places);
  step.movable = step.acts == Step::Role::simulated || !step.places.empty();
  for (const std::size_t producer : step.feeds()) step.movable |= steps_[producer].movable;
  if (!step.movable && (with_lineages_ || state.output().estimate.lineage.empty())) return;
  step.shown = &step.output;
  step.output = state.output();
  if (!with_lineages_) step.output.estimate.lineage.reset(step.output.estimate.dimension());
  if (!step.movable || step.acts == Step::Role::moved) return;
  if (step.module == nullptr) {
    step.module = node.type->create(node.settings);
    step.parameters = node.parameters;
    // A simulated sensor keeps its parameters' errors, to state them.
    if (!with_lineages_ && step.acts == Step::Role::redone)
      step.parameters.lineage.reset(step.parameters.dimension());
  }
  step.inputs.clear();
  for (const std::size_t producer : step.producers) step.inputs.push_back(steps_[producer].shown);
}

void Perturbation::apply(std::span<const double> errors, std::uint64_t seed) {
  for (std::size_t k = 0; k < errors_.size(); ++k) {
    changed_[k] = errors[k] != errors_[k] ? 1 : 0;
    errors_[k] = errors[k];
  }
  const bool draws_anew = seed_ != seed;
  seed_ = seed;
  const auto is_changed = [this](std::size_t k) { return k != no_source && changed_[k] != 0; };
  for (Step& step : steps_) {
    if (!step.movable) continue;
    if (step.acts == Step::Role::selected) {
      pass_on(step);
      continue;
    }
    step.changed = (draws_anew && step.acts == Step::Role::simulated) ||
                   std::any_of(step.places.begin(), step.places.end(), is_changed) ||
                   std::any_of(step.feeds().begin(), step.feeds().end(),
                               [this](std::size_t p) { return steps_[p].changed; });
    if (!step.changed) continue;
    if (step.acts == Step::Role::moved)
      move(system_.node(step.node).output().estimate, step.places, errors_,
           step.output.estimate.value);
    else
      redo(step, seed);
  }
}

/// A selector says what its branch says.
void Perturbation::pass_on(Step& step) const {
  const Step& selected = steps_[step.producers[step.selected]];
  step.changed = selected.changed;
  step.failed = selected.failed;
  step.changed_label = selected.changed_label;
  step.fault_from = selected.fault_from != nullptr ? selected.fault_from : &selected;
}

void Perturbation::redo(Step& step, std::uint64_t seed) {
  step.failed = false;
  step.changed_label = false;
  step.fault_from = nullptr;
  for (const std::size_t producer : step.producers) {
    const Step& feed = steps_[producer];
    if (feed.failed && !step.failed)
      step.fault_from = feed.fault_from != nullptr ? feed.fault_from : &feed;
    step.failed |= feed.failed;
    step.changed_label |= feed.changed_label;
  }
  if (step.failed) return;
  const PlanNode& node = system_.plan().nodes[step.node];
  if (step.acts == Step::Role::redone)
    move(node.parameters, step.places, errors_, step.parameters.value);
  if (node.type->kind != ModuleKind::function) step.module->reset();
  const Evaluation evaluation{.tick = 0,
                              .time = {},
                              .seed = derive_seed(seed, step.seed),
                              .owner = static_cast<std::uint32_t>(step.node),
                              .parameters = step.parameters,
                              .inputs = step.inputs,
                              .correlation_unknown = node.correlation_unknown,
                              .run_seed = derive_seed(seed, step.seed)};
  Outcome<> outcome = guarded([&] {
    return carry_correlation(*node.type, evaluation, step.output,
                             [&] { return step.module->evaluate(evaluation, step.output); });
  });
  if (outcome.has_output() && !node.type->checked &&
      find_breach(step.output, *node.interface.output) != Breach::none)
    outcome = describe_breach(step.output, *node.interface.output);
  step.failed = !outcome.has_output();
  if (outcome.is_fault()) step.fault = outcome.fault();
  if (step.failed) return;
  if (step.acts == Step::Role::simulated) move_simulated(step);
  if (step.output.estimate.labels.empty()) return;
  step.changed_label |=
      step.output.estimate.labels != system_.node(step.node).output().estimate.labels;
}

void Perturbation::move_simulated(Step& step) const {
  Estimate& estimate = step.output.estimate;
  const Lineage& lineage = estimate.lineage;
  std::vector<double>& moved = step.moved;
  moved.assign(estimate.dimension(), 0.0);
  for (std::size_t k = 0; k < lineage.size(); ++k) {
    const auto at = std::lower_bound(sources_.begin(), sources_.end(), lineage.sources()[k]);
    if (at == sources_.end() || *at != lineage.sources()[k]) continue;
    const double error = errors_[static_cast<std::size_t>(at - sources_.begin())];
    for (std::size_t c = 0; c < moved.size(); ++c) moved[c] += error * lineage.column(k)[c];
  }
  retract(*estimate.type, estimate.value, moved, estimate.value);
  if (!with_lineages_) estimate.lineage.reset(estimate.dimension());
}

void Perturbation::offset(std::size_t target, std::span<double> out) const {
  const Estimate& stated = system_.node(target_node(target)).output().estimate;
  const Estimate& moved = value(target);
  difference(*stated.type, moved.value, stated.value, out);
}

Fault Perturbation::fault(std::size_t target) const {
  const Step* from = &target_step(target);
  // One without an output to begin with may be so because of what feeds it.
  while (!from->there && !from->producers.empty() && from->acts != Step::Role::selected) {
    const auto missing = std::find_if(from->producers.begin(), from->producers.end(),
                                      [this](std::size_t p) { return !steps_[p].there; });
    if (missing == from->producers.end()) break;
    from = &steps_[*missing];
  }
  if (from->fault_from != nullptr) from = from->fault_from;
  const std::string& name = system_.plan().nodes[from->node].name;
  if (!from->there) return {FaultKind::no_detection, fmt::format("'{}' has no output", name)};
  return {from->fault.kind, fmt::format("'{}': {}", name, from->fault.message)};
}

}  // namespace ilss
