#include "sensors/laser/features/laser_arc_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "sensors/laser/internal/pairs.h"
#include "sensors/laser/segment/curve_moments.h"
#include "sensors/laser/segment/run_fits.h"

namespace ilss {
namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

/// A circle about (x, y) of which the laser sees the near side, or the far one where it is hollow.
struct Circle {
  Vector3 parameters;  ///< x, y, radius > 0 (m)
  bool bulges;
};

/// What a reading says of a circle; `Number`: a double, or a Pair for two readings.
template <typename Number>
struct ArcResidual {
  Number value;
  Number weight;
  Number normal_x;  ///< of the circle; the value's derivatives by x, y and radius are (-normal, -1)
  Number normal_y;
  Number by_range;  ///< of the value
};

/// The residual across the circle at a point with normal (nx, ny), at `distance` from the centre.
ArcResidual<double> residual_at(double nx, double ny, double distance, const ScanPoint& p,
                                const Circle& circle, const LaserNoise& noise) {
  const double radius = circle.parameters.z();
  const double along = nx * p.cosine + ny * p.sine;
  const double share = along * along;
  const double by_bearing = p.range * p.range * noise.bearing_variance;
  const double across = noise.range_variance * (1 - share) + by_bearing * share;
  const double longer = across / (2 * radius);  // mean of what the noise across adds
  const double variance =
      noise.range_variance * share + by_bearing * (1 - share) + 2 * longer * longer;
  return {distance - radius - longer, 1 / variance, nx, ny, along};
}

/// Where the beam meets the circle: then the normal has no part in the reading's noise.
template <typename Number>
ArcResidual<Number> residual_where_met(const Number& cosine, const Number& sine,
                                       const Number& measured, const Number& half,
                                       const Circle& circle, const LaserNoise& noise) {
  const double x = circle.parameters.x();
  const double y = circle.parameters.y();
  const double inverse = (circle.bulges ? -1 : 1) / circle.parameters.z();
  const Number incidence = square_root(half) * inverse;
  const Number range = x * cosine + y * sine + incidence * circle.parameters.z();
  const Number share = incidence * incidence;
  const Number variance =
      noise.range_variance * share + range * range * noise.bearing_variance * (1 - share);
  const double outward = 1 / circle.parameters.z();
  return {(measured - range) * incidence, 1 / variance, (range * cosine - x) * outward,
          (range * sine - y) * outward, incidence};
}

/// Half the chord that a beam has in common with the circle, squared; a beam grazes or passes it
/// where that is no more than this share of the squared radius.
constexpr double grazing = 0.05;

template <typename Number>
Number squared_half_chord(const Number& cosine, const Number& sine, const Circle& circle) {
  const Vector3& c = circle.parameters;
  const Number across = c.x() * sine - c.y() * cosine;
  return c.z() * c.z() - across * across;
}

ArcResidual<double> residual_of(const ScanPoint& p, const Circle& circle, const LaserNoise& noise) {
  const Vector3& c = circle.parameters;
  const double half = squared_half_chord(p.cosine, p.sine, circle);
  if (half > grazing * c.z() * c.z())
    return residual_where_met(p.cosine, p.sine, p.range, half, circle, noise);
  const double dx = p.x - c.x();
  const double dy = p.y - c.y();
  const double distance = std::sqrt(dx * dx + dy * dy);
  return residual_at(dx / distance, dy / distance, distance, p, circle, noise);
}

ArcResidual<Pair> residuals_of(const ScanPoint& p, const ScanPoint& q, const Circle& circle,
                               const LaserNoise& noise) {
  const double least = grazing * circle.parameters.z() * circle.parameters.z();
  const Pair cosine{p.cosine, q.cosine};
  const Pair sine{p.sine, q.sine};
  const Pair half = squared_half_chord(cosine, sine, circle);
  if (half[0] > least && half[1] > least)
    return residual_where_met(cosine, sine, Pair{p.range, q.range}, half, circle, noise);
  const ArcResidual<double> a = residual_of(p, circle, noise);
  const ArcResidual<double> b = residual_of(q, circle, noise);
  return {Pair{a.value, b.value}, Pair{a.weight, b.weight}, Pair{a.normal_x, b.normal_x},
          Pair{a.normal_y, b.normal_y}, Pair{a.by_range, b.by_range}};
}

struct Normals {
  Matrix3 information = Matrix3::Zero();
  Vector3 gradient = Vector3::Zero();
  double chi_squared = 0;
};

Normals accumulate(std::span<const ScanPoint> points, const Circle& circle,
                   const LaserNoise& noise) {
  Pair xx{};
  Pair xy{};
  Pair x1{};
  Pair yy{};
  Pair y1{};
  Pair one{};
  Pair xe{};
  Pair ye{};
  Pair e1{};
  Pair ee{};
  for_pairs(points, [&](const ScanPoint& p, const ScanPoint& q, const Pair& present) {
    const ArcResidual<Pair> r = residuals_of(p, q, circle, noise);
    const Pair w = r.weight * present;
    const Pair wx = w * r.normal_x;
    const Pair wy = w * r.normal_y;
    const Pair we = w * r.value;
    xx += wx * r.normal_x;
    xy += wx * r.normal_y;
    x1 += wx;
    yy += wy * r.normal_y;
    y1 += wy;
    one += w;
    xe += wx * r.value;
    ye += wy * r.value;
    e1 += we;
    ee += we * r.value;
  });
  Normals normals;
  normals.information << sum(xx), sum(xy), sum(x1), sum(xy), sum(yy), sum(y1), sum(x1), sum(y1),
      sum(one);
  normals.gradient << -sum(xe), -sum(ye), -sum(e1);
  normals.chi_squared = sum(ee);
  return normals;
}

/// Means over some points of powers of their coordinates about their centre, and of q, their
/// squared distances from it.
struct CircleMoments {
  double centre_x, centre_y, xx, xy, yy, xq, yq, q, qq;
  double determinant() const { return xx * yy - xy * xy; }
};

CircleMoments moments_of(std::span<const ScanPoint> points) {
  const auto n = static_cast<double>(points.size());
  Pair x{};
  Pair y{};
  for_pairs(points, [&](const ScanPoint& p, const ScanPoint& q, const Pair& present) {
    x += Pair{p.x, q.x} * present;
    y += Pair{p.y, q.y} * present;
  });
  const double centre_x = sum(x) / n;
  const double centre_y = sum(y) / n;
  Pair xx{};
  Pair xy{};
  Pair yy{};
  Pair xq{};
  Pair yq{};
  Pair qq{};
  for_pairs(points, [&](const ScanPoint& a, const ScanPoint& b, const Pair& present) {
    const Pair dx = (Pair{a.x, b.x} - centre_x) * present;
    const Pair dy = (Pair{a.y, b.y} - centre_y) * present;
    const Pair dx2 = dx * dx;
    const Pair dy2 = dy * dy;
    const Pair q = dx2 + dy2;
    xx += dx2;
    xy += dx * dy;
    yy += dy2;
    xq += dx * q;
    yq += dy * q;
    qq += q * q;
  });
  const double mean_q = (sum(xx) + sum(yy)) / n;
  return {centre_x,    centre_y,    sum(xx) / n, sum(xy) / n, sum(yy) / n,
          sum(xq) / n, sum(yq) / n, mean_q,      sum(qq) / n};
}

/// The circle x² + y² = a x + b y + c of least squares, about the points' mean (Kåsa).
std::optional<Vector3> algebraic_circle(const CircleMoments& m) {
  const double determinant = m.determinant();
  if (!(determinant > 1e-12 * (m.xx + m.yy) * (m.xx + m.yy))) return std::nullopt;
  const double a = (m.yy * m.xq - m.xy * m.yq) / (2 * determinant);
  const double b = (m.xx * m.yq - m.xy * m.xq) / (2 * determinant);
  return Vector3(m.centre_x + a, m.centre_y + b, std::sqrt(a * a + b * b + m.q));
}

/// As `exceeds_limits`, by the moments of n readings.
bool exceeds(const CircleMoments& m, double n, const LaserNoise& noise, const ArcLimits& limits) {
  if (noise.bearing_variance > 0) return false;
  // Where beams graze, `residual_at` takes so much off a distance, and counts so much variance.
  const double longer = noise.range_variance / (2 * limits.least_radius);
  const double variance = noise.range_variance + 2 * longer * longer;
  const double farthest = longer + std::sqrt(limits.most_chi_squared * variance);
  const double root = std::sqrt(limits.most_chi_squared * variance) + longer * std::sqrt(n);
  const double algebraic =  // K / n, less what rounding may have added
      m.qq - m.q * m.q - 1e-9 * m.qq -
      (m.yy * m.xq * m.xq - 2 * m.xy * m.xq * m.yq + m.xx * m.yq * m.yq) / m.determinant();
  const double clear = std::sqrt(n * std::max(0.0, algebraic)) - root * farthest;
  if (!(clear > 0)) return false;
  const double curvature = 2 * root / clear;  // what is more curved is too far off
  if (curvature * limits.largest_radius < 1) return true;
  const double share = curvature * farthest;
  const CurveMoments moments{n, 0, 0, n * m.xx, n * m.xy, n * m.yy, n * m.xq, n * m.yq, n * m.qq};
  return share < 1 &&
         std::sqrt(0.999 * moments.circle().chi_squared) * (1 - share) > root * (1 + share / 2);
}

/// Whether the surface bulges towards the laser: most beams meet its normal from outside.
bool bulges(std::span<const ScanPoint> points, const Vector3& circle) {
  double along = 0;
  for (const ScanPoint& p : points)
    along += (p.x - circle.x()) * p.cosine + (p.y - circle.y()) * p.sine;
  return along < 0;
}

}  // namespace

