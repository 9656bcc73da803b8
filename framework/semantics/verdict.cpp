#include "framework/semantics/verdict.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "framework/estimate/random.h"
#include "framework/semantics/monte_carlo.h"

namespace ilss {
namespace {

/// How far sources are moved in search of another label or a fault (standard deviations).
constexpr double search_distance = 3.0;
/// Of the pilot's trials: the same system always gets the same verdict.
constexpr std::uint64_t pilot_seed = 0;
/// With more sources than this, not every pair is moved.
constexpr std::size_t most_paired_sources = 12;

/// Sums over sources of what moving each does to an output along one direction.
struct Moments {
  double curvature = 0;          ///< of second differences
  double squared_curvature = 0;  ///< of their squares
  double secant_variance = 0;    ///< of squared central differences
  double mixed_variance = 0;     ///< second-order variance of sources moving together
  double excess_kurtosis = 0;    ///< of fourth powers of central differences by their laws'

  double bias() const { return curvature / 2; }
  double second_order_variance() const { return squared_curvature / 2 + mixed_variance; }
};

/// Whether first order holds along a direction beyond doubt. `size` is of the numbers that make it
/// up: an error of their rounding is no error.
bool is_clear(const Moments& moments, double variance, double size) {
  const double bias = std::abs(moments.bias());
  const double extra = moments.second_order_variance();
  const double change = std::abs(moments.secant_variance - variance);
  const double rounding = 1e-12 * size;
  if (bias <= rounding && std::sqrt(extra) <= rounding && std::sqrt(change) <= rounding)
    return std::abs(moments.excess_kurtosis) <= clear_excess_kurtosis * variance * variance;
  return bias <= clear_relative_bias * std::sqrt(variance) &&
         extra <= clear_relative_variance * variance &&
         change <= clear_relative_variance * variance &&
         std::abs(moments.excess_kurtosis) <= clear_excess_kurtosis * variance * variance;
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
  bool there = false;
  Eigen::MatrixXd directions = {};
  std::vector<Moments> moments = {};  ///< of each direction
  bool meets_fault = false;           ///< a move led out of a function's domain
  bool changes_label = false;
};

/// Moves sources and gathers what that does to every output.
class Probe {
 public:
  Probe(const System& system, Perturbation& perturbation)
      : system_(system), perturbation_(perturbation), errors_(perturbation.sources().size(), 0.0) {
    for (const std::size_t node : system.plan().outputs) {
      ProbedOutput& output = outputs_.emplace_back();
      output.node = node;
      output.there = system.node(node).outcome.has_output();
      if (!output.there) continue;
      output.directions = directions_of(system.node(node).output.estimate);
      output.moments.resize(static_cast<std::size_t>(output.directions.rows()));
    }
    move_each();
    if (errors_.size() <= most_paired_sources)
      move_pairs();
    else
      move_together();
  }

  const std::vector<ProbedOutput>& outputs() const { return outputs_; }

 private:
  using Offsets = std::vector<Eigen::VectorXd>;  ///< along the directions, of each output

  /// What the errors as they stand do to each output; noted where they leave none.
  Offsets offsets() {
    perturbation_.apply(errors_);
    Offsets result;
    for (ProbedOutput& output : outputs_) {
      Eigen::VectorXd& offset =
          result.emplace_back(Eigen::VectorXd::Zero(output.directions.rows()));
      if (!output.there) continue;
      if (perturbation_.failed(output.node)) {
        output.meets_fault = true;
        continue;
      }
      output.changes_label |= perturbation_.changed_label(output.node);
      offset = output.directions * difference(perturbation_.value(output.node),
                                              system_.node(output.node).output.estimate.value);
    }
    return result;
  }

  template <typename Gather>
  void for_each_direction(const Gather& gather) {
    for (std::size_t o = 0; o < outputs_.size(); ++o)
      for (std::size_t r = 0; r < outputs_[o].moments.size(); ++r)
        gather(outputs_[o].moments[r], o, static_cast<Eigen::Index>(r));
  }

  double excess_kurtosis(std::size_t k) const {
    const SourceOwners& owners = system_.plan().owners;
    const std::uint32_t owner = perturbation_.sources()[k].owner;
    return owner < owners.size() ? owners[owner].distribution.excess_kurtosis() : 0.0;
  }

