#include "sensors/laser/features/laser_line_fit.h"

#include <cmath>

#include "framework/estimate/angle.h"
#include "sensors/laser/internal/pairs.h"
#include "sensors/laser/segment/run_fits.h"

namespace ilss {
namespace {

/// The line in the form that the iteration works with.
struct Normal {
  double cosine;
  double sine;
  double rho;
};

/// Sums over the readings of w, w g, ..., with the residual e across the line and the coordinate g
/// along it from the foot of the perpendicular. `Number`: a Pair while they are summed up.
template <typename Number>
struct Sums {
  Number w{};
  Number wg{};
  Number wgg{};
  Number we{};
  Number wge{};
  Number wee{};
  Number wggg{};
  Number wgggg{};
  Number wgge{};
  Number least_incidence = Number{} + 1;  ///< of the cosines between beams and normal
};

Sums<double> whole(const Sums<Pair>& s) {
  return {sum(s.w),    sum(s.wg),
          sum(s.wgg),  sum(s.we),
          sum(s.wge),  sum(s.wee),
          sum(s.wggg), sum(s.wgggg),
          sum(s.wgge), std::min(s.least_incidence[0], s.least_incidence[1])};
}

/// `FromLine`: where a beam meets the line tells its weight; otherwise where it was measured, and
/// only what a step needs is summed up.
template <bool FromLine>
Sums<double> accumulate(std::span<const ScanPoint> points, const LaserNoise& noise,
                        const Normal& line) {
  const bool has_exact_bearings = noise.bearing_variance == 0;
  const double information = 1 / noise.range_variance;
  Sums<Pair> sums;
  for_pairs(points, [&](const ScanPoint& p, const ScanPoint& q, const Pair& present) {
    const Pair cosine{p.cosine, q.cosine};
    const Pair sine{p.sine, q.sine};
    const Pair measured{p.range, q.range};
    const Pair c = line.cosine * cosine + line.sine * sine;
    const Pair s = line.sine * cosine - line.cosine * sine;
    const Pair inverse = 1 / c;
    const Pair range = FromLine ? line.rho * inverse : measured;
    const Pair g = range * s;
    const Pair e = measured * c - line.rho;
    const Pair w = has_exact_bearings
                       ? information * present * inverse * inverse
                       : present / (noise.range_variance * c * c + noise.bearing_variance * g * g);
    const Pair wg = w * g;
    const Pair wgg = wg * g;
    const Pair we = w * e;
    const Pair wge = wg * e;
    sums.w += w;
    sums.wg += wg;
    sums.wgg += wgg;
    sums.we += we;
    sums.wge += wge;
    if constexpr (FromLine) {
      const Pair wggg = wgg * g;
      sums.wee += we * e;
      sums.wggg += wggg;
      sums.wgggg += wggg * g;
      sums.wgge += wge * g;
      sums.least_incidence = c < sums.least_incidence ? c : sums.least_incidence;
    }
  });
  return whole(sums);
}

/// The best line with every reading the same weight and error in both directions.
Normal total_least_squares(std::span<const ScanPoint> points) {
  const Pair origin{points.front().x, points.front().y};  // near the readings: sums stay exact
  Pair x{};
  Pair y{};
  Pair xx{};
  Pair xy{};
  Pair yy{};
  for_pairs(points, [&](const ScanPoint& p, const ScanPoint& q, const Pair& present) {
    const Pair dx = (Pair{p.x, q.x} - origin[0]) * present;
    const Pair dy = (Pair{p.y, q.y} - origin[1]) * present;
    x += dx;
    y += dy;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
  });
  const auto n = static_cast<double>(points.size());
  const double mean_x = sum(x) / n;
  const double mean_y = sum(y) / n;
  const LeastSquaresLine best =
      line_of_scatter(origin[0] + mean_x, origin[1] + mean_y, sum(xx) - mean_x * sum(x),
                      sum(xy) - mean_x * sum(y), sum(yy) - mean_y * sum(y));
  const double rho = best.normal_x * best.centre_x + best.normal_y * best.centre_y;
  if (rho < 0) return {-best.normal_x, -best.normal_y, -rho};
  return {best.normal_x, best.normal_y, rho};
}

struct Direction {
  double cosine;
  double sine;
};

struct Step {
  double rho;
  double alpha;
  double gain;  ///< chi² that it saves
};

Step step_of(const Sums<double>& s, double determinant) {
  const double rho = (s.wgg * s.we - s.wg * s.wge) / determinant;
  const double alpha = (s.w * s.wge - s.wg * s.we) / determinant;
  return {rho, alpha, rho * s.we + alpha * s.wge};
}

/// What e = a + b g + c g² would save of chi² over e = a + b g, and 1 / (2 |c|).
struct Bend {
  double gain = 0;
  double radius = INFINITY;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};

Bend bend_of(const Sums<double>& s) {
  const double mean = s.wg / s.w;
  const double second = s.wgg - mean * s.wg;  // about the mean
  const double third = s.wggg - mean * s.wgg;
  const double shear = third / second;  // of g² on g
  const double square_mean = s.wgg / s.w;
  const double spread = s.wgggg - square_mean * s.wgg - shear * third;
  if (!(spread > 1e-12 * s.wgggg)) return {};
  const double by_line = s.wge - mean * s.we;
  const double across = s.wgge - square_mean * s.we - shear * by_line;
  const double curvature = across / spread;  // c
  // Half a length L of the parabola has a slope that is c L / 2 off the whole's, and lies c L² / 12
  // beside it; turned about the middle, rho changes with it.
  const double length = std::sqrt(12 * second / s.w);
  const double slope = curvature * length / 2;
  const double beside = curvature * length * length / 12;
  const Eigen::Vector2d turned(-mean * slope, slope);
  Bend bend{across * across / spread, 1 / (2 * std::abs(curvature)), turned * turned.transpose()};
  bend.covariance(0, 0) += beside * beside;
  return bend;
}

/// The unit vector at an angle: by its series where that is exact, as after a first step.
Direction direction_at(double angle) {
  if (!(std::abs(angle) < 0.01)) return {std::cos(angle), std::sin(angle)};
  const double square = angle * angle;
  return {1 - square / 2 * (1 - square / 12 * (1 - square / 30)),
          angle * (1 - square / 6 * (1 - square / 20 * (1 - square / 42)))};
}

void turn(Normal& line, const Step& step) {
  // Turned by a small angle about the foot of the perpendicular, which is where g counts from.
  const auto [cosine, sine] = direction_at(step.alpha);
  line = {line.cosine * cosine - line.sine * sine, line.sine * cosine + line.cosine * sine,
          line.rho + step.rho};
}

Eigen::Matrix<double, 2, range_biases> bias_sensitivity(std::span<const ScanPoint> points,
                                                        const LaserNoise& noise, const Normal& line,
                                                        const Eigen::Matrix2d& covariance,
                                                        const UncertainBiases& biases) {
  Eigen::Matrix<double, 2, range_biases> sums = Eigen::Matrix<double, 2, range_biases>::Zero();
  for (const ScanPoint& p : points) {
    const double c = line.cosine * p.cosine + line.sine * p.sine;
    const double s = line.sine * p.cosine - line.cosine * p.sine;
    const double g = line.rho / c * s;
    const double w = 1 / (noise.range_variance * c * c + noise.bearing_variance * g * g);
    double by_bias = w * c;
    for (std::size_t k = 0; k < biases.count; ++k, by_bias *= p.range / biases.reference) {
      sums(0, static_cast<Eigen::Index>(k)) += by_bias;
      sums(1, static_cast<Eigen::Index>(k)) += by_bias * g;
    }
  }
  return covariance * sums;
}

}  // namespace

std::optional<LaserLineFit> fit_laser_line(std::span<const ScanPoint> points,
                                           const LaserNoise& noise, const UncertainBiases& biases) {
  if (points.size() < 2) return std::nullopt;
  Normal line = total_least_squares(points);
  Sums<double> sums = accumulate<false>(points, noise, line);
  constexpr int most_steps = 20;
  constexpr double settled = 1e-4;  // of chi²: a hundredth of a standard deviation
  for (int i = 0; i < most_steps; ++i) {
    const double determinant = sums.w * sums.wgg - sums.wg * sums.wg;
    if (!(determinant > 1e-12 * sums.w * sums.wgg)) return std::nullopt;
    const Step step = step_of(sums, determinant);
    turn(line, step);
    if (i > 0 && step.gain < settled) {
      constexpr double least = 1e-6;  // below, beams run along the line
      if (!(sums.least_incidence > least) || !(line.rho > least)) return std::nullopt;
      LaserLineFit fit;
      fit.rho = line.rho;
      fit.alpha = wrap_angle(std::atan2(line.sine, line.cosine));
      fit.cosine = line.cosine;
      fit.sine = line.sine;
      fit.covariance << sums.wgg, -sums.wg, -sums.wg, sums.w;
      fit.covariance /= determinant;
      fit.chi_squared = std::max(0.0, sums.wee - step.gain);
      const Bend bend = bend_of(sums);
      fit.bend = bend.gain;
      fit.bend_radius = bend.radius;
      fit.bend_covariance = bend.covariance;
      fit.readings = points.size();
      if (biases.count > 0)
        fit.by_bias = bias_sensitivity(points, noise, line, fit.covariance, biases);
      return fit;
    }
    sums = accumulate<true>(points, noise, line);
  }
  return std::nullopt;
}

double squared_residual(const LaserLineFit& line, const ScanPoint& p, const LaserNoise& noise) {
  const double c = line.cosine * p.cosine + line.sine * p.sine;
  const double s = line.sine * p.cosine - line.cosine * p.sine;
  if (!(c > 0)) return INFINITY;
  const double g = line.rho / c * s;
  const double e = p.range * c - line.rho;
  return e * e / (noise.range_variance * c * c + noise.bearing_variance * g * g);
}

}  // namespace ilss
