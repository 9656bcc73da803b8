#include "framework/semantics/verdict.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string>

#include "framework/estimate/random.h"

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

  /// Moves each source by its amount (standard deviations, in the order of `sources`) and redoes
  /// every function; false on a fault.
  bool apply(std::span<const double> amounts) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      NodeValues& node = nodes_[i];
      if (node.role == Role::moved) {
        move(system_.node(i).output.estimate, amounts, node.output.estimate);
      } else if (node.role == Role::redone) {
        move(system_.plan().nodes[i].parameters, amounts, node.parameters);
        if (!system_.try_function(i, node.parameters, node.inputs, node.output)) return false;
      }
    }
    return true;
  }

  /// The largest number of each unit among what is redone and moved: rounding is relative to it,
  /// not to what is left where large numbers cancel.
  std::map<std::string, double, std::less<>> sizes() const {
    std::map<std::string, double, std::less<>> result;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (nodes_[i].role == Role::unused) continue;
      const Estimate& estimate = system_.node(i).output.estimate;
      for (std::size_t c = 0; c < estimate.dimension(); ++c) {
        double& size = result[estimate.type->components[c].unit];
        size = std::max(size, std::abs(estimate.value[c]));
      }
    }
    return result;
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
  void move(const Estimate& from, std::span<const double> amounts, Estimate& to) const {
    to.value = from.value;
    auto at = sources_.begin();
    for (std::size_t k = 0; k < from.lineage.size(); ++k) {
      at = std::lower_bound(at, sources_.end(), from.lineage.sources()[k]);
      const double amount = amounts[static_cast<std::size_t>(at - sources_.begin())];
      if (amount == 0) continue;
      const auto column = from.lineage.column(k);
      for (std::size_t c = 0; c < column.size(); ++c) to.value[c] += amount * column[c];
    }
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
  double mixed_variance = 0;     ///< second-order variance of sources moving together

  double bias() const { return curvature / 2; }
  double extra_variance() const { return squared_curvature / 2 + mixed_variance; }
};

Verdict judge_component(const Moments& moments, double variance, double size) {
  const double bias = std::abs(moments.bias());
  const double extra = moments.extra_variance();
  // An error of rounding is no error.
  const double rounding = 1e-12 * size;
  if (bias <= rounding && std::sqrt(extra) <= rounding &&
      std::sqrt(std::abs(moments.secant_variance - variance)) <= rounding)
    return Verdict::linear_ok;
  const bool linear =
      bias <= largest_relative_bias * std::sqrt(variance) &&
      extra <= largest_relative_variance_change * variance &&
      std::abs(moments.secant_variance - variance) <= largest_relative_variance_change * variance;
  return linear ? Verdict::linear_ok : Verdict::second_order;
}

/// Moves sources and gathers what that does to every output component.
class Probe {
 public:
  Probe(const System& system, const std::vector<std::size_t>& cut)
      : system_(system), perturbation_(system, cut), amounts_(perturbation_.sources().size(), 0.0) {
    for (const std::size_t output : outputs()) {
      const std::size_t dimension = system.node(output).output.estimate.dimension();
      moments_.emplace_back(dimension);
      above_.emplace_back(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(dimension)));
    }
  }

  const std::vector<std::size_t>& outputs() const { return system_.plan().outputs; }
  const Moments& moments(std::size_t output, std::size_t component) const {
    return moments_[output][component];
  }
  std::map<std::string, double, std::less<>> sizes() const { return perturbation_.sizes(); }

  /// One source at a time, to both sides; false where that leads out of some function's domain.
  bool move_each() {
    const double step = std::sqrt(3.0);
    for (double& amount : amounts_) {
      const bool inside = move_both_ways([&](double sign) { amount = sign * step; });
      amount = 0;
      if (!inside) return false;
      for_each_component([&](Moments& m, double above, double below) {
        const double second = (above + below) / (step * step);
        const double secant = (above - below) / (2 * step);
        m.curvature += second;
        m.squared_curvature += second * second;
        m.secant_variance += secant * secant;
      });
    }
    return true;
  }

  /// All sources at once by ±1 standard deviation, signs drawn: with second derivatives H, the mean
  /// of both ways is tr(H) / 2 + sum of s_i s_j H_ij over i < j, so its scatter is the mixed part.
  bool move_together() {
    constexpr int draws = 24;
    if (amounts_.size() < 2) return true;
    RandomBits random(0);
    std::vector<double> signs(amounts_.size());
    for (int d = 0; d < draws; ++d) {
      for (double& sign : signs) sign = (random() & 1) != 0 ? 1.0 : -1.0;
      const bool inside = move_both_ways([&](double sign) {
        for (std::size_t k = 0; k < signs.size(); ++k) amounts_[k] = sign * signs[k];
      });
      if (!inside) return false;
      for_each_component([&](Moments& m, double above, double below) {
        const double mixed = (above + below) / 2 - m.bias();
        m.mixed_variance += mixed * mixed / draws;
      });
    }
    return true;
  }

 private:
  Eigen::VectorXd offset(std::size_t o) const {
    return difference(perturbation_.value(outputs()[o]),
                      system_.node(outputs()[o]).output.estimate.value);
  }
  template <typename SetAmounts>
  bool move_both_ways(const SetAmounts& set_amounts) {
    set_amounts(1.0);
    if (!perturbation_.apply(amounts_)) return false;
    for (std::size_t o = 0; o < above_.size(); ++o) above_[o] = offset(o);
    set_amounts(-1.0);
    return perturbation_.apply(amounts_);
  }
  template <typename Gather>
  void for_each_component(const Gather& gather) {
    for (std::size_t o = 0; o < above_.size(); ++o) {
      const Eigen::VectorXd below = offset(o);
      for (std::size_t c = 0; c < moments_[o].size(); ++c)
        gather(moments_[o][c], above_[o][static_cast<Eigen::Index>(c)],
               below[static_cast<Eigen::Index>(c)]);
    }
  }

  const System& system_;
  Perturbation perturbation_;
  std::vector<double> amounts_;
  std::vector<std::vector<Moments>> moments_;
  std::vector<Eigen::VectorXd> above_;
};

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
  Probe probe(system, cut);
  std::vector<VerdictReport> reports(probe.outputs().size());
  if (!probe.move_each() || !probe.move_together()) {
    for (VerdictReport& report : reports) report.verdict = Verdict::invalid;
    return reports;
  }
  const auto sizes = probe.sizes();
  for (std::size_t o = 0; o < reports.size(); ++o) {
    const Estimate& estimate = system.node(probe.outputs()[o]).output.estimate;
    for (std::size_t c = 0; c < estimate.dimension(); ++c) {
      const Moments& moments = probe.moments(o, c);
      const Verdict verdict = judge_component(moments, estimate.lineage.variance(c),
                                              sizes.at(estimate.type->components[c].unit));
      reports[o].components.push_back(verdict);
      reports[o].verdict = std::max(reports[o].verdict, verdict);
      reports[o].bias.push_back(moments.bias());
      reports[o].extra_variance.push_back(moments.extra_variance());
    }
  }
  return reports;
}

}  // namespace ilss