  /// One source at a time, to both sides.
  void move_each() {
    const double step = std::sqrt(3.0);
    for (std::size_t k = 0; k < errors_.size(); ++k) {
      errors_[k] = step;
      const Offsets above = offsets();
      errors_[k] = -step;
      const Offsets below = offsets();
      const double kurtosis = excess_kurtosis(k);
      for_each_direction([&](Moments& m, std::size_t o, Eigen::Index r) {
        const double second = (above[o][r] + below[o][r]) / (step * step);
        const double secant = (above[o][r] - below[o][r]) / (2 * step);
        m.curvature += second;
        m.squared_curvature += second * second;
        m.secant_variance += secant * secant;
        m.excess_kurtosis += kurtosis * secant * secant * secant * secant;
      });
      for (const double distance : {search_distance, -search_distance}) {
        errors_[k] = distance;
        offsets();
      }
      errors_[k] = 0;
    }
  }

  /// Two sources at a time, by ±1 standard deviation: their mixed second derivatives.
  void move_pairs() {
    const auto offsets_at = [&](std::size_t i, double a, std::size_t j, double b) {
      errors_[i] = a;
      errors_[j] = b;
      return offsets();
    };
    for (std::size_t i = 0; i < errors_.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const Offsets both = offsets_at(i, 1, j, 1);
        const Offsets neither = offsets_at(i, -1, j, -1);
        const Offsets first = offsets_at(i, 1, j, -1);
        const Offsets second = offsets_at(i, -1, j, 1);
        for_each_direction([&](Moments& m, std::size_t o, Eigen::Index r) {
          const double mixed = (both[o][r] + neither[o][r] - first[o][r] - second[o][r]) / 4;
          m.mixed_variance += mixed * mixed;
        });
        errors_[i] = errors_[j] = 0;
      }
  }

  /// All sources at once by ±1 standard deviation, signs drawn: with second derivatives H, the mean
  /// of both ways is tr(H) / 2 + sum of s_i s_j H_ij over i < j, so its scatter is the mixed part.
  void move_together() {
    constexpr int draws = 48;
    RandomBits random(0);
    std::vector<double> signs(errors_.size());
    const double to_distance = search_distance / std::sqrt(static_cast<double>(signs.size()));
    const auto offsets_at = [&](double factor) {
      for (std::size_t k = 0; k < signs.size(); ++k) errors_[k] = factor * signs[k];
      return offsets();
    };
    for (int d = 0; d < draws; ++d) {
      for (double& sign : signs) sign = (random() & 1) != 0 ? 1.0 : -1.0;
      const Offsets above = offsets_at(1);
      const Offsets below = offsets_at(-1);
      for_each_direction([&](Moments& m, std::size_t o, Eigen::Index r) {
        const double mixed = (above[o][r] + below[o][r]) / 2 - m.bias();
        m.mixed_variance += mixed * mixed / draws;
      });
      offsets_at(to_distance);
      offsets_at(-to_distance);
    }
  }

  const System& system_;
  Perturbation& perturbation_;
  std::vector<double> errors_;
  std::vector<ProbedOutput> outputs_;
};

/// The largest number of each unit among the nodes that outputs follow from: rounding is relative
/// to it, not to what is left where large numbers cancel.
using Sizes = std::map<std::string, double, std::less<>>;
Sizes sizes_of(const System& system, const Perturbation& perturbation) {
  Sizes result;
  const auto take = [&](const Estimate& estimate) {
    for (std::size_t c = 0; c < estimate.dimension(); ++c) {
      double& size = result[estimate.type->components[c].unit];
      size = std::max(size, std::abs(estimate.value[c]));
    }
  };
  for (const std::size_t node : perturbation.nodes()) {
    take(system.node(node).output.estimate);
    take(system.plan().nodes[node].parameters);
  }
  return result;
}

/// Whether the pilot's share inside an interval is what it should be.
bool holds(double coverage, double tolerance) {
  return std::isnan(coverage) || std::abs(coverage - 0.95) <= tolerance;
}

/// Judges one output by what was seen of it; without a pilot, whether one is needed.
class Judgement {
 public:
  Judgement(const ProbedOutput& output, const Estimate& estimate, const Sizes& sizes,
            bool states_no_error)
      : output_(output), estimate_(estimate) {
    if (!output.there) {
      report_.verdict = Verdict::invalid;
      return;
    }
    if (states_no_error) return;
    doubtful_ = output.meets_fault || output.changes_label;
    for (std::size_t r = 0; r < output.moments.size(); ++r) {
      const Moments& moments = output.moments[r];
      const bool is_component = r < estimate.dimension();
      const double variance = is_component ? estimate.lineage.variance(r) : 1.0;
      const double size = is_component ? sizes.at(estimate.type->components[r].unit) : 0.0;
      const bool negligible = is_component && is_negligible(moments, r, variance);
      const bool clear = negligible || is_clear(moments, variance, size);
      doubtful_ |= !clear;
      if (!is_component) continue;
      clear_.push_back(clear);
      negligible_.push_back(negligible);
      report_.components.push_back(Verdict::linear_ok);
      report_.bias.push_back(moments.bias());
      report_.extra_variance.push_back(moments.second_order_variance() + moments.secant_variance -
                                       variance);
    }
  }

