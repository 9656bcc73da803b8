#include "sensors/range/line_fit.h"

#include <Eigen/LU>
#include <cmath>

namespace ilss {
namespace {

/// What one reading says about a line m: u = m · e / (1 - m · o) + noise.
struct LineResidual {
  RangeResidual residual;
  Eigen::Vector2d by_line;  ///< of the expected one
  /// Of the residual, by the scan's mount and shared errors.
  Eigen::Matrix<double, 1, scan_dependences> by_scan;
};

/// The head's angle, which seldom changes from reading to reading.
struct Turn {
  double angle = 0;
  double c = 1;
  double s = 0;
  void to(double head) {
    if (head == angle) return;
    *this = {head, std::cos(head), std::sin(head)};
  }
};

LineResidual line_residual(const RangeReading& reading, const Turn& head, const InverseLine& m,
                           const RangeNoise& noise) {
  const double ex = std::cos(reading.bearing);
  const double ez = std::sin(reading.bearing);
  const double scale = 1 / (1 - m.x * reading.origin_x - m.z * reading.origin_z);
  const double expected = (m.x * ex + m.z * ez) * scale;
  LineResidual r{RangeResidual(reading, expected, noise), {}, {}};
  r.by_line = {(ex + expected * reading.origin_x) * scale,
               (ez + expected * reading.origin_z) * scale};
  const double u = r.residual.by_reading;
  r.by_scan << -expected * scale * (m.x * head.c + m.z * head.s),
      -expected * scale * (m.z * head.c - m.x * head.s), -(m.z * ex - m.x * ez) * scale,
      u * reading.sensitivity[0], u * reading.sensitivity[1], u * reading.sensitivity[2],
      u * reading.sensitivity[3], u * reading.sensitivity[4];
  return r;
}

}  // namespace

std::optional<LineFit> fit_line(std::span<const RangeReading> readings,
                                std::span<const ReadingRun> runs, const InverseLine& start,
                                const RangeNoise& noise) {
  // The start solves the linear form, which all but is the exact one; but its weights are the
  // measured ranges', which noise in range makes wrong.
  const int steps = noise.in_range ? 4 : 1;
  LineFit fit;
  fit.line = start;
  for (int step = 0; step < steps; ++step) {
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    Eigen::Matrix<double, 2, scan_dependences> by_scan;
    by_scan.setZero();
    fit.chi_squared = 0;
    fit.readings = 0;
    Turn head;
    for (const ReadingRun& run : runs) {
      for (const RangeReading& reading : readings.subspan(run.begin, run.size())) {
        head.to(reading.head);
        const LineResidual r = line_residual(reading, head, fit.line, noise);
        const Eigen::Vector2d weighted = r.residual.weight * r.by_line;
        information += weighted * r.by_line.transpose();
        gradient += weighted * r.residual.value;
        by_scan += weighted * r.by_scan;
        fit.chi_squared += r.residual.weight * r.residual.value * r.residual.value;
      }
      fit.readings += run.size();
    }
    const double determinant = information.determinant();
    if (fit.readings < 2 || !(determinant > 1e-14 * information(0, 0) * information(1, 1)))
      return std::nullopt;
    const Eigen::Matrix2d inverse = information.inverse();
    const Eigen::Vector2d change = inverse * gradient;
    fit.line = {fit.line.x + change.x(), fit.line.z + change.y()};
    fit.chi_squared -= gradient.dot(change);
    fit.covariance = inverse * noise.factor();
    fit.by_scan = inverse * by_scan;
  }
  if (!std::isfinite(fit.line.x) || !std::isfinite(fit.line.z)) return std::nullopt;
  return fit;
}

}  // namespace ilss
