#include "framework/semantics/perturbation.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "framework/graph/guarded.h"

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

Perturbation::Perturbation(const System& system, const std::vector<std::size_t>& cut, Redo redo,
                           bool with_lineages)
    : system_(system), step_of_node_(system.size(), 0), with_lineages_(with_lineages) {
  const Plan& plan = system.plan();
  std::vector<char> needed(system.size(), 0);
  std::vector<char> is_cut(system.size(), 0);
  for (const std::size_t node : cut) is_cut[node] = 1;
  for (const std::size_t output : plan.outputs) needed[output] = 1;
  // What an estimator needs is known once it is known whether its sensors are simulated, so what is
  // needed only by a moved estimator is dropped in a second pass.
  for (std::size_t i = system.size(); i-- > 0;)
    if (needed[i] && !is_cut[i])
      for (const PlanInput& input : plan.nodes[i].inputs) needed[input.node] = 1;
  for (std::size_t i = 0; i < system.size(); ++i) {
    if (!needed[i]) continue;
    step_of_node_[i] = steps_.size();
    Step& step = steps_.emplace_back();
    step.node = i;
    step.role = role_of(i, is_cut[i] != 0, redo);
  }
  std::fill(needed.begin(), needed.end(), 0);
  for (const std::size_t output : plan.outputs) needed[output] = 1;
  for (std::size_t s = steps_.size(); s-- > 0;)
    if (needed[steps_[s].node] && steps_[s].role == Role::redone)
      for (const PlanInput& input : plan.nodes[steps_[s].node].inputs) needed[input.node] = 1;
  std::erase_if(steps_, [&](const Step& step) { return !needed[step.node]; });
  for (std::size_t s = 0; s < steps_.size(); ++s) step_of_node_[steps_[s].node] = s;
  for (const Step& step : steps_) {
    const ModuleType& type = *plan.nodes[step.node].type;
    with_lineages_ |=
        step.role == Role::redone && (type.weighs_errors || type.kind == ModuleKind::estimator);
  }
  for (Step& step : steps_) prepare(step);
  std::sort(sources_.begin(), sources_.end());
  sources_.erase(std::unique(sources_.begin(), sources_.end()), sources_.end());
  for (Step& step : steps_) {
    if (step.dead) continue;
    if (step.role == Role::moved)
      step.output_sources = places_of(system.node(step.node).output.estimate.lineage);
    else
      step.parameter_sources = places_of(plan.nodes[step.node].parameters.lineage);
  }
}

Perturbation::Role Perturbation::role_of(std::size_t node, bool cut, Redo redo) const {
  const PlanNode& plan_node = system_.plan().nodes[node];
  if (cut) return Role::moved;
  if (plan_node.type->kind == ModuleKind::function) return Role::redone;
  if (redo == Redo::functions) return Role::moved;
  if (plan_node.type->kind == ModuleKind::sensor)
    return plan_node.interface.draws_readings ? Role::simulated : Role::moved;
  // An estimator can be redone where everything that feeds it is new or merely numbers, and
  // something is new.
  bool any_new = false;
  for (const PlanInput& input : plan_node.inputs) {
    const Role role = steps_[step_of_node_[input.node]].role;
    const bool has_samples = system_.plan().nodes[input.node].interface.output->samples.has_value();
    if (role == Role::moved && has_samples) return Role::moved;
    any_new |= role != Role::moved;
  }
  return any_new ? Role::redone : Role::moved;
}

void Perturbation::prepare(Step& step) {
  const NodeState& state = system_.node(step.node);
  const PlanNode& node = system_.plan().nodes[step.node];
  if (!state.outcome.has_output()) {
    step.dead = true;
    step.failed = true;
    return;
  }
  step.output = state.output;
  if (!with_lineages_) step.output.estimate.lineage.reset(step.output.estimate.dimension());
  if (step.role == Role::moved) return collect(state.output.estimate.lineage, false);
  step.module = node.type->create(node.settings);
  step.seed = derive_seed(0, node.name);
  step.parameters = node.parameters;
  collect(node.parameters.lineage, step.role == Role::simulated);
  if (step.role == Role::simulated) return;  // keeps its parameters, to state their errors
  if (!with_lineages_) step.parameters.lineage.reset(step.parameters.dimension());
  for (const PlanInput& input : node.inputs) {
    step.producers.push_back(step_of_node_[input.node]);
    step.inputs.push_back(&steps_[step_of_node_[input.node]].output);
  }
}

