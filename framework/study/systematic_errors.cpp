#include "framework/study/systematic_errors.h"

namespace ilss {
namespace {

/// The error of one source in the run of a seed: the same wherever the source is used.
double draw(std::uint64_t seed, const Source& source) {
  const std::uint64_t which = (std::uint64_t{source.owner} << 32) | source.column;
  RandomBits random(derive_seed(seed, which));
  return std::normal_distribution<double>()(random);
}

/// `to` is `from` with the value moved by its persistent sources; the lineage stays.
void move(const Estimate& from, std::uint64_t seed, Estimate& to) {
  to = from;
  for (std::size_t k = 0; k < from.lineage.size(); ++k) {
    const Source& source = from.lineage.sources()[k];
    if (!source.persistent()) continue;
    const double error = draw(seed, source);
    const auto column = from.lineage.column(k);
    for (std::size_t c = 0; c < column.size(); ++c) to.value[c] += error * column[c];
  }
  for (std::size_t c = 0; c < to.value.size(); ++c)
    if (to.type->components[c].circular) to.value[c] = wrap_angle(to.value[c]);
}

}  // namespace

SystematicErrors::SystematicErrors(const System& system) : system_(system), nodes_(system.size()) {
  const std::vector<PlanNode>& plan = system.plan().nodes;
  nodes_[system.plan().outputs.front()].needed = true;
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    nodes_[i].output = system.node(i).output;
    if (!nodes_[i].needed || plan[i].type->kind != ModuleKind::function) continue;
    for (const PlanInput& input : plan[i].inputs) {
      nodes_[input.node].needed = true;
      nodes_[i].inputs.push_back(&nodes_[input.node].output);
    }
  }
}

Outcome<> SystematicErrors::apply(std::uint64_t seed, Estimate& output) {
  const Plan& plan = system_.plan();
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    if (!node.needed) continue;
    if (plan.nodes[i].type->kind != ModuleKind::function) {
      move(system_.node(i).output.estimate, seed, node.output.estimate);
      continue;
    }
    move(plan.nodes[i].parameters, seed, node.parameters);
    Outcome<> outcome = system_.try_function(i, node.parameters, node.inputs, node.output);
    if (!outcome) return outcome;
  }
  output = nodes_[plan.outputs.front()].output.estimate;
  return {};
}

}  // namespace ilss
