#include "sensors/camera/band_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

// The fit's unknowns: the first edge's offset and slope, the second's, the background's level and
// gradients along and across, and the contrast.
constexpr int unknowns = 8;
using Unknowns = Eigen::Matrix<double, unknowns, 1>;
using Normal = Eigen::Matrix<double, unknowns, unknowns>;
constexpr int camera_columns = static_cast<int>(dimension_of<Image>);
using CameraColumns = Eigen::Matrix<double, unknowns, camera_columns>;
constexpr double rounding_variance = 1.0 / 12;

/// How the shown edge moves with the camera's components while the ideal line stays: at a fixed
/// position along, the shift across less what the shift along brings.
Eigen::Matrix<double, 1, camera_columns> edge_by_camera(const Image<double>& camera,
                                                        const EdgeAt& at, bool vertical) {
  using D = Dual<dimension_of<Image>>;
  Image<D> variable{};
  const auto values = components(camera);
  seed_variables<dimension_of<Image>>(std::span<const double>(values.data(), values.size()), 0,
                                      components(variable));
  const ImagePoint<D> shown =
      distort_pixel(variable, ImagePoint<D>{D(at.ideal.column), D(at.ideal.row)});
  const D& along = vertical ? shown.row : shown.column;
  const D& across = vertical ? shown.column : shown.row;
  return (across.v - at.slope * along.v).transpose();
}

class BandProblem {
 public:
  BandProblem(const ImageView& view, const Image<double>& camera,
              const std::array<StraightEdge, 2>& start, const std::vector<BandWindow>& windows)
      : view_(view), camera_(camera), windows_(windows), frame_(start[0]) {
    along_scale_ = 1.0 / std::max(1, view.along_size);
    across_scale_ = 1.0 / std::max(1, view.across_size);
    for (const BandWindow& window : windows) pixels_ += std::max(0, window.end - window.begin);
  }

  int degrees_of_freedom() const { return pixels_ - unknowns; }

  StraightEdge edge(const Unknowns& x, Eigen::Index which) const {
    return {x[2 * which], x[2 * which + 1], frame_.reference, frame_.vertical};
  }

  /// Sum of squared residuals, JᵀJ and Jᵀr at x; with `columns`, also Jᵀ M by the camera's
  /// components. False where the lens shows no such edge.
  bool linearize(const Unknowns& x, double& cost, Normal& normal, Unknowns& gradient,
                 CameraColumns* columns) const {
    cost = 0;
    normal.setZero();
    gradient.setZero();
    if (columns != nullptr) columns->setZero();
    for (const BandWindow& window : windows_) {
      const auto first = edge_at(camera_, edge(x, 0), window.along);
      const auto second = edge_at(camera_, edge(x, 1), window.along);
      if (!first || !second) return false;
      Eigen::Matrix<double, 1, camera_columns> first_by_camera;
      Eigen::Matrix<double, 1, camera_columns> second_by_camera;
      if (columns != nullptr) {
        first_by_camera = edge_by_camera(camera_, *first, frame_.vertical);
        second_by_camera = edge_by_camera(camera_, *second, frame_.vertical);
      }
      for (int across = window.begin; across < window.end; ++across) {
        const PixelShare before_first = share_before_edge(first->across - across, first->slope);
        const PixelShare before_second = share_before_edge(second->across - across, second->slope);
        Unknowns row;
        const double contrast = x[7];
        edge_derivatives(*first, before_first, contrast, row.data());
        edge_derivatives(*second, before_second, -contrast, row.data() + 2);
        row[4] = 1;
        row[5] = (window.along - frame_.reference) * along_scale_;
        row[6] = (across - frame_.offset) * across_scale_;
        row[7] = before_first.share - before_second.share;
        const double model = x[4] + x[5] * row[5] + x[6] * row[6] + contrast * row[7];
        const double residual = view_.at(window.along, across) - model;
        cost += residual * residual;
        gradient += row * residual;
        normal.triangularView<Eigen::Lower>() += row * row.transpose();
        if (columns != nullptr)
          *columns += row * (contrast * (before_first.by_distance * first_by_camera -
                                         before_second.by_distance * second_by_camera));
      }
    }
    return std::isfinite(cost);
  }

 private:
  static void edge_derivatives(const EdgeAt& at, const PixelShare& share, double factor,
                               double* out) {
    out[0] = factor * share.by_distance * at.by_offset;
    out[1] = factor * (share.by_distance * at.by_slope + share.by_slope);
  }