void Perturbation::collect(const Lineage& lineage, bool persistent_only) {
  for (const Source& source : lineage.sources())
    if (!persistent_only || source.persistent()) sources_.push_back(source);
}

std::vector<std::size_t> Perturbation::places_of(const Lineage& lineage) const {
  std::vector<std::size_t> places;
  for (const Source& source : lineage.sources()) {
    const auto at = std::lower_bound(sources_.begin(), sources_.end(), source);
    const bool known = at != sources_.end() && *at == source;
    places.push_back(known ? static_cast<std::size_t>(at - sources_.begin()) : no_source);
  }
  return places;
}

void Perturbation::apply(std::span<const double> errors, std::uint64_t seed) {
  for (Step& step : steps_) {
    if (step.dead) continue;
    if (step.role == Role::moved)
      move(system_.node(step.node).output.estimate, step.output_sources, errors,
           step.output.estimate.value);
    else
      redo(step, errors, seed);
  }
}

void Perturbation::redo(Step& step, std::span<const double> errors, std::uint64_t seed) {
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
  if (step.role == Role::redone)
    move(node.parameters, step.parameter_sources, errors, step.parameters.value);
  if (node.type->kind != ModuleKind::function) step.module->reset();
  const Evaluation evaluation{.tick = 0,
                              .time = 0,
                              .seed = derive_seed(seed, step.seed),
                              .owner = static_cast<std::uint32_t>(step.node),
                              .parameters = step.parameters,
                              .inputs = step.inputs,
                              .correlation_unknown = node.correlation_unknown,
                              .run_seed = derive_seed(seed, step.seed)};
  Outcome<> outcome = guarded([&] { return step.module->evaluate(evaluation, step.output); });
  step.failed = !outcome.has_output();
  if (outcome.is_fault()) step.fault = outcome.fault();
  if (step.failed) return;
  if (step.role == Role::simulated) move_simulated(step, errors);
  if (step.output.estimate.labels.empty()) return;
  step.changed_label |=
      step.output.estimate.labels != system_.node(step.node).output.estimate.labels;
}

void Perturbation::move_simulated(Step& step, std::span<const double> errors) const {
  Estimate& estimate = step.output.estimate;
  const Lineage& lineage = estimate.lineage;
  std::vector<double>& moved = step.moved;
  moved.assign(estimate.dimension(), 0.0);
  for (std::size_t k = 0; k < lineage.size(); ++k) {
    const auto at = std::lower_bound(sources_.begin(), sources_.end(), lineage.sources()[k]);
    if (at == sources_.end() || *at != lineage.sources()[k]) continue;
    const double error = errors[static_cast<std::size_t>(at - sources_.begin())];
    for (std::size_t c = 0; c < moved.size(); ++c) moved[c] += error * lineage.column(k)[c];
  }
  retract(*estimate.type, estimate.value, moved, estimate.value);
  if (!with_lineages_) estimate.lineage.reset(estimate.dimension());
}

Fault Perturbation::fault(std::size_t node) const {
  const Step* from = step(node).fault_from != nullptr ? step(node).fault_from : &step(node);
  const std::string& name = system_.plan().nodes[from->node].name;
  if (from->dead) return {FaultKind::no_detection, fmt::format("'{}' has no output", name)};
  return {from->fault.kind, fmt::format("'{}': {}", name, from->fault.message)};
}

std::vector<std::size_t> Perturbation::nodes() const {
  std::vector<std::size_t> result;
  for (const Step& step : steps_) result.push_back(step.node);
  return result;
}

}  // namespace ilss
