// Consistency: is an estimate as wrong as it says? NEES and NIS with their chi-square bounds
// (Bar-Shalom, Li, Kirubarajan 2001, sec. 5.4).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <span>

#include "framework/estimate/estimate.h"

namespace ilss {

/// eᵀ P⁺ e and the rank of P. Where P is singular the pseudo-inverse is taken, which leaves out the
/// part of the error that P says cannot be: `unexplained` is the largest such part in standard
/// deviations (infinite for an error of a component that claims to be exact). Everything is
/// infinite where an error or a variance is not finite.
struct NormalizedError {
  double value;
  int rank;
  double unexplained;
};

/// Normalised squared error of `error` under `covariance` (n x n, symmetric).
NormalizedError normalized_squared_error(const Eigen::Ref<const Eigen::VectorXd>& error,
                                         const Eigen::Ref<const Eigen::MatrixXd>& covariance);

/// Normalised estimation error squared against the truth (values in the payload's order). Of a
/// rotation the error is the same in the tangent at either, so that it is exact.
NormalizedError nees(const Estimate& estimate, std::span<const double> truth);

/// Normalised innovation squared of two estimates of one thing, their shared errors accounted for.
/// No allocation for up to 16 components, nor in normalized_squared_error.
NormalizedError nis(const Estimate& a, const Estimate& b);

/// The covariance of a ⊖ b where the errors of the two have nothing in common, whatever their
/// sources are called.
Eigen::MatrixXd independent_covariance(const Estimate& a, const Estimate& b);

/// The interval that a chi-square variable lies in with the given probability, tails equal.
struct Interval {
  double low;
  double high;
  bool contains(double x) const { return low <= x && x <= high; }
};
Interval chi_square_interval(double degrees_of_freedom, double probability);

/// What a chi-square variable exceeds with probability 1 - `probability`.
double chi_square_quantile(double degrees_of_freedom, double probability);

/// The half width of a two-sided interval in standard deviations: of Student's t, or of the normal
/// law where the degrees of freedom are infinite (JCGM 100:2008, G.3).
double coverage_factor(double degrees_of_freedom, double probability);
/// That of a normal law at 95 %.
inline constexpr double normal_coverage_factor_95 = 1.959963984540054;

/// Collects normalised errors of many runs: an honest estimator's mean per degree of freedom is 1.
class ConsistencyStatistic {
 public:
  void add(const NormalizedError& error) {
    sum_ += error.value;
    degrees_of_freedom_ += error.rank;
    unexplained_ = std::max(unexplained_, error.unexplained);
    ++count_;
  }
  /// The largest `unexplained` of all.
  double unexplained() const { return unexplained_; }
  std::size_t count() const { return count_; }
  double degrees_of_freedom() const { return degrees_of_freedom_; }
  /// Mean normalised error per degree of freedom.
  double mean() const { return sum_ / degrees_of_freedom_; }
  /// Where `mean` lies with the given probability if the estimator is honest.
  Interval bounds(double probability) const {
    const Interval sum = chi_square_interval(degrees_of_freedom_, probability);
    return {sum.low / degrees_of_freedom_, sum.high / degrees_of_freedom_};
  }
  /// Whether the mean lies within these bounds; never of no degrees of freedom.
  bool consistent(double probability) const {
    return degrees_of_freedom_ > 0 && bounds(probability).contains(mean());
  }

 private:
  double sum_ = 0;
  double degrees_of_freedom_ = 0;
  double unexplained_ = 0;
  std::size_t count_ = 0;
};

}  // namespace ilss
