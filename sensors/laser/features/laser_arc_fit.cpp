#include "sensors/laser/features/laser_arc_fit.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace ilss {
namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

/// A circle about (x, y) of which the laser sees the near side, or the far one where it is hollow.
struct Circle {
  Vector3 parameters;  ///< x, y, radius > 0 (m)
  bool bulges;
};

/// What a reading says of a circle.
struct ArcResidual {
  double value;
  double weight;
  Vector3 by_circle;  ///< of the value, by x, y and radius
  double by_range;    ///< of the value
};

/// The residual across the circle at a point with normal (nx, ny), at `distance` from the centre.
ArcResidual residual_at(double nx, double ny, double distance, const ScanPoint& p,
                        const Circle& circle, const LaserNoise& noise) {
  const double radius = circle.parameters.z();
  const double along = nx * p.cosine + ny * p.sine;
  const double share = along * along;
  const double by_bearing = p.range * p.range * noise.bearing_variance;
  const double across = noise.range_variance * (1 - share) + by_bearing * share;
  const double longer = across / (2 * radius);  // mean of what the noise across adds
  const double variance =
      noise.range_variance * share + by_bearing * (1 - share) + 2 * longer * longer;
  return {distance - radius - longer, 1 / variance, {-nx, -ny, -1}, along};
}

ArcResidual residual_of(const ScanPoint& p, const Circle& circle, const LaserNoise& noise) {
  const Vector3& c = circle.parameters;
  const double radius = c.z();
  const double across = c.x() * p.sine - c.y() * p.cosine;
  const double half = radius * radius - across * across;
  constexpr double grazing = 0.05;  // of the squared radius
  if (half > grazing * radius * radius) {
    // Where the beam meets the circle: then the normal has no part in the reading's noise.
    const double along = c.x() * p.cosine + c.y() * p.sine;
    const double root = circle.bulges ? -std::sqrt(half) : std::sqrt(half);
    const double range = along + root;
    const double nx = (range * p.cosine - c.x()) / radius;
    const double ny = (range * p.sine - c.y()) / radius;
    const double incidence = root / radius;
    const double share = incidence * incidence;
    const double variance =
        noise.range_variance * share + range * range * noise.bearing_variance * (1 - share);
    return {(p.range - range) * incidence, 1 / variance, {-nx, -ny, -1}, incidence};
  }
  const double dx = p.x - c.x();
  const double dy = p.y - c.y();
  const double distance = std::sqrt(dx * dx + dy * dy);
  return residual_at(dx / distance, dy / distance, distance, p, circle, noise);
}

struct Normals {
  Matrix3 information = Matrix3::Zero();
  Vector3 gradient = Vector3::Zero();
  double chi_squared = 0;
};

Normals accumulate(std::span<const ScanPoint> points, const Circle& circle,
                   const LaserNoise& noise) {
  double xx = 0;
  double xy = 0;
  double x1 = 0;
  double yy = 0;
  double y1 = 0;
  double one = 0;
  double xe = 0;
  double ye = 0;
  double e1 = 0;
  double ee = 0;
  for (const ScanPoint& p : points) {
    const ArcResidual r = residual_of(p, circle, noise);
    const double wx = r.weight * r.by_circle.x();
    const double wy = r.weight * r.by_circle.y();
    const double we = r.weight * r.value;
    xx += wx * r.by_circle.x();
    xy += wx * r.by_circle.y();
    x1 += wx;
    yy += wy * r.by_circle.y();
    y1 += wy;
    one += r.weight;
    xe += wx * r.value;
    ye += wy * r.value;
    e1 += we;
    ee += we * r.value;
  }
  Normals normals;
  normals.information << xx, xy, -x1, xy, yy, -y1, -x1, -y1, one;
  normals.gradient << xe, ye, -e1;
  normals.chi_squared = ee;
  return normals;
}

/// The circle x² + y² = a x + b y + c of least squares, about the points' mean (Kåsa).
std::optional<Vector3> algebraic_circle(std::span<const ScanPoint> points) {
  double x = 0;
  double y = 0;
  for (const ScanPoint& p : points) {
    x += p.x;
    y += p.y;
  }
  const auto n = static_cast<double>(points.size());
  x /= n;
  y /= n;
  double xx = 0;
  double xy = 0;
  double yy = 0;
  double xq = 0;
  double yq = 0;
  double q = 0;
  for (const ScanPoint& p : points) {
    const double dx = p.x - x;
    const double dy = p.y - y;
    const double square = dx * dx + dy * dy;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
    xq += dx * square;
    yq += dy * square;
    q += square;
  }
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > 1e-12 * (xx + yy) * (xx + yy))) return std::nullopt;
  const double a = (yy * xq - xy * yq) / (2 * determinant);
  const double b = (xx * yq - xy * xq) / (2 * determinant);
  return Vector3(x + a, y + b, std::sqrt(a * a + b * b + q / n));
}