bool exceeds_limits(std::span<const ScanPoint> points, const LaserNoise& noise,
                    const ArcLimits& limits) {
  return exceeds(moments_of(points), static_cast<double>(points.size()), noise, limits);
}

bool exceeds_as_line_and_arc(std::span<const ScanPoint> points, const LaserNoise& noise,
                             double most_of_line, const ArcLimits& limits) {
  if (noise.bearing_variance > 0) return false;
  const auto n = static_cast<double>(points.size());
  const CircleMoments m = moments_of(points);
  const LeastSquaresLine line = line_of_scatter(m.centre_x, m.centre_y, m.xx, m.xy, m.yy);
  constexpr double rounding = 1e-12;  // of the scatter
  return n * (line.square - rounding * m.q) > most_of_line * noise.range_variance &&
         exceeds(m, n, noise, limits);
}

std::optional<LaserArcFit> fit_laser_arc(std::span<const ScanPoint> points, const LaserNoise& noise,
                                         const UncertainBiases& biases, const ArcLimits& limits) {
  if (points.size() < 4) return std::nullopt;
  const CircleMoments moments = moments_of(points);
  const auto start = algebraic_circle(moments);
  if (!start || exceeds(moments, static_cast<double>(points.size()), noise, limits))
    return std::nullopt;
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
      const ArcResidual<double> r = residual_of(p, circle, noise);
      Vector3 by_bias = -r.weight * r.by_range * Vector3(r.normal_x, r.normal_y, 1);
      for (std::size_t k = 0; k < biases.count; ++k, by_bias *= p.range / biases.reference)
        fit.by_bias.col(static_cast<Eigen::Index>(k)) += by_bias;
    }
    fit.by_bias = signs.asDiagonal() * (-factor.solve(fit.by_bias)).eval();
  }
  return fit;
}

double squared_residual(const LaserArcFit& arc, const ScanPoint& p, const LaserNoise& noise) {
  const ArcResidual<double> r =
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
