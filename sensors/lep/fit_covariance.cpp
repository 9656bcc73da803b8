#include "sensors/lep/fit_covariance.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <string>

#include "framework/estimate/decompositions.h"

namespace ilss {
namespace {

/// "focal_length +0.50 mm, baseline -0.86 mm": a change of the parameters, a hundredth of the scale
/// of the one that changes most; those that hardly change are left out.
std::string describe_change(const Eigen::VectorXd& by_scale,
                            std::span<const FitParameter> parameters) {
  Eigen::Index most = 0;
  by_scale.cwiseAbs().maxCoeff(&most);
  std::string text;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double share = by_scale[static_cast<Eigen::Index>(i)] / by_scale[most];
    constexpr double least_share = 0.01;
    if (std::abs(share) < least_share) continue;
    const double change = 0.01 * share * parameters[i].scale;
    text += fmt::format("{}{} {:+.2g} {}", text.empty() ? "" : ", ", parameters[i].name,
                        parameters[i].is_angle ? change * 180 / std::numbers::pi : 1e3 * change,
                        parameters[i].is_angle ? "deg" : "mm");
  }
  return text;
}

}  // namespace

Outcome<Eigen::MatrixXd> fit_covariance(const Eigen::MatrixXd& jacobian,
                                        std::span<const FitParameter> parameters) {
  const Eigen::Index n = jacobian.cols();
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) scale[i] = parameters[static_cast<std::size_t>(i)].scale;
  if (!jacobian.allFinite() || jacobian.rows() < n)
    return Fault{FaultKind::degenerate,
                 fmt::format("{} residuals do not determine {} parameters", jacobian.rows(), n)};
  const Svd svd = singular_values(qr_triangle(jacobian * scale.asDiagonal()), Eigen::ComputeFullV);
  const Eigen::VectorXd& singular = svd.singularValues();  // in falling order
  const Eigen::MatrixXd& directions = svd.matrixV();
  const auto undetermined = (singular.array() < 1).count();
  if (undetermined > 0)
    return Fault{FaultKind::degenerate,
                 fmt::format("the data leave {} of {} parameters undetermined: a change such as {} "
                             "would hardly show",
                             undetermined, n, describe_change(directions.col(n - 1), parameters))};
  const Eigen::MatrixXd factor =
      scale.asDiagonal() * directions * singular.cwiseInverse().asDiagonal();
  return Eigen::MatrixXd(factor * factor.transpose());
}

}  // namespace ilss