  const ImageView& view_;
  const Image<double>& camera_;
  const std::vector<BandWindow>& windows_;
  StraightEdge frame_;
  double along_scale_;
  double across_scale_;
  int pixels_ = 0;
};

/// A regression line, y = offset + slope x, point by point.
class Regression {
 public:
  void add(double x, double y) {
    n_ += 1;
    x_ += x;
    y_ += y;
    xx_ += x * x;
    xy_ += x * y;
  }
  double slope() const {
    const double determinant = n_ * xx_ - x_ * x_;
    return determinant > 0 ? (n_ * xy_ - x_ * y_) / determinant : 0;
  }
  double offset() const { return (y_ - slope() * x_) / n_; }

 private:
  double n_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0;
};

/// Background, contrast and edges to start from. At each position along, the darkness summed from
/// the band's middle outwards says where its edges are, whatever pixels they lie in; Gauss-Newton
/// alone would not find its way past the border of a pixel, for an edge along the pixels changes
/// none but the one that it lies in.
std::optional<Unknowns> start_unknowns(const ImageView& view, const Image<double>& camera,
                                       const std::array<StraightEdge, 2>& start,
                                       const std::vector<BandWindow>& windows) {
  double background = 0;
  double darkest = 0;
  const auto window_background = [&](const BandWindow& w) {
    return 0.25 * (view.at(w.along, w.begin) + view.at(w.along, w.begin + 1) +
                   view.at(w.along, w.end - 2) + view.at(w.along, w.end - 1));
  };
  for (const BandWindow& window : windows) {
    if (window.end - window.begin < 5) return std::nullopt;
    double least = 255;
    for (int across = window.begin; across < window.end; ++across)
      least = std::min(least, view.at(window.along, across));
    background += window_background(window);
    darkest += least;
  }
  const auto count = static_cast<double>(windows.size());
  const double contrast = (background - darkest) / count;
  if (!(contrast > 0)) return std::nullopt;

  std::array<Regression, 2> shifts;
  for (const BandWindow& window : windows) {
    const auto first = edge_at(camera, start[0], window.along);
    const auto second = edge_at(camera, start[1], window.along);
    if (!first || !second) return std::nullopt;
    const int middle =
        std::clamp(static_cast<int>(std::lround(0.5 * (first->across + second->across))),
                   window.begin, window.end - 1);
    std::array<double, 2> dark{};
    const double bright = window_background(window);
    for (int across = window.begin; across < window.end; ++across)
      dark[across < middle ? 0 : 1] += (bright - view.at(window.along, across)) / contrast;
    const double along = window.along - start[0].reference;
    shifts[0].add(along, middle - 0.5 - dark[0] - first->across);
    shifts[1].add(along, middle - 0.5 + dark[1] - second->across);
  }
  Unknowns x;
  x << start[0].offset + shifts[0].offset(), start[0].slope + shifts[0].slope(),
      start[1].offset + shifts[1].offset(), start[1].slope + shifts[1].slope(), background / count,
      0, 0, contrast;
  return x;
}

/// An optimum: the unknowns with the cost and JᵀJ there.
struct Optimum {
  Unknowns x;
  double cost;
  Normal normal;
};

/// Gauss-Newton with Levenberg-Marquardt damping where a step does not help. Where an edge lies on
/// the border of two pixels the cost has a kink, on which steps shorten without end; there the
/// optimum is where no step helps by more than a tenth of a standard deviation.
std::optional<Optimum> minimize(const BandProblem& problem, const Unknowns& start) {
  constexpr int most_iterations = 30;
  constexpr double converged = 1e-3;  // of a standard deviation
  constexpr double stalled = 0.1;     // of a standard deviation
  constexpr double least_condition = 1e-14;
  Optimum best{start, 0, {}};
  Unknowns gradient;
  if (!problem.linearize(best.x, best.cost, best.normal, gradient, nullptr)) return std::nullopt;
  double damping = 0;
  double improvement = 0;
  double variance = 0;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    Normal damped = best.normal.selfadjointView<Eigen::Lower>();
    damped.diagonal() *= 1 + damping;
    const Eigen::LDLT<Normal> factor(damped);
    if (factor.info() != Eigen::Success || !(factor.rcond() > least_condition)) return std::nullopt;
    const Unknowns step = factor.solve(gradient);
    variance = std::max(best.cost / problem.degrees_of_freedom(), rounding_variance);
    const double predicted_decrease = step.dot(gradient);
    const bool last = predicted_decrease < converged * converged * variance;
    Optimum trial{best.x + step, 0, {}};
    Unknowns trial_gradient;
    const bool possible =
        problem.linearize(trial.x, trial.cost, trial.normal, trial_gradient, nullptr);
    const double gain_ratio = possible ? (best.cost - trial.cost) / predicted_decrease : -1;
    if (gain_ratio < 0.25)
      damping = std::max(4 * damping, 0.5);
    else if (gain_ratio > 0.75)
      damping = damping < 0.1 ? 0 : 0.1 * damping;
    if (possible && trial.cost <= best.cost) {
      improvement = best.cost - trial.cost;
      best = trial;
      gradient = trial_gradient;
    }
    if (last) return best;
  }
  if (improvement < stalled * stalled * variance) return best;
  return std::nullopt;
}

