// Monte Carlo over a graph: every source of error drawn from its own distribution.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "framework/estimate/consistency.h"
#include "framework/semantics/perturbation.h"

namespace ilss {

/// How to run it. Nothing depends on the number of threads.
struct MonteCarloOptions {
  std::size_t trials = 1'000'000;  ///< from 1 to `most_trials`
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core
  /// Told now and then, on the calling thread, which part is done; may be empty.
  std::function<void(double)> progress = {};
};
inline constexpr std::size_t most_trials = 10'000'000;

/// What one output was over all trials that gave one (SI units). Empty vectors where none did.
struct MonteCarloOutput {
  std::size_t trials = 0;  ///< that gave an output
  std::size_t faults = 0;  ///< that gave none
  std::string fault = {};  ///< what the first of these said
  Eigen::VectorXd mean = {};
  Eigen::MatrixXd covariance = {};
  /// The shortest that holds 95 %, a component: the first-order value and the offsets from it.
  std::vector<Interval> interval = {};
  /// Share of trials within 1.96 first-order standard deviations of the first-order value, a
  /// component; honest: 0.95. NaN where the first-order error is 0.
  std::vector<double> coverage = {};
  /// Share within the 95 % ellipsoid of the first-order covariance; NaN where that is 0.
  double joint_coverage = 0;
  /// To how many digits (2, 1 or 0) of the standard uncertainty the first-order 95 % interval is
  /// that of Monte Carlo, a component (JCGM 101:2008, clause 8).
  std::vector<int> agreeing_digits = {};
  /// Each trial's offset from the first-order value (⊖), a component; in no order.
  std::vector<std::vector<double>> offsets = {};

  /// Share of trials within 1.96 `deviation` of the first-order value plus `bias`.
  double coverage_around(std::size_t component, double bias, double deviation) const;
};

/// Draws the sources of a system as it stands after an expectation, and evaluates the plan again
/// for each trial: one entry an output of the plan. Simulated sensors and the estimators behind
/// them take part: their readings are drawn anew. What a source draws in a trial follows from the
/// seed, the source's name and the trial. `cut` as in Perturbation. Costs 8 bytes a trial and
/// component. @throws std::invalid_argument on a number of trials out of range.
std::vector<MonteCarloOutput> run_monte_carlo(const System& system,
                                              const std::vector<std::size_t>& cut,
                                              const MonteCarloOptions& options);

/// The same from a perturbation that is there already, whose targets are the plan's outputs, in
/// this thread.
std::vector<MonteCarloOutput> run_monte_carlo(const System& system, Perturbation& perturbation,
                                              std::size_t trials, std::uint64_t seed);

/// The shortest interval that holds `probability` of the values, which it reorders (JCGM 101:2008,
/// 7.7); NaNs for none.
Interval shortest_interval(std::span<double> values, double probability);

/// The largest number of digits, up to 2, to which an interval of `half_width` around `value`
/// agrees with another, in digits of the standard uncertainty (JCGM 101:2008, clause 8.1).
int agreeing_digits(double value, double half_width, double standard_uncertainty,
                    const Interval& other);

}  // namespace ilss
