#include "sensors/laser/segment/run_fits.h"

#include <algorithm>
#include <cmath>

#include "sensors/laser/segment/boundary_placement.h"

namespace ilss {

void RunFits::update(std::span<const ScanPoint> points, const LaserNoise& noise) {
  sums_.resize(points.size() + 1);
  sums_[0] = {};
  origin_x_ = points.empty() ? 0 : points[0].x;
  origin_y_ = points.empty() ? 0 : points[0].y;
  Sums sum{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ScanPoint& point = points[i];
    const double x = point.x - origin_x_;
    const double y = point.y - origin_y_;
    const double cc = point.cosine * point.cosine;
    const double cs = point.cosine * point.sine;
    const double ss = point.sine * point.sine;
    const double along = noise.range_variance;
    const double across = point.range * point.range * noise.bearing_variance;
    sum.x += x;
    sum.y += y;
    sum.xx += x * x;
    sum.xy += x * y;
    sum.yy += y * y;
    sum.noise_xx += along * cc + across * ss;
    sum.noise_xy += (along - across) * cs;
    sum.noise_yy += along * ss + across * cc;
    sums_[i + 1] = sum;
  }
}

LeastSquaresLine line_of_scatter(double mean_x, double mean_y, double xx, double xy, double yy) {
  // The direction of the points is the scatter's larger axis, the normal its smaller.
  const double half = (xx - yy) / 2;
  const double root = std::sqrt(half * half + xy * xy);
  double along_x = half >= 0 ? half + root : xy;
  double along_y = half >= 0 ? xy : root - half;
  const double norm = std::sqrt(along_x * along_x + along_y * along_y);
  along_x = norm > 0 ? along_x / norm : 1;
  along_y = norm > 0 ? along_y / norm : 0;
  return {mean_x, mean_y, -along_y, along_x, std::max(0.0, (xx + yy) / 2 - root)};
}

LeastSquaresLine RunFits::line(const ReadingRun& run) const {
  const Sums& a = sums_[run.begin];
  const Sums& b = sums_[run.end];
  const auto count = static_cast<double>(run.size());
  const double x = (b.x - a.x) / count;
  const double y = (b.y - a.y) / count;
  const double xx = b.xx - a.xx - count * x * x;
  const double xy = b.xy - a.xy - count * x * y;
  const double yy = b.yy - a.yy - count * y * y;
  LeastSquaresLine line = line_of_scatter(origin_x_ + x, origin_y_ + y, xx, xy, yy);
  line.variance = (line.normal_x * line.normal_x * (b.noise_xx - a.noise_xx) +
                   2 * line.normal_x * line.normal_y * (b.noise_xy - a.noise_xy) +
                   line.normal_y * line.normal_y * (b.noise_yy - a.noise_yy)) /
                  count;
  return line;
}

void place_boundaries(const RunFits& fits, std::span<ReadingRun> runs) {
  const auto cost = [&](const ReadingRun& run) { return fits.line(run).square; };
  for (std::size_t k = 0; k + 1 < runs.size(); ++k) {
    if (runs[k].size() < 2 || runs[k + 1].size() < 2) continue;
    runs[k].end = runs[k + 1].begin =
        placed_boundary(runs[k], runs[k + 1], boundary_reach, cost, cost);
  }
}

}  // namespace ilss