/// An edge along the pixels may have stopped short of the border between two, its optimum being
/// just beyond: tries from the other side.
void cross_pixel_borders(const BandProblem& problem, double length, Optimum& best) {
  constexpr double shift = 0.05;
  for (Eigen::Index which = 0; which < 2; ++which) {
    if (std::abs(best.x[2 * which + 1]) * length > 1) continue;
    const double from_centre = best.x[2 * which] - std::round(best.x[2 * which]);
    if (std::abs(from_centre) < 0.5 - 2 * shift) continue;
    Unknowns other = best.x;
    const double beyond = 0.5 - std::abs(from_centre) + shift;
    other[2 * which] += from_centre > 0 ? beyond : -beyond;
    const auto optimum = minimize(problem, other);
    if (optimum && optimum->cost < best.cost) best = *optimum;
  }
}

}  // namespace

PixelShare share_before_edge(double distance, double slope) {
  const double half = 0.5 * std::abs(slope);
  if (distance - half > 0.5) return {1, 0, 0};
  if (distance + half < -0.5) return {0, 0, 0};
  const double low = distance + 0.5 - half;
  const double high = distance + 0.5 + half;
  const double clamped_low = std::clamp(low, 0.0, 1.0);
  const double clamped_high = std::clamp(high, 0.0, 1.0);
  if (half < 1e-7) {
    // On the border of two pixels both change, each on one side: together they inform as one does.
    const bool on_border = std::abs(distance) == 0.5;
    return {std::clamp(distance + 0.5, 0.0, 1.0), on_border ? std::sqrt(0.5) : 1, 0};
  }
  // The mean of clamp(., 0, 1) over [low, high], by its integral.
  const auto integral = [](double t, double clamped) {
    return 0.5 * clamped * clamped + std::max(t - 1, 0.0);
  };
  const double width = high - low;
  const double share = (integral(high, clamped_high) - integral(low, clamped_low)) / width;
  // By symmetry the share's change with the slope only has the slope's sign.
  const double by_width = (0.5 * (clamped_high + clamped_low) - share) / width;
  return {share, (clamped_high - clamped_low) / width, slope > 0 ? by_width : -by_width};
}

std::optional<BandFit> fit_band(const ImageView& view, const Image<double>& camera,
                                const std::array<StraightEdge, 2>& start,
                                const std::vector<BandWindow>& windows, double least_noise,
                                bool with_camera) {
  const BandProblem problem(view, camera, start, windows);
  if (problem.degrees_of_freedom() <= 0 || windows.size() < 2) return std::nullopt;
  const auto first = start_unknowns(view, camera, start, windows);
  if (!first) return std::nullopt;
  auto optimum = minimize(problem, *first);
  if (!optimum) return std::nullopt;
  cross_pixel_borders(problem, std::abs(windows.back().along - windows.front().along), *optimum);

  const Eigen::LDLT<Normal> factor(Normal(optimum->normal.selfadjointView<Eigen::Lower>()));
  const Normal inverse = factor.solve(Normal::Identity());
  const double variance = std::max(
      {optimum->cost / problem.degrees_of_freedom(), rounding_variance, least_noise * least_noise});
  BandFit fit;
  fit.edges = {problem.edge(optimum->x, 0), problem.edge(optimum->x, 1)};
  fit.covariance = variance * inverse.topLeftCorner<4, 4>();
  fit.contrast = optimum->x[7];
  fit.noise = std::sqrt(variance);
  fit.by_camera.setZero();
  if (with_camera) {
    CameraColumns columns;
    Unknowns gradient;
    problem.linearize(optimum->x, optimum->cost, optimum->normal, gradient, &columns);
    fit.by_camera = -(inverse * columns).topRows<4>();
  }
  return fit;
}

}  // namespace ilss
