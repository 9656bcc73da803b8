#include "sensors/lep/lep_calibration.h"

#include <ceres/tiny_solver.h>
#include <fmt/format.h>

#include <cmath>

#include "framework/estimate/decompositions.h"
#include "framework/estimate/differentiate.h"
#include "sensors/lep/fit_covariance.h"

namespace ilss {
namespace {

constexpr std::size_t fewest_points = 6;

/// Equation 10 at z^p = depth - origin_z and theta = scan angle + projected vergence; `Shift` is
/// double where the scan origin is exact.
template <typename T, typename Shift>
T image_position(const LepGeometry<T>& geometry, const Shift& origin_z,
                 const Shift& projected_vergence, const LepCalibrationPoint& point) {
  using std::cos;
  const Shift theta = point.scan_angle + projected_vergence;
  const Shift inverse_range = cos(theta) / (point.depth - origin_z);
  return LepRay<T>(geometry, theta).image_position(T(inverse_range));
}

/// Image positions in units of their sd as ceres::TinySolver wants them; parameters f, d, gamma, s.
class PositionResiduals {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 4 };

  PositionResiduals(std::span<const LepCalibrationPoint> points, const LepScanOrigin& origin)
      : points_(points), origin_(origin) {}
  int NumResiduals() const { return static_cast<int>(points_.size()); }

  bool operator()(const double* p, double* residuals, double* jacobian) const {
    if (jacobian == nullptr) {
      const LepGeometry<double> geometry{p[0], p[1], p[2], p[3]};
      for (std::size_t i = 0; i < points_.size(); ++i)
        residuals[i] = residual(geometry, points_[i]);
      return true;
    }
    using T = Dual<4>;
    std::array<T, 4> duals;
    seed_variables<4>({p, 4}, 0, duals);
    const LepGeometry<T> geometry{duals[0], duals[1], duals[2], duals[3]};
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const T value = residual(geometry, points_[i]);
      residuals[i] = value.a;
      for (std::size_t k = 0; k < 4; ++k)
        jacobian[k * points_.size() + i] = value.v[static_cast<Eigen::Index>(k)];
    }
    return true;
  }

 private:
  template <typename T>
  T residual(const LepGeometry<T>& geometry, const LepCalibrationPoint& point) const {
    return (image_position(geometry, origin_.z, origin_.projected_vergence, point) -
            point.image_position) /
           point.deviation;
  }

  std::span<const LepCalibrationPoint> points_;
  const LepScanOrigin& origin_;
};

/// The residuals' derivatives by origin_z and projected_vergence (one row a point).
Eigen::MatrixX2d origin_jacobian(std::span<const LepCalibrationPoint> points,
                                 const LepGeometry<double>& g, const LepScanOrigin& origin) {
  using T = Dual<2>;
  const LepGeometry<T> geometry{T(g.focal_length), T(g.baseline), T(g.vergence),
                                T(g.lens_distance)};
  Eigen::MatrixX2d jacobian(static_cast<Eigen::Index>(points.size()), 2);
  for (std::size_t i = 0; i < points.size(); ++i)
    jacobian.row(static_cast<Eigen::Index>(i)) =
        image_position(geometry, T(origin.z, 0), T(origin.projected_vergence, 1), points[i])
            .v.transpose() /
        points[i].deviation;
  return jacobian;
}

/// The fit's own covariance C and what the scan origin's uncertainty Q does to it: with beta the
/// four and q the origin, d beta / d q = S = -C Jᵀ J_q, so cov = [C + S Q Sᵀ, S Q; Q Sᵀ, Q].
Eigen::Matrix<double, 7, 7> joint_covariance(const Eigen::Matrix4d& own,
                                             const Eigen::MatrixXd& jacobian,
                                             const Eigen::MatrixX2d& by_origin,
                                             const Eigen::Matrix3d& origin) {
  Eigen::Matrix<double, 7, 3> by_all = Eigen::Matrix<double, 7, 3>::Zero();
  by_all.topRightCorner<4, 2>() = -own * (jacobian.transpose() * by_origin);
  by_all.bottomRows<3>().setIdentity();
  Eigen::Matrix<double, 7, 7> joint = by_all * origin * by_all.transpose();
  joint.topLeftCorner<4, 4>() += own;
  return joint;
}

Outcome<> check(std::span<const LepCalibrationPoint> points, const LepScanOrigin& origin) {
  if (points.size() < fewest_points)
    return Fault{FaultKind::degenerate, fmt::format("a calibration needs {} points or more, got {}",
                                                    fewest_points, points.size())};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const LepCalibrationPoint& point = points[i];
    const double theta = point.scan_angle + origin.projected_vergence;
    if (!std::isfinite(point.image_position + point.scan_angle + point.depth) ||
        !(point.deviation > 0) || std::isinf(point.deviation))
      return Fault{FaultKind::bad_data,
                   fmt::format("point {}: its numbers must be finite, and its sd positive", i + 1)};
    if (!(point.depth > origin.z) || !(std::cos(theta) > 0))
      return Fault{FaultKind::bad_data,
                   fmt::format("point {}: the target must stand in front of the scan origin, at "
                               "less than 90 deg",
                               i + 1)};
  }
  return {};
}

/// Where chi² is least from one start.
struct Minimum {
  Eigen::Vector4d parameters;
  double chi_squared;
};

