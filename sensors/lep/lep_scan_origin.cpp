#include "sensors/lep/lep_scan_origin.h"

#include <ceres/tiny_solver.h>
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "framework/estimate/angle.h"
#include "framework/estimate/differentiate.h"
#include "sensors/lep/fit_covariance.h"

namespace ilss {
namespace {

/// Scan angles as ceres::TinySolver wants them; parameters x0, z0, projected vergence.
class EdgeResiduals {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 3 };

  explicit EdgeResiduals(std::span<const StripeEdge> edges) : edges_(edges) {}
  int NumResiduals() const { return static_cast<int>(edges_.size()); }

  bool operator()(const double* parameters, double* residuals, double* jacobian) const {
    using T = Dual<3>;
    std::array<T, 3> p;
    seed_variables<3>({parameters, 3}, 0, p);
    const std::size_t n = edges_.size();
    for (std::size_t i = 0; i < n; ++i) {
      const StripeEdge& edge = edges_[i];
      const T residual = atan2(edge.x - p[0], edge.z - p[1]) - p[2] - edge.scan_angle;
      residuals[i] = residual.a;
      if (jacobian == nullptr) continue;
      for (std::size_t k = 0; k < 3; ++k)
        jacobian[k * n + i] = residual.v[static_cast<Eigen::Index>(k)];
    }
    return true;
  }

 private:
  std::span<const StripeEdge> edges_;
};

}  // namespace

Outcome<LepScanOriginFit> fit_scan_origin(std::span<const StripeEdge> edges) {
  constexpr std::size_t fewest = 5;
  if (edges.size() < fewest)
    return Fault{FaultKind::degenerate, fmt::format("a scan origin needs {} stripe edges or more, "
                                                    "got {}",
                                                    fewest, edges.size())};
  double depth = 0;
  for (const StripeEdge& edge : edges) {
    if (!std::isfinite(edge.scan_angle + edge.x + edge.z))
      return Fault{FaultKind::bad_data, "a stripe edge has a number that is not finite"};
    depth += std::abs(edge.z) / static_cast<double>(edges.size());
  }
  const EdgeResiduals residuals(edges);
  ceres::TinySolver<EdgeResiduals> solver;
  // The residuals are radians: what counts as a small change of their squares is small.
  solver.options.function_tolerance = solver.options.cost_threshold = 1e-26;
  solver.options.gradient_tolerance = 1e-16;
  solver.options.parameter_tolerance = 1e-12;
  solver.options.max_num_iterations = 100;
  Eigen::Vector3d parameters = Eigen::Vector3d::Zero();
  solver.Solve(residuals, &parameters);

  const auto n = static_cast<Eigen::Index>(edges.size());
  Eigen::VectorXd at_solution(n);
  Eigen::MatrixXd jacobian(n, 3);
  residuals(parameters.data(), at_solution.data(), jacobian.data());
  LepScanOriginFit fit;
  fit.edges = edges.size();
  fit.residual = std::sqrt(at_solution.squaredNorm() / static_cast<double>(n - 3));
  constexpr double sharpest = 1e-9;  // rad; exact data still have rounding errors
  const std::array<FitParameter, 3> names = {{{"origin_x", false, 0.1 * depth},
                                              {"origin_z", false, 0.1 * depth},
                                              {"projected_vergence", true, 0.1}}};
  const auto covariance = fit_covariance(jacobian / std::fmax(fit.residual, sharpest), names);
  if (!covariance) return covariance.fault();
  fit.origin = {parameters[0], parameters[1], parameters[2],
                *covariance * std::pow(fit.residual / std::fmax(fit.residual, sharpest), 2)};
  return fit;
}

}  // namespace ilss
