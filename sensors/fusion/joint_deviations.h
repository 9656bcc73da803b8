// Several estimates of one thing side by side: their joint error, and how they differ.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>

#include "framework/module/output.h"

namespace ilss {

/// n estimates z_i of one payload of m components, as errors at a common origin x. Each component
/// is measured in the largest standard deviation that any component of its unit has in any of them,
/// so that components of different units count alike and no result depends on the units.
struct JointEstimates {
  Eigen::Index count;          ///< n
  Eigen::Index dimension;      ///< m
  Eigen::VectorXd scale;       ///< m: SI units of one; 1 where every component of the unit is exact
  std::vector<double> origin;  ///< m: x, in SI units
  Eigen::MatrixXd offset;      ///< m x n: z_i ⊖ x
  Eigen::MatrixXd factor;      ///< n m x K: the stacked factors of these, aligned by source

  auto factor_of(Eigen::Index i) const { return factor.middleRows(i * dimension, dimension); }
};

/// Where estimates are laid side by side to begin with: the first one's value, or their mean where
/// they have rotations, so that their order does not matter.
std::vector<double> common_origin(std::span<const Output* const> inputs);

/// Lays estimates side by side at an origin, as their lineages say that they are correlated.
JointEstimates joint_estimates(std::span<const Output* const> inputs,
                               std::span<const double> origin);

/// As above where the correlation of their random errors is not known: with a joint covariance that
/// is not below the true one, whatever it is. Random columns stand apart for each input, sqrt(n)
/// times as large: Var(sum a_i) <= n sum Var(a_i) for any a_i (Cauchy-Schwarz). What is persistent
/// is shared as the lineages say.
JointEstimates bounded_joint_estimates(std::span<const Output* const> inputs,
                                       std::span<const double> origin);

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

/// x ⊕ sum of W_i (z_i ⊖ x) of joint estimates, by gains that add up to the identity.
struct Combination {
  JointEstimates joint;
  Eigen::MatrixXd gains;  ///< side by side (m x n m, in units of the scale): how the value moves
                          ///< with the errors of the z_i (transport_gains)
  std::vector<double> value;
};

/// Combines estimates by the W_i that `find_gains` gives. Where errors at one value are not errors
/// at another (rotations), the estimates are laid side by side at the result again, until it stays.
Combination combine(std::span<const Output* const> inputs,
                    const std::function<Eigen::MatrixXd(const JointEstimates&)>& find_gains);

/// The gain of an estimate in SI units.
Eigen::MatrixXd gain_of(const Combination& combination, Eigen::Index i);

}  // namespace ilss
