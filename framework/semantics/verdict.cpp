#include "framework/semantics/verdict.h"

#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

/// Values without errors of every node that the outputs follow from, and how to redo them.
class Perturbation {
 public:
  Perturbation(const System& system, const std::vector<std::size_t>& cut)
      : system_(system), nodes_(system.size()) {
    std::vector<char> needed(system.size(), 0);
    for (const std::size_t output : system.plan().outputs) needed[output] = 1;
    for (std::size_t i = system.size(); i-- > 0;) {
      if (!needed[i]) continue;
      const PlanNode& node = system.plan().nodes[i];
      const bool is_cut = node.type->kind != ModuleKind::function ||
                          std::find(cut.begin(), cut.end(), i) != cut.end();
      nodes_[i].role = is_cut ? Role::moved : Role::redone;
      if (!is_cut)
        for (const PlanInput& input : node.inputs) needed[input.node] = 1;
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) prepare(i);
    std::sort(sources_.begin(), sources_.end());
    sources_.erase(std::unique(sources_.begin(), sources_.end()), sources_.end());
  }

  const std::vector<Source>& sources() const { return sources_; }

  /// Moves one source by `amount` standard deviations and redoes every function; false on a fault.
  bool apply(const Source& source, double amount) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      NodeValues& node = nodes_[i];
      if (node.role == Role::moved) {
        move(system_.node(i).output.estimate, source, amount, node.output.estimate);
      } else if (node.role == Role::redone) {
        move(system_.plan().nodes[i].parameters, source, amount, node.parameters);
        if (!system_.try_function(i, node.parameters, node.inputs, node.output)) return false;
      }
    }
    return true;
  }

  const Estimate& value(std::size_t node) const { return nodes_[node].output.estimate; }

 private:
  enum class Role { unused, moved, redone };
  struct NodeValues {
    Role role = Role::unused;
    Output output;
    Estimate parameters;
    std::vector<const Output*> inputs;
  };

  void prepare(std::size_t i) {
    NodeValues& node = nodes_[i];
    if (node.role == Role::unused) return;
    node.output = system_.node(i).output;
    node.output.estimate.lineage.reset(node.output.estimate.dimension());
    if (node.role == Role::moved) {
      collect(system_.node(i).output.estimate.lineage);
      return;
    }
    const PlanNode& plan_node = system_.plan().nodes[i];
    collect(plan_node.parameters.lineage);
    node.parameters = plan_node.parameters;
    node.parameters.lineage.reset(node.parameters.dimension());
    for (const PlanInput& input : plan_node.inputs)
      node.inputs.push_back(&nodes_[input.node].output);
  }
  void collect(const Lineage& lineage) {
    sources_.insert(sources_.end(), lineage.sources().begin(), lineage.sources().end());
  }
  static void move(const Estimate& from, const Source& source, double amount, Estimate& to) {
    to.value = from.value;
    const auto sources = from.lineage.sources();
    const auto found = std::lower_bound(sources.begin(), sources.end(), source);
    if (found == sources.end() || *found != source) return;
    const auto column = from.lineage.column(static_cast<std::size_t>(found - sources.begin()));
    for (std::size_t c = 0; c < column.size(); ++c) to.value[c] += amount * column[c];
  }

  const System& system_;
  std::vector<NodeValues> nodes_;
  std::vector<Source> sources_;
};

/// Sums over sources of what moving each does to one output component.
struct Moments {
  double curvature = 0;          ///< of second differences
  double squared_curvature = 0;  ///< of their squares
  double secant_variance = 0;    ///< of squared central differences
};

Verdict judge_component(const Moments& moments, double variance, double scale) {
  const double bias = std::abs(moments.curvature) / 2;
  const double extra = moments.squared_curvature / 2;
  // An error of rounding is no error.
  const double rounding = 1e-9 * scale;
  if (bias <= rounding && std::sqrt(extra) <= rounding &&
      std::sqrt(std::abs(moments.secant_variance - variance)) <= rounding)
    return Verdict::linear_ok;
  const bool linear =
      bias <= largest_relative_bias * std::sqrt(variance) &&
      extra <= largest_relative_variance_change * variance &&
      std::abs(moments.secant_variance - variance) <= largest_relative_variance_change * variance;
  return linear ? Verdict::linear_ok : Verdict::second_order;
}

}  // namespace

std::string_view verdict_name(Verdict verdict) {
  switch (verdict) {
    case Verdict::linear_ok:
      return "linear_ok";
    case Verdict::second_order:
      return "second_order";
    case Verdict::monte_carlo_required:
      return "monte_carlo_required";
    case Verdict::invalid:
      return "invalid";
  }
  return "invalid";
}

std::vector<VerdictReport> judge(const System& system, const std::vector<std::size_t>& cut) {
  const std::vector<std::size_t>& outputs = system.plan().outputs;
  Perturbation perturbation(system, cut);
  const double step = std::sqrt(3.0);
  std::vector<VerdictReport> reports(outputs.size());
  std::vector<std::vector<Moments>> moments(outputs.size());
  std::vector<Eigen::VectorXd> above(outputs.size());
  for (std::size_t o = 0; o < outputs.size(); ++o)
    moments[o].resize(system.node(outputs[o]).output.estimate.dimension());
  const auto offset = [&](std::size_t o) {
    return difference(perturbation.value(outputs[o]),
                      system.node(outputs[o]).output.estimate.value);
  };
  for (const Source& source : perturbation.sources()) {
    bool inside = perturbation.apply(source, step);
    for (std::size_t o = 0; inside && o < outputs.size(); ++o) above[o] = offset(o);
    inside = inside && perturbation.apply(source, -step);
    if (!inside) {
      for (VerdictReport& report : reports) report.verdict = Verdict::invalid;
      return reports;
    }
    for (std::size_t o = 0; o < outputs.size(); ++o) {
      const Eigen::VectorXd below = offset(o);
      for (std::size_t c = 0; c < moments[o].size(); ++c) {
        const auto index = static_cast<Eigen::Index>(c);
        const double second = (above[o][index] + below[index]) / (step * step);
        const double secant = (above[o][index] - below[index]) / (2 * step);
        moments[o][c].curvature += second;
        moments[o][c].squared_curvature += second * second;
        moments[o][c].secant_variance += secant * secant;
      }
    }
  }
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const Estimate& estimate = system.node(outputs[o]).output.estimate;
    for (std::size_t c = 0; c < moments[o].size(); ++c) {
      const double variance = estimate.lineage.variance(c);
      const Verdict verdict = judge_component(moments[o][c], variance, std::abs(estimate.value[c]));
      reports[o].components.push_back(verdict);
      reports[o].verdict = std::max(reports[o].verdict, verdict);
      reports[o].bias.push_back(moments[o][c].curvature / 2);
      reports[o].extra_variance.push_back(moments[o][c].squared_curvature / 2);
    }
  }
  return reports;
}

}  // namespace ilss
