// How two values of a payload differ, and how a value moves by a small error. Angles and rotations
// are no vector space: nothing else subtracts or adds values of a payload.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "framework/estimate/payload.h"

namespace ilss {

// An error has as many components as the value. On the circle it is the way round, in [-pi, pi).
// Of a rotation in space it is the rotation vector e of R(a) = R(b) R(e), which is local: turned in
// the frame that b has turned. Lineages and covariances of rotations are of such errors.

/// Whether all components are plain or circular, so that errors at one value are errors at any.
bool is_flat(const PayloadDescriptor& type);

/// a ⊖ b, the error that leads from b to a, into `out`, which may be a or b.
void difference(const PayloadDescriptor& type, std::span<const double> a, std::span<const double> b,
                std::span<double> out);
Eigen::VectorXd difference(const PayloadDescriptor& type, std::span<const double> a,
                           std::span<const double> b);

/// value ⊕ error, into `out`, which may be either. The result is normal: see `normalize`.
void retract(const PayloadDescriptor& type, std::span<const double> value,
             std::span<const double> error, std::span<double> out);
std::vector<double> retract(const PayloadDescriptor& type, std::span<const double> value,
                            std::span<const double> error);

/// The same value with angles in [-pi, pi) and rotations by at most half a turn.
void normalize(const PayloadDescriptor& type, std::span<double> value);

/// Jacobians between errors (m x m), identities but for rotations. Of d = a ⊖ b by an error of a,
/// which depends on d only; and by an error of b.
///
/// Since d is the rotation vector of a itself where b is no rotation, the first is also what an
/// error does to a value's components, at d = value.
Eigen::MatrixXd difference_by_first(const PayloadDescriptor& type, std::span<const double> d);
Eigen::MatrixXd difference_by_second(const PayloadDescriptor& type, std::span<const double> d);

/// Of value ⊕ e by an error of the value; and by e, which is also the error that a small change of
/// a value's components makes, at e = value.
Eigen::MatrixXd retract_by_value(const PayloadDescriptor& type, std::span<const double> e);
Eigen::MatrixXd retract_by_error(const PayloadDescriptor& type, std::span<const double> e);

/// Makes the Jacobian of a function by components (rows x columns, column-major) the one of errors:
/// what an error of `in` at `in_value` does to `out` at `out_value`.
void jacobian_of_errors(const PayloadDescriptor& out, std::span<const double> out_value,
                        const PayloadDescriptor& in, std::span<const double> in_value,
                        std::span<double> jacobian);

/// The x with sum w_i (z_i ⊖ x) = 0, near the first value: where all are flat, z_0 + sum w_i (z_i -
/// z_0), else by Newton's steps. Weights add up to 1.
std::vector<double> weighted_mean(const PayloadDescriptor& type,
                                  std::span<const std::span<const double>> values,
                                  std::span<const double> weights);

/// Makes Jacobians of gains W_i (m x m, side by side, that add up to the identity): how the x with
/// sum W_i (z_i ⊖ x) = 0 moves with errors of the z_i, (sum W_i L_i)⁻¹ W_i A_i, where A_i and -L_i
/// are the Jacobians of d_i = z_i ⊖ x by both; `differences` (m x n) are the d_i. A flat type's
/// stay as they are.
void transport_gains(const PayloadDescriptor& type, const Eigen::MatrixXd& differences,
                     Eigen::MatrixXd& gains);

}  // namespace ilss
