// Several estimates of one thing side by side: their joint error, and how they differ.
#pragma once

#include <Eigen/Core>
#include <span>

#include "framework/module/output.h"

namespace ilss {

/// n estimates z_i of one payload of m components. Each component is measured in the largest
/// standard deviation that any component of its unit has in any of them, so that components of
/// different units count alike and no result depends on the units.
struct JointEstimates {
  Eigen::Index count;      ///< n
  Eigen::Index dimension;  ///< m
  Eigen::VectorXd scale;   ///< m: SI units of one; 1 where every component of the unit is exact
  Eigen::MatrixXd offset;  ///< m x n: z_i - z_0, circular components wrapped
  Eigen::MatrixXd factor;  ///< n m x K: the stacked factors G_i, aligned by source

  auto factor_of(Eigen::Index i) const { return factor.middleRows(i * dimension, dimension); }
};

/// Lays estimates side by side, as their lineages say that they are correlated.
JointEstimates joint_estimates(std::span<const Output* const> inputs);

/// As above where the correlation of their random errors is not known: with a joint covariance that
/// is not below the true one, whatever it is. Random columns stand apart for each input, sqrt(n)
/// times as large: Var(sum a_i) <= n sum Var(a_i) for any a_i (Cauchy-Schwarz). What is persistent
/// is shared as the lineages say.
JointEstimates bounded_joint_estimates(std::span<const Output* const> inputs);

/// The deviations y_i = z_i - mean(z) of joint estimates, stacked (n m), and their covariance as
/// U S² Uᵀ: r directions U in which the estimates' errors let them differ, S by how much, and V
/// which sources do it, Y = U S Vᵀ. Errors that all share cancel, so r is the rank of what is left.
///
/// Left out of U are directions that claim to be exact because two constraints nearly coincide: in
/// payloads of lower rank (two points on a wall, from two unknowns) each estimate is exact across
/// its tangent plane, and where planes differ by what curvature makes of the errors, first order
/// would take their intersection for the truth. Constraints less than 11 degrees apart are taken
/// for one that is seen twice.
struct JointDeviations {
  Eigen::VectorXd value;                ///< n m
  Eigen::MatrixXd directions;           ///< U, n m x r, orthonormal
  Eigen::VectorXd standard_deviations;  ///< S, r
  Eigen::MatrixXd sources;              ///< V, K x r, orthonormal

  /// What the directions leave over: zero if all is as the errors say.
  Eigen::VectorXd unexplained() const {
    return value - directions * (directions.transpose() * value);
  }
};
JointDeviations joint_deviations(const JointEstimates& joint);

/// How much of a deviation may be left over, in the scale's standard deviations: what first order
/// leaves out is small against them.
inline constexpr double largest_unexplained = 5;

/// Why the estimates cannot all be right: two that claim to be exact differ beyond rounding, or
/// the deviations are beyond `largest_unexplained` where shared errors leave none. Empty if they
/// can. Names component, inputs and size.
std::string contradiction(std::span<const Output* const> inputs, const JointEstimates& joint,
                          const JointDeviations& deviations);

/// Writes z_0 + sum of W_i (z_i - z_0), angles on the circle, and the first input's labels; `gains`
/// are the W_i (m x m, in units of the scale) side by side, which add up to the identity.
void write_combination(std::span<const Output* const> inputs, const JointEstimates& joint,
                       const Eigen::MatrixXd& gains, Estimate& estimate);

/// The gain W_i in SI units.
Eigen::MatrixXd gain_of(const JointEstimates& joint, const Eigen::MatrixXd& gains, Eigen::Index i);

}  // namespace ilss
