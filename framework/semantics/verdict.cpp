#include "framework/semantics/verdict.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string>

#include "framework/estimate/random.h"

namespace ilss {
namespace {

/// How far sources are moved in search of another label (standard deviations).
constexpr double label_distance = 2.5;

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
  /// every function.
  void apply(std::span<const double> amounts) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      NodeValues& node = nodes_[i];
      if (node.role == Role::moved)
        move(system_.node(i).output.estimate, amounts, node.output.estimate);
      else if (node.role == Role::redone)
        redo(i, amounts);
    }
  }

  /// Whether the last move led out of the domain of a function that the node follows from, and
  /// what that function said.
  bool failed(std::size_t node) const { return nodes_[node].failed; }
  const std::string& fault(std::size_t node) const { return nodes_[node].fault; }
  /// Whether it changed a label on the way to the node: another case of a formula.
  bool changed_label(std::size_t node) const { return nodes_[node].changed_label; }

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
    bool failed = false;
    std::string fault;
    bool changed_label = false;
  };

  void redo(std::size_t i, std::span<const double> amounts) {
    NodeValues& node = nodes_[i];
    const PlanNode& plan_node = system_.plan().nodes[i];
    node.failed = false;
    node.changed_label = false;
    for (const PlanInput& input : plan_node.inputs) {
      const NodeValues& producer = nodes_[input.node];
      if (producer.failed && !node.failed) node.fault = producer.fault;
      node.failed |= producer.failed;
      node.changed_label |= producer.changed_label;
    }
    if (node.failed) return;
    move(plan_node.parameters, amounts, node.parameters);
    const Outcome<> outcome = system_.try_function(i, node.parameters, node.inputs, node.output);
    node.failed = !outcome.has_output();
    if (outcome.is_fault())
      node.fault = fmt::format("'{}': {}", plan_node.name, outcome.fault().message);
    node.changed_label |= node.output.estimate.labels != system_.node(i).output.estimate.labels;
  }

  void prepare(std::size_t i) {
    NodeValues& node = nodes_[i];
    if (node.role == Role::unused) return;
    if (!system_.node(i).outcome.has_output()) {
      node.role = Role::unused;
      node.failed = true;
      return;
    }
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

/// Sums over sources of what moving each does to an output along one direction.
struct Moments {
  double curvature = 0;          ///< of second differences
  double squared_curvature = 0;  ///< of their squares
  double secant_variance = 0;    ///< of squared central differences
  double mixed_variance = 0;     ///< second-order variance of sources moving together

  double bias() const { return curvature / 2; }
  double extra_variance() const { return squared_curvature / 2 + mixed_variance; }
};

Verdict judge_direction(const Moments& moments, double variance, double size) {
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

/// The directions in which an output's error is judged, as rows: its components, and the principal
/// axes of its covariance scaled to unit variance. Components alone would hide what happens across
/// a thin error ellipse.
Eigen::MatrixXd directions_of(const Estimate& estimate) {
  const auto m = static_cast<Eigen::Index>(estimate.dimension());
  const Eigen::MatrixXd covariance = estimate.lineage.covariance();
  const Eigen::VectorXd inverse_scale = covariance.diagonal().unaryExpr(
      [](double variance) { return variance > 0 ? 1 / std::sqrt(variance) : 0.0; });
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      inverse_scale.asDiagonal() * covariance * inverse_scale.asDiagonal());
  constexpr double rank_tolerance = 1e-10;
  Eigen::MatrixXd directions = Eigen::MatrixXd::Identity(m, m);
  for (Eigen::Index i = 0; m > 1 && i < m; ++i) {
    const double eigenvalue = eigen.eigenvalues()[i];
    if (eigenvalue <= rank_tolerance * static_cast<double>(m)) continue;
    directions.conservativeResize(directions.rows() + 1, Eigen::NoChange);
    directions.bottomRows(1) =
        eigen.eigenvectors().col(i).cwiseProduct(inverse_scale).transpose() / std::sqrt(eigenvalue);
  }
  return directions;
}

/// What is known of one output after all moves.
struct ProbedOutput {
  std::size_t node;
  Eigen::MatrixXd directions;
  std::vector<Moments> moments;  ///< of each direction
  Eigen::VectorXd above;         ///< offsets along the directions when moved to the one side
  bool inside = true;            ///< no move led out of a function's domain
  std::string reason = {};       ///< the first one that did
  bool changes_label = false;
};

/// Moves sources and gathers what that does to every output.
class Probe {
 public:
  Probe(const System& system, const std::vector<std::size_t>& cut)
      : system_(system), perturbation_(system, cut), amounts_(perturbation_.sources().size(), 0.0) {
    for (const std::size_t node : system.plan().outputs) {
      ProbedOutput& output = outputs_.emplace_back();
      output.node = node;
      output.inside = system.node(node).outcome.has_output();
      if (!output.inside) continue;
      output.directions = directions_of(system.node(node).output.estimate);
      output.moments.resize(static_cast<std::size_t>(output.directions.rows()));
    }
  }

  const std::vector<ProbedOutput>& outputs() const { return outputs_; }
  std::map<std::string, double, std::less<>> sizes() const { return perturbation_.sizes(); }

  /// One source at a time, to both sides.
  void move_each() {
    const double step = std::sqrt(3.0);
    for (std::size_t k = 0; k < amounts_.size(); ++k) {
      // Given outputs may bring sources of owners that the plan does not list.
      const SourceOwners& owners = system_.plan().owners;
      const std::uint32_t owner = perturbation_.sources()[k].owner;
      const std::string name = owner < owners.size() ? owners[owner].name : "a given source";
      move_both_ways([&](double sign) { amounts_[k] = sign * step; },
                     fmt::format("an error of {} of 1.7 standard deviations", name));
      for_each_direction([&](Moments& m, double above, double below) {
        const double second = (above + below) / (step * step);
        const double secant = (above - below) / (2 * step);
        m.curvature += second;
        m.squared_curvature += second * second;
        m.secant_variance += secant * secant;
      });
      watch_labels([&](double sign) { amounts_[k] = sign * label_distance; });
      amounts_[k] = 0;
    }
  }

  /// All sources at once by ±1 standard deviation, signs drawn: with second derivatives H, the mean
  /// of both ways is tr(H) / 2 + sum of s_i s_j H_ij over i < j, so its scatter is the mixed part.
  void move_together() {
    constexpr int draws = 24;
    if (amounts_.size() < 2) return;
    RandomBits random(0);
    std::vector<double> signs(amounts_.size());
    const double to_label_distance = label_distance / std::sqrt(static_cast<double>(signs.size()));
    const auto set_all = [&](double factor) {
      for (std::size_t k = 0; k < signs.size(); ++k) amounts_[k] = factor * signs[k];
    };
    for (int d = 0; d < draws; ++d) {
      for (double& sign : signs) sign = (random() & 1) != 0 ? 1.0 : -1.0;
      move_both_ways(set_all, "an error of one standard deviation of each source");
      for_each_direction([&](Moments& m, double above, double below) {
        const double mixed = (above + below) / 2 - m.bias();
        m.mixed_variance += mixed * mixed / draws;
      });
      watch_labels([&](double sign) { set_all(sign * to_label_distance); });
    }
  }

 private:
  Eigen::VectorXd offset(const ProbedOutput& output) const {
    return output.directions * difference(perturbation_.value(output.node),
                                          system_.node(output.node).output.estimate.value);
  }
  void note_failures(const std::string& move) {
    for (ProbedOutput& output : outputs_) {
      if (!output.inside || !perturbation_.failed(output.node)) continue;
      output.inside = false;
      output.reason =
          fmt::format("{} leaves no answer: {}", move, perturbation_.fault(output.node));
    }
  }
  template <typename SetAmounts>
  void move_both_ways(const SetAmounts& set_amounts, const std::string& move) {
    set_amounts(1.0);
    perturbation_.apply(amounts_);
    note_failures(move);
    for (ProbedOutput& output : outputs_)
      if (output.inside) output.above = offset(output);
    set_amounts(-1.0);
    perturbation_.apply(amounts_);
    note_failures(move);
  }
  template <typename Gather>
  void for_each_direction(const Gather& gather) {
    for (ProbedOutput& output : outputs_) {
      if (!output.inside) continue;
      const Eigen::VectorXd below = offset(output);
      for (std::size_t r = 0; r < output.moments.size(); ++r)
        gather(output.moments[r], output.above[static_cast<Eigen::Index>(r)],
               below[static_cast<Eigen::Index>(r)]);
    }
  }
  /// A change of label within reach is a kink, which moments may miss; a fault there is not judged.
  template <typename SetAmounts>
  void watch_labels(const SetAmounts& set_amounts) {
    for (const double sign : {1.0, -1.0}) {
      set_amounts(sign);
      perturbation_.apply(amounts_);
      for (ProbedOutput& output : outputs_)
        if (output.inside && !perturbation_.failed(output.node))
          output.changes_label |= perturbation_.changed_label(output.node);
    }
  }

  const System& system_;
  Perturbation perturbation_;
  std::vector<double> amounts_;
  std::vector<ProbedOutput> outputs_;
};

VerdictReport report_of(const ProbedOutput& output, const Estimate& estimate,
                        const std::map<std::string, double, std::less<>>& sizes) {
  VerdictReport report;
  if (!output.inside) {
    report.verdict = Verdict::invalid;
    report.reason = output.reason;
    return report;
  }
  const std::size_t components = estimate.dimension();
  for (std::size_t r = 0; r < output.moments.size(); ++r) {
    const Moments& moments = output.moments[r];
    if (r >= components) {  // a principal axis, of unit variance
      if (judge_direction(moments, 1.0, 0.0) == Verdict::linear_ok) continue;
      if (report.verdict == Verdict::linear_ok)
        report.reason = "the components' errors together are not as their covariance says";
      report.verdict = std::max(report.verdict, Verdict::second_order);
      continue;
    }
    const Verdict verdict = judge_direction(moments, estimate.lineage.variance(r),
                                            sizes.at(estimate.type->components[r].unit));
    report.components.push_back(verdict);
    report.verdict = std::max(report.verdict, verdict);
    report.bias.push_back(moments.bias());
    report.extra_variance.push_back(moments.extra_variance());
  }
  if (output.changes_label) {
    report.verdict = std::max(report.verdict, Verdict::second_order);
    report.reason = "another case is within 2.5 standard deviations";
  }
  return report;
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
  Probe probe(system, cut);
  probe.move_each();
  probe.move_together();
  const auto sizes = probe.sizes();
  std::vector<VerdictReport> reports;
  for (const ProbedOutput& output : probe.outputs())
    reports.push_back(report_of(output, system.node(output.node).output.estimate, sizes));
  return reports;
}

}  // namespace ilss
