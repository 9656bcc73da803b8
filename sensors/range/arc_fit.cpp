#include "sensors/range/arc_fit.h"

#include <ceres/tiny_solver.h>
#include <ceres/tiny_solver_autodiff_function.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "framework/estimate/differentiate.h"

namespace ilss {
namespace {

struct ArcResiduals {
  std::span<const RangeReading> readings;
  RangeNoise noise;

  int NumResiduals() const { return static_cast<int>(readings.size()); }

  template <typename T>
  bool operator()(const T* circle, T* residuals) const {
    for (std::size_t i = 0; i < readings.size(); ++i) {
      const RangeReading& r = readings[i];
      const T range = range_to_circle(T(r.origin_x), T(r.origin_z), T(std::cos(r.bearing)),
                                      T(std::sin(r.bearing)), circle[0], circle[1], circle[2]);
      const double u = r.inverse_range;
      residuals[i] = noise.in_range ? (range - T(1 / u)) * T(u * u / r.deviation)
                                    : (T(u) - T(1) / range) / T(r.deviation);
    }
    return true;
  }
};

/// The circle x² + z² + a x + b z + c = 0 with least squares of its equation (Kasa 1976), each
/// point weighted by its range's variance; as a start only, since noise makes it too small.
std::optional<Eigen::Vector3d> algebraic_circle(std::span<const RangeReading> readings) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const RangeReading& r : readings) {
    const double range = 1 / r.inverse_range;
    const double x = r.origin_x + range * std::cos(r.bearing);
    const double z = r.origin_z + range * std::sin(r.bearing);
    const double deviation = r.deviation * range * range;
    const Eigen::Vector3d row(x, z, 1);
    information += row * row.transpose() / (deviation * deviation);
    right -= row * (x * x + z * z) / (deviation * deviation);
  }
  const Eigen::Vector3d solution = information.ldlt().solve(right);
  const Eigen::Vector2d centre = -0.5 * solution.head<2>();
  const double square = centre.squaredNorm() - solution[2];
  if (!(square > 0) || !solution.allFinite()) return std::nullopt;
  const RangeReading& middle = readings[readings.size() / 2];
  const double along = (centre.x() - middle.origin_x) * std::cos(middle.bearing) +
                       (centre.y() - middle.origin_z) * std::sin(middle.bearing);
  const double bulge = along > 1 / middle.inverse_range ? 1 : -1;
  return Eigen::Vector3d(centre.x(), centre.y(), bulge * std::sqrt(square));
}

/// Covariance and dependences at the fitted circle.
bool add_errors(std::span<const RangeReading> readings, const RangeNoise& noise, ArcFit& fit) {
  // By the circle, then by the scan's mount.
  using T = Dual<6>;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, scan_dependences> by_scan;
  by_scan.setZero();
  fit.chi_squared = 0;
  for (const RangeReading& r : readings) {
    const double c = std::cos(r.head);
    const double s = std::sin(r.head);
    const T mount_x(0.0, 3);
    const T mount_z(0.0, 4);
    const T bearing(r.bearing, 5);
    const T range = range_to_circle(
        T(r.origin_x) + c * mount_x - s * mount_z, T(r.origin_z) + s * mount_x + c * mount_z,
        cos(bearing), sin(bearing), T(fit.circle[0], 0), T(fit.circle[1], 1), T(fit.circle[2], 2));
    const T expected = T(1) / range;
    const RangeResidual residual(r, expected.a, noise);
    const double weight = residual.weight;
    const double u = residual.by_reading;
    const Eigen::Vector3d by_circle = expected.v.head<3>();
    Eigen::Matrix<double, 1, scan_dependences> residual_by_scan;
    residual_by_scan << -expected.v.tail<3>().transpose(), u * r.sensitivity[0],
        u * r.sensitivity[1], u * r.sensitivity[2], u * r.sensitivity[3], u * r.sensitivity[4];
    information += weight * by_circle * by_circle.transpose();
    by_scan += weight * by_circle * residual_by_scan;
    fit.chi_squared += weight * residual.value * residual.value;
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(information);
  if (solver.info() != Eigen::Success || !(solver.rcond() > 1e-12)) return false;
  const Eigen::Matrix3d inverse = solver.solve(Eigen::Matrix3d::Identity());
  fit.covariance = inverse * noise.factor();
  fit.by_scan = inverse * by_scan;
  fit.readings = readings.size();
  return fit.covariance.allFinite();
}

}  // namespace

double arc_residual(const RangeReading& reading, const Eigen::Vector3d& circle) {
  const double c = std::cos(reading.bearing);
  const double s = std::sin(reading.bearing);
  const double across = (circle[0] - reading.origin_x) * s - (circle[1] - reading.origin_z) * c;
  if (std::abs(across) >= grazing * std::abs(circle[2])) return INFINITY;
  const double range =
      range_to_circle(reading.origin_x, reading.origin_z, c, s, circle[0], circle[1], circle[2]);
  return (reading.inverse_range - 1 / range) / reading.deviation;
}

std::optional<ArcFit> fit_arc(std::span<const RangeReading> readings, const ArcRule& rule,
                              const RangeNoise& noise) {
  if (readings.size() < 4) return std::nullopt;
  const auto start = algebraic_circle(readings);
  if (!start) return std::nullopt;
  const ArcResiduals residuals{readings, noise};
  using Function = ceres::TinySolverAutoDiffFunction<ArcResiduals, Eigen::Dynamic, 3>;
  Function function(residuals);
  ceres::TinySolver<Function> solver;
  solver.options.max_num_iterations = 30;
  ArcFit fit;
  fit.circle = *start;
  solver.Solve(function, &fit.circle);
  const double radius = std::abs(fit.circle[2]);
  if (!fit.circle.allFinite() || radius < rule.least_radius || radius > rule.largest_radius ||
      !add_errors(readings, noise, fit) || fit.covariance(2, 2) > radius * radius)
    return std::nullopt;
  return fit;
}

}  // namespace ilss
