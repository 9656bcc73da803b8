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

/// Of the pilot's trials: the same system always gets the same verdict.
constexpr std::uint64_t pilot_seed = 0;
/// What counts for rounding, against the numbers that an output is made of.
constexpr double relative_rounding = 1e-12;
/// With more sources than this, not every pair is moved.
constexpr std::size_t most_paired_sources = 12;

/// Sums over sources of what moving each does to an output along one direction.
struct Moments {
  double curvature = 0;          ///< of second differences
  double squared_curvature = 0;  ///< of their squares
  double secant_variance = 0;    ///< of squared central differences
  double mixed_variance = 0;     ///< second-order variance of sources moving together

  double bias() const { return curvature / 2; }
  double second_order_variance() const { return squared_curvature / 2 + mixed_variance; }
};

/// Whether the second order is small along a direction. `size` is of the numbers that make it up:
/// an error of their rounding is no error.
bool is_clear(const Moments& moments, double variance, double size) {
  const double bias = std::abs(moments.bias());
  const double extra = moments.second_order_variance();
  const double change = std::abs(moments.secant_variance - variance);
  const double rounding = relative_rounding * size;
  if (bias <= rounding && std::sqrt(extra) <= rounding && std::sqrt(change) <= rounding)
    return true;
  return bias <= clear_relative_bias * std::sqrt(variance) &&
         extra <= clear_relative_variance * variance &&
         change <= clear_relative_variance * variance;
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

  /// One source at a time, to both sides.
  void move_each() {
    const double step = std::sqrt(3.0);
    for (double& error : errors_) {
      error = step;
      const Offsets above = offsets();
      error = -step;
      const Offsets below = offsets();
      for_each_direction([&](Moments& m, std::size_t o, Eigen::Index r) {
        const double second = (above[o][r] + below[o][r]) / (step * step);
        const double secant = (above[o][r] - below[o][r]) / (2 * step);
        m.curvature += second;
        m.squared_curvature += second * second;
        m.secant_variance += secant * secant;
      });
      error = 0;
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

/// The largest spread that is but rounding, of a component.
double rounding_of(const Estimate& estimate, std::size_t component, const Sizes& sizes) {
  return relative_rounding * sizes.at(estimate.type->components[component].unit);
}

/// How far the trials of a look may be from what first order states.
struct Tolerances {
  double coverage;   ///< of the share inside an interval or ellipsoid
  double mean;       ///< in standard deviations
  double deviation;  ///< relative
};
/// Three standard deviations of what as many trials scatter, if all is as stated.
constexpr Tolerances glance_tolerances{0.029, 0.135, 0.095};
constexpr Tolerances pilot_tolerances{pilot_tolerance, 0.5, 0.3};

/// Judges one output by its second order and by trials.
class Judgement {
 public:
  Judgement(const ProbedOutput& output, const Estimate& estimate, const Sizes& sizes,
            bool states_no_error)
      : output_(output), estimate_(estimate), sizes_(sizes), judged_(!states_no_error) {
    judged_ &= output.there;
    if (!output.there) report_.verdict = Verdict::invalid;
    if (!judged_) return;
    for (std::size_t r = 0; r < output.moments.size(); ++r) {
      const Moments& moments = output.moments[r];
      const bool is_component = r < estimate.dimension();
      const double variance = is_component ? estimate.lineage.variance(r) : 1.0;
      const double size = is_component ? sizes.at(estimate.type->components[r].unit) : 0.0;
      const bool negligible = is_component && is_negligible(moments, r, variance);
      const bool clear = negligible || is_clear(moments, variance, size);
      clear_ &= clear;
      if (!is_component) continue;
      clear_component_.push_back(clear);
      negligible_.push_back(negligible);
      report_.components.push_back(Verdict::linear_ok);
      report_.bias.push_back(moments.bias());
      report_.extra_variance.push_back(moments.second_order_variance() + moments.secant_variance -
                                       variance);
    }
  }

  /// Whether more than a glance is needed.
  bool doubtful(const MonteCarloOutput& glance) const {
    if (!judged_) return false;
    if (!clear_ || output_.meets_fault || glance.faults > 0) return true;
    for (std::size_t c = 0; c < estimate_.dimension(); ++c)
      if (!negligible_[c] && !holds(c, glance, glance_tolerances)) return true;
    return !holds_together(glance, glance_tolerances.coverage);
  }

  /// Decides by many trials.
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
      if (report_.components[c] == Verdict::monte_carlo_required && clear_component_[c])
        report_.reason = "the error is not a normal one, though its second order is small";
    }
    if (report_.verdict != Verdict::linear_ok || holds_together(pilot, pilot_tolerance)) return;
    report_.verdict = Verdict::second_order;
    report_.reason = output_.changes_label
                         ? "another case is near, and the components' errors together are not as "
                           "their covariance says"
                         : "the components' errors together are not as their covariance says";
  }

  /// An output without sources of error that no move or trial changes, such as a count, leaves
  /// nothing to correct.
  VerdictReport report() && {
    if (judged_ && report_.verdict == Verdict::linear_ok && estimate_.lineage.empty() && still())
      return {.verdict = Verdict::linear_ok, .piloted = report_.piloted};
    return std::move(report_);
  }

 private:
  static bool near(double coverage, double tolerance) {
    return std::isnan(coverage) || std::abs(coverage - 0.95) <= tolerance;
  }

  /// Whether a component's trials are as first order states.
  bool holds(std::size_t c, const MonteCarloOutput& look, const Tolerances& tolerances) const {
    const auto i = static_cast<Eigen::Index>(c);
    const double stated = estimate_.lineage.standard_deviation(c);
    const double drawn = std::sqrt(look.covariance(i, i));
    const double bias = difference(
        *estimate_.type, std::span(look.mean.data(), estimate_.dimension()), estimate_.value)[i];
    if (std::max({drawn, stated, std::abs(bias)}) <= rounding_of(estimate_, c, sizes_)) return true;
    return stated > 0 && near(look.coverage[c], tolerances.coverage) &&
           std::abs(bias) <= tolerances.mean * stated &&
           std::abs(drawn - stated) <= tolerances.deviation * stated;
  }

  /// Whether the ellipsoid holds what it should; one that is thin by rounding says nothing.
  bool holds_together(const MonteCarloOutput& look, double tolerance) const {
    for (std::size_t c = 0; c < estimate_.dimension(); ++c) {
      const double stated = estimate_.lineage.standard_deviation(c);
      if (stated > 0 && stated <= rounding_of(estimate_, c, sizes_)) return true;
    }
    return near(look.joint_coverage, tolerance);
  }

  /// Pure numbers have no unit that would make them comparable.
  bool is_negligible(const Moments& moments, std::size_t component, double variance) const {
    const std::string& unit = estimate_.type->components[component].unit;
    if (unit == "1") return false;
    double largest = 0;
    for (std::size_t c = 0; c < estimate_.dimension(); ++c)
      if (estimate_.type->components[c].unit == unit)
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
    if (!clear_component_[c] && second_order > variance) return Verdict::monte_carlo_required;
    if (holds(c, pilot, pilot_tolerances)) return Verdict::linear_ok;
    if (variance <= 0 || variance + report_.extra_variance[c] <= 0)
      return Verdict::monte_carlo_required;
    const double corrected = std::sqrt(variance + report_.extra_variance[c]);
    const auto i = static_cast<Eigen::Index>(c);
    const bool as_corrected =
        near(pilot.coverage_around(c, report_.bias[c], corrected), 2 * pilot_tolerance) &&
        std::abs(std::sqrt(pilot.covariance(i, i)) - corrected) <=
            pilot_tolerances.deviation * corrected;
    return as_corrected ? Verdict::second_order : Verdict::monte_carlo_required;
  }

  /// Whether no component's second order says anything.
  bool still() const {
    for (std::size_t c = 0; c < estimate_.dimension(); ++c)
      if (report_.bias[c] != 0 || report_.extra_variance[c] != 0) return false;
    return true;
  }

  const ProbedOutput& output_;
  const Estimate& estimate_;
  const Sizes& sizes_;
  bool judged_;
  bool clear_ = true;  ///< of all directions
  std::vector<bool> clear_component_;
  std::vector<bool> negligible_;
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
  const auto glance = run_monte_carlo(system, perturbation, glance_trials, pilot_seed);
  std::vector<bool> doubtful;
  doubtful.reserve(judgements.size());
  for (std::size_t o = 0; o < judgements.size(); ++o)
    doubtful.push_back(judgements[o].doubtful(glance[o]));
  if (std::find(doubtful.begin(), doubtful.end(), true) != doubtful.end()) {
    const auto pilot = run_monte_carlo(system, perturbation, pilot_trials, pilot_seed);
    for (std::size_t o = 0; o < judgements.size(); ++o)
      if (doubtful[o]) judgements[o].take_pilot(pilot[o]);
  }
  std::vector<VerdictReport> reports;
  reports.reserve(judgements.size());
  for (Judgement& judgement : judgements) reports.push_back(std::move(judgement).report());
  return reports;
}

}  // namespace ilss