/// Whether the surface bulges towards the laser: most beams meet its normal from outside.
bool bulges(std::span<const ScanPoint> points, const Vector3& circle) {
  double along = 0;
  for (const ScanPoint& p : points)
    along += (p.x - circle.x()) * p.cosine + (p.y - circle.y()) * p.sine;
  return along < 0;
}

}  // namespace

std::optional<LaserArcFit> fit_laser_arc(std::span<const ScanPoint> points, const LaserNoise& noise,
                                         const UncertainBiases& biases) {
  if (points.size() < 4) return std::nullopt;
  const auto start = algebraic_circle(points);
  if (!start) return std::nullopt;
  Circle circle{*start, bulges(points, *start)};
  Normals normals = accumulate(points, circle, noise);
  double damping = 1e-3;
  constexpr int most_steps = 30;
  constexpr double settled = 1e-3;  // of chi²
  bool is_settled = false;
  for (int i = 0; i < most_steps && !is_settled; ++i) {
    Matrix3 damped = normals.information;
    damped.diagonal() *= 1 + damping;
    const Vector3 step = damped.llt().solve(-normals.gradient);
    const Circle next{circle.parameters + step, circle.bulges};
    if (!step.allFinite()) return std::nullopt;
    const Normals at_next = next.parameters.z() > 0 ? accumulate(points, next, noise)
                                                    : Normals{.chi_squared = INFINITY};
    // The weights change with the circle, so chi² may rise a little although the step is right.
    if (at_next.chi_squared <= normals.chi_squared + settled) {
      is_settled = std::abs(step.dot(normals.gradient)) < settled;
      circle = next;
      normals = at_next;
      damping *= 0.1;
    } else {
      // Where a beam begins to graze, chi² has a step, on whose edge the best circle may lie.
      is_settled = std::abs(step.dot(normals.gradient)) < 100 * settled;
      damping = std::max(1e-3, damping * 10);
      if (damping > 1e6) return std::nullopt;
    }
  }
  const Eigen::LLT<Matrix3> factor(normals.information);
  if (!is_settled || factor.info() != Eigen::Success) return std::nullopt;
  LaserArcFit fit;
  const double sign = circle.bulges ? 1 : -1;
  const Vector3 signs(1, 1, sign);
  fit.x = circle.parameters.x();
  fit.y = circle.parameters.y();
  fit.radius = sign * circle.parameters.z();
  fit.covariance =
      signs.asDiagonal() * factor.solve(Matrix3::Identity()).eval() * signs.asDiagonal();
  fit.chi_squared = normals.chi_squared;
  fit.readings = points.size();
  if (biases.count > 0) {
    for (const ScanPoint& p : points) {
      const ArcResidual r = residual_of(p, circle, noise);
      Vector3 by_bias = r.weight * r.by_range * r.by_circle;
      for (std::size_t k = 0; k < biases.count; ++k, by_bias *= p.range / biases.reference)
        fit.by_bias.col(static_cast<Eigen::Index>(k)) += by_bias;
    }
    fit.by_bias = signs.asDiagonal() * (-factor.solve(fit.by_bias)).eval();
  }
  return fit;
}

double squared_residual(const LaserArcFit& arc, const ScanPoint& p, const LaserNoise& noise) {
  const ArcResidual r =
      residual_of(p, {{arc.x, arc.y, std::abs(arc.radius)}, arc.radius > 0}, noise);
  return r.value * r.value * r.weight;
}

double range_of(const LaserArcFit& arc, const ScanPoint& beam) {
  const double along = arc.x * beam.cosine + arc.y * beam.sine;
  const double across = arc.x * beam.sine - arc.y * beam.cosine;
  const double square = arc.radius * arc.radius - across * across;
  if (!(square > 0)) return along;
  return arc.radius > 0 ? along - std::sqrt(square) : along + std::sqrt(square);
}

}  // namespace ilss