Minimum descend(const PositionResiduals& residuals, const LepGeometry<double>& start) {
  ceres::TinySolver<PositionResiduals> solver;
  // The parameters are strongly correlated: stop only where chi² and they stand still.
  solver.options.initial_trust_region_radius = 1e8;
  solver.options.function_tolerance = 1e-9;
  solver.options.parameter_tolerance = 1e-13;
  solver.options.max_num_iterations = 200;
  Eigen::Vector4d parameters(start.focal_length, start.baseline, start.vergence,
                             start.lens_distance);
  solver.Solve(residuals, &parameters);
  return {parameters, 2 * solver.summary.final_cost};
}

/// From the paper's solution; where that does not lead to a good fit (an outlier can have ruined
/// it), also from the shipped sensor's parameters.
Eigen::Vector4d minimize(const PositionResiduals& residuals, const LepCalibration& calibration) {
  const LepGeometry<double> shipped;
  if (!calibration.linear) return descend(residuals, shipped).parameters;
  const Minimum first = descend(residuals, calibration.linear->geometry);
  const double degrees = calibration.degrees_of_freedom();
  if (first.chi_squared < 2 * degrees) return first.parameters;
  const Minimum second = descend(residuals, shipped);
  return second.chi_squared < first.chi_squared ? second.parameters : first.parameters;
}

LepResiduals summarize(std::span<const LepCalibrationPoint> points,
                       const Eigen::VectorXd& weighted) {
  LepResiduals result;
  const auto n = static_cast<double>(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double in_sd = -weighted[static_cast<Eigen::Index>(i)];  // measured less model
    const double residual = in_sd * points[i].deviation;
    result.mean += residual / n;
    result.rms += residual * residual / n;
    if (std::abs(residual) > std::abs(result.largest)) {
      result.largest = residual;
      result.largest_at = i;
    }
    if (std::abs(in_sd) > std::abs(result.largest_in_sd)) {
      result.largest_in_sd = in_sd;
      result.largest_in_sd_at = i;
    }
  }
  result.rms = std::sqrt(result.rms);
  return result;
}

}  // namespace

std::array<double, 7> LepCalibration::values() const {
  return {geometry.focal_length,    geometry.baseline, geometry.vergence,
          geometry.lens_distance,   origin.x,          origin.z,
          origin.projected_vergence};
}

double model_image_position(const LepGeometry<double>& geometry, const LepScanOrigin& origin,
                            double scan_angle, double depth) {
  return image_position(geometry, origin.z, origin.projected_vergence,
                        {.scan_angle = scan_angle, .depth = depth});
}

std::optional<LepLinearFit> fit_lep_linear(std::span<const LepCalibrationPoint> points,
                                           const LepScanOrigin& origin) {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::Matrix<double, Eigen::Dynamic, 6> h(n, 6);
  Eigen::VectorXd right(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const LepCalibrationPoint& point = points[static_cast<std::size_t>(i)];
    const double c = std::cos(point.scan_angle + origin.projected_vergence);
    const double s = std::sin(point.scan_angle + origin.projected_vergence);
    const double p = point.image_position;
    const double z = point.depth - origin.z;
    h.row(i) << p * c * s, -p * c * c, -p * c, c * c, s * c, -z;  // equation 12
    right[i] = p * z;
  }
  const Eigen::VectorXd scale = h.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  const PivotedQr qr = pivoted_qr(h * scale.asDiagonal());
  constexpr double least_pivot = 1e-10;
  if (qr.maxPivot() <= 0 || std::abs(qr.matrixR()(5, 5)) < least_pivot * qr.maxPivot())
    return std::nullopt;
  const Eigen::VectorXd x = scale.asDiagonal() * solve(qr, right);
  LepGeometry<double> geometry;  // equation 13
  geometry.baseline = x[0];
  geometry.focal_length = x[3] / x[0];
  geometry.vergence = std::atan(x[4] / x[3]);
  geometry.lens_distance = x[2] * std::cos(geometry.vergence);
  if (!x.allFinite() || !(geometry.focal_length > 0)) return std::nullopt;
  return LepLinearFit{x, geometry};
}

Outcome<LepCalibration> calibrate_lep(std::span<const LepCalibrationPoint> points,
                                      const LepScanOrigin& origin) {
  if (Outcome<> outcome = check(points, origin); !outcome) return outcome.fault();
  LepCalibration result;
  result.origin = origin;
  result.points = points.size();
  result.linear = fit_lep_linear(points, origin);
  const PositionResiduals residuals(points, origin);
  const Eigen::Vector4d parameters = minimize(residuals, result);

  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::VectorXd at_solution(n);
  Eigen::MatrixXd jacobian(n, 4);
  residuals(parameters.data(), at_solution.data(), jacobian.data());
  result.geometry = {parameters[0], parameters[1], parameters[2], parameters[3]};
  result.chi_squared = at_solution.squaredNorm();
  result.residuals = summarize(points, at_solution);
  const LepGeometry<double> shipped;
  const std::array<FitParameter, 4> names = {{{"focal_length", false, shipped.focal_length},
                                              {"baseline", false, shipped.baseline},
                                              {"vergence", true, 0.1},
                                              {"lens_distance", false, shipped.lens_distance}}};
  const auto covariance = fit_covariance(jacobian, names);
  if (!covariance) return covariance.fault();
  result.covariance = joint_covariance(
      *covariance, jacobian, origin_jacobian(points, result.geometry, origin), origin.covariance);
  return result;
}

}  // namespace ilss
