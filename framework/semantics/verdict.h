// The verdict: can the first-order error of an output be believed?
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "framework/graph/system.h"

namespace ilss {

/// What may be believed of a first-order error.
enum class Verdict {
  linear_ok,             ///< its 95 % intervals and ellipsoid hold what they say
  second_order,          ///< they do not, but those around the corrected mean do
  monte_carlo_required,  ///< nor do these: the error is another than a normal one
  invalid,               ///< some errors lead out of the formula's domain
};
std::string_view verdict_name(Verdict verdict);

/// The verdict on one output and what it rests on, per component (SI units); the latter is empty
/// for an output that is exact and stays as it is whatever moves.
struct VerdictReport {
  Verdict verdict = Verdict::linear_ok;  ///< at least as bad as the components'
  std::string reason = {};               ///< of a verdict that no component alone explains
  std::vector<Verdict> components = {};
  std::vector<double> bias = {};  ///< second-order shift of the mean
  std::vector<double> extra_variance =
      {};                ///< variance beyond the first-order one; may be negative
  bool piloted = false;  ///< whether a pilot was needed
};

/// The second order is small where, in every component and along every principal axis of the
/// covariance, its bias stays below this part of the standard deviation, ...
inline constexpr double clear_relative_bias = 0.05;
/// ... and what is added to the variance, and what sources of sqrt(3) standard deviations really do
/// to it, below this part of it.
inline constexpr double clear_relative_variance = 0.02;
/// So many trials are drawn in any case, for what no derivative shows: kinks, steps, limits,
/// products of three, laws that are not normal.
inline constexpr std::size_t glance_trials = 512;
/// Where either is in doubt, so many, ...
inline constexpr std::size_t pilot_trials = 2000;
/// ... and the share inside each 95 % interval, and inside the ellipsoid, may be off by this much;
/// around the corrected mean by twice as much.
inline constexpr double pilot_tolerance = 0.02;
/// A component with a unit whose whole error, to second order, is less than this part of the
/// largest standard deviation among the output's components of that unit is not judged by itself.
inline constexpr double negligible_error = 1e-3;
/// A larger share of trials without an answer makes `invalid`.
inline constexpr double largest_fault_share = 0.01;

/// Judges outputs of a system as they stand after a tick or an expectation, in three steps.
/// The second order: each source of the outputs' sensors, estimators and parameters is moved by
/// ±sqrt(3) standard deviations (the points of third-order Gauss-Hermite quadrature) and the
/// functions behind it are evaluated again, so that curvature of the whole chain counts, not that
/// of single modules; then pairs are moved together, for what sources only do in company (x y at
/// 0, 0): each pair of up to 12 sources, random signs of all where an output has more. A glance:
/// few trials of Monte Carlo, in which intervals, ellipsoid, mean and standard deviation must be as
/// stated but for what so few scatter. Where one of these is in doubt, a pilot of more trials
/// decides; where the second order makes the larger part of a variance, or a component has no
/// first-order error but one in the trials, it is monte_carlo_required. docs/error_model.md has
/// misses and false alarms.
///
/// An output costs what its own branch costs, some 600 evaluations of the functions in it: it is
/// judged by the nodes that it follows from and by their sources, together with those outputs that
/// share a function with it. One that no error reaches is linear_ok and costs nothing. Its verdict
/// does not depend on which others are judged. Between ticks a judge keeps its modules and buffers;
/// it may be asked at any ticks, and allocates nothing once warm, unless it meets faults.
class Judge {
 public:
  /// Judges `nodes` in this order. `cut` names function nodes whose outputs were given and are to
  /// be moved themselves. The system must outlive the judge.
  Judge(const System& system, std::vector<std::size_t> nodes, std::vector<std::size_t> cut = {});
  /// Judges the plan's outputs.
  explicit Judge(const System& system) : Judge(system, system.plan().outputs) {}
  ~Judge();
  Judge(Judge&&) noexcept;
  Judge& operator=(Judge&&) = delete;

  /// Judges them as they stand now: one report a node, valid until the next call. A node without an
  /// output is `invalid`.
  const std::vector<VerdictReport>& judge();

 private:
  struct Tools;
  class Group;

  const System* system_;
  std::vector<std::size_t> cut_;
  std::vector<Group> groups_;
  std::unique_ptr<Tools> tools_;
  std::vector<VerdictReport> reports_;
};

/// Judges the system's outputs once, as Judge does.
std::vector<VerdictReport> judge(const System& system, const std::vector<std::size_t>& cut = {});

}  // namespace ilss