  bool doubtful() const { return doubtful_; }

  /// Decides by trials.
  void take_pilot(const MonteCarloOutput& pilot) {
    report_.piloted = true;
    const auto trials = static_cast<double>(pilot.trials + pilot.faults);
    const double fault_share = static_cast<double>(pilot.faults) / trials;
    if (pilot.trials == 0 || fault_share > largest_fault_share) {
      report_.verdict = Verdict::invalid;
      report_.reason =
          fmt::format("{:.2g} % of all errors leave no answer: {}", 100 * fault_share, pilot.fault);
      return;
    }
    for (std::size_t c = 0; c < estimate_.dimension(); ++c) {
      report_.components[c] = judge_component(c, pilot);
      report_.verdict = std::max(report_.verdict, report_.components[c]);
    }
    if (report_.verdict == Verdict::monte_carlo_required) explain_required();
    if (report_.verdict != Verdict::linear_ok || holds(pilot.joint_coverage, pilot_tolerance))
      return;
    report_.verdict = Verdict::second_order;
    report_.reason = output_.changes_label
                         ? "another case is near, and the components' errors together are not as "
                           "their covariance says"
                         : "the components' errors together are not as their covariance says";
  }

  VerdictReport report() && { return std::move(report_); }

 private:
  /// Where it is not curvature, it is the law of a source.
  void explain_required() {
    for (std::size_t c = 0; c < report_.components.size(); ++c) {
      const double variance = estimate_.lineage.variance(c);
      const bool unlike_normal = std::abs(output_.moments[c].excess_kurtosis) >
                                 clear_excess_kurtosis * variance * variance;
      if (report_.components[c] == Verdict::monte_carlo_required && unlike_normal)
        report_.reason = "sources whose law is not normal make most of the error";
    }
  }

  bool is_negligible(const Moments& moments, std::size_t component, double variance) const {
    double largest = 0;
    for (std::size_t c = 0; c < estimate_.dimension(); ++c)
      if (estimate_.type->components[c].unit == estimate_.type->components[component].unit)
        largest = std::max(largest, estimate_.lineage.variance(c));
    const double bias = moments.bias();
    return std::max(variance, moments.secant_variance) + moments.second_order_variance() +
               bias * bias <=
           negligible_error * negligible_error * largest;
  }

  Verdict judge_component(std::size_t c, const MonteCarloOutput& pilot) const {
    const double variance = estimate_.lineage.variance(c);
    const double second_order = output_.moments[c].second_order_variance();
    if (negligible_[c]) return Verdict::linear_ok;
    if (!clear_[c] && second_order > variance) return Verdict::monte_carlo_required;
    if (holds(pilot.coverage[c], pilot_tolerance)) return Verdict::linear_ok;
    const double corrected = variance + report_.extra_variance[c];
    const double miss =
        corrected > 0
            ? std::abs(pilot.coverage_around(c, report_.bias[c], std::sqrt(corrected)) - 0.95)
            : 1.0;
    return miss <= 2 * pilot_tolerance ? Verdict::second_order : Verdict::monte_carlo_required;
  }

  const ProbedOutput& output_;
  const Estimate& estimate_;
  std::vector<bool> clear_;
  std::vector<bool> negligible_;
  bool doubtful_ = false;
  VerdictReport report_;
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
  Perturbation perturbation(system, cut, Redo::functions);
  const Probe probe(system, perturbation);
  const Sizes sizes = sizes_of(system, perturbation);
  std::vector<Judgement> judgements;
  judgements.reserve(probe.outputs().size());
  for (const ProbedOutput& output : probe.outputs())
    judgements.emplace_back(output, system.node(output.node).output.estimate, sizes,
                            system.plan().nodes[output.node].type->states_no_error);
  const bool doubt = std::any_of(judgements.begin(), judgements.end(),
                                 [](const Judgement& judgement) { return judgement.doubtful(); });
  if (doubt) {
    const auto pilot = run_monte_carlo(system, perturbation, pilot_trials, pilot_seed);
    for (std::size_t o = 0; o < judgements.size(); ++o)
      if (judgements[o].doubtful()) judgements[o].take_pilot(pilot[o]);
  }
  std::vector<VerdictReport> reports;
  reports.reserve(judgements.size());
  for (Judgement& judgement : judgements) reports.push_back(std::move(judgement).report());
  return reports;
}

}  // namespace ilss
