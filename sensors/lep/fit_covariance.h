// What a least-squares fit leaves uncertain of its parameters, and which of them it cannot tell
// apart.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>

#include "framework/module/outcome.h"

namespace ilss {

/// A parameter of a fit, for messages.
struct FitParameter {
  std::string_view name;
  bool is_angle = false;  ///< rad, else m
  /// An error as large as this means that the parameter is not known at all.
  double scale = 1;
};

/// The covariance (JᵀJ)⁻¹ of parameters fitted to residuals in units of their sd, J (rows: the
/// residuals) being their derivatives. Fault: degenerate where a change of the parameters as large
/// as their scales moves the residuals by less than one standard deviation in all; the message
/// names the parameters that change together.
Outcome<Eigen::MatrixXd> fit_covariance(const Eigen::MatrixXd& jacobian,
                                        std::span<const FitParameter> parameters);

}  // namespace ilss
