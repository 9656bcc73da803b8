#include "sensors/laser/segment/curve_moments.h"

#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

/// Scatter about the mean, divided by the total weight.
struct CentredMoments {
  double xx, xy, yy, xz, yz, zz;

  explicit CentredMoments(const CurveMoments& s) {
    const double share = 1 / s.w;
    const double mx = s.x * share;
    const double my = s.y * share;
    xx = s.xx * share - mx * mx;
    xy = s.xy * share - mx * my;
    yy = s.yy * share - my * my;
    const double q = (s.xx + s.yy) * share;
    const double xq = s.xq * share - mx * q;
    const double yq = s.yq * share - my * q;
    const double qq = s.qq * share - q * q;
    // z, the squared distance from the mean, is q - 2 mx x - 2 my y and a constant.
    const double z = xx + yy;
    xz = xq - 2 * mx * xx - 2 * my * xy;
    yz = yq - 2 * mx * xy - 2 * my * yy;
    zz = qq + 4 * (mx * mx * xx + my * my * yy + 2 * mx * my * xy - mx * xq - my * yq) + z * z;
  }
};

}  // namespace

CircleCost CurveMoments::circle(double enough) const {
  const CentredMoments m(*this);
  const double z = m.xx + m.yy;
  const double determinant = m.xx * m.yy - m.xy * m.xy;
  const double a3 = 4 * z;
  const double a2 = -3 * z * z - m.zz;
  const double a1 = m.zz * z + 4 * determinant * z - m.xz * m.xz - m.yz * m.yz - z * z * z;
  const double a0 = m.xz * (m.xz * m.yy - m.yz * m.xy) + m.yz * (m.yz * m.xx - m.xz * m.xy) -
                    determinant * (m.zz - z * z);
  double root = 0;  // the smallest one, from below
  for (int i = 0; i < 20; ++i) {
    const double value = a0 + root * (a1 + root * (a2 + root * a3));
    const double slope = a1 + root * (2 * a2 + 3 * a3 * root);
    const double next = root - value / slope;
    if (!(next > root)) break;
    const bool is_settled = next - root < 1e-9 * next;
    root = next;
    if (is_settled) break;
    if (w * root > enough) return {w * root, INFINITY};
  }
  const double scale = 2 * (root * root - root * z + determinant);
  const double cx = (m.xz * (m.yy - root) - m.yz * m.xy) / scale;
  const double cy = (m.yz * (m.xx - root) - m.xz * m.xy) / scale;
  return {w * std::max(0.0, root), std::sqrt(cx * cx + cy * cy + z)};
}

namespace {

struct Direction {
  double x, y;
};

/// From neighbours before a point to neighbours behind it, at least so far apart (m²) that noise
/// hardly turns it.
Direction direction_at(std::span<const ScanPoint> points, std::size_t i, double least_square) {
  constexpr std::size_t least_reach = 3;
  constexpr std::size_t most_reach = 1000;
  Direction direction{};
  for (std::size_t reach = least_reach; reach <= most_reach; reach += 1 + reach / 2) {
    const ScanPoint& before = points[i - std::min(i, reach)];
    const ScanPoint& after = points[std::min(points.size() - 1, i + reach)];
    direction = {after.x - before.x, after.y - before.y};
    if (direction.x * direction.x + direction.y * direction.y >= least_square) break;
  }
  return direction;
}

}  // namespace

void CurveMomentSums::set(std::span<const ScanPoint> points, const LaserNoise& noise) {
  constexpr double clear = 10;  // standard deviations
  const double least_square = clear * clear * noise.range_variance;
  sums_.assign(1, {});
  if (points.empty()) return;
  const std::size_t n = points.size();
  const ScanPoint& origin = points[n / 2];
  for (std::size_t i = 0; i < n; ++i) {
    const auto [dx, dy] = direction_at(points, i, least_square);
    const ScanPoint& p = points[i];
    const double length = dx * dx + dy * dy;
    const double across = dy * p.cosine - dx * p.sine;  // of the beam, times the length
    const double share = length > 0 ? std::max(0.01, across * across / length) : 1;
    const double variance =
        noise.range_variance * share + p.range * p.range * noise.bearing_variance * (1 - share);
    const double w = 1 / variance;
    const double x = p.x - origin.x;
    const double y = p.y - origin.y;
    const double q = x * x + y * y;
    const CurveMoments& last = sums_.back();
    sums_.push_back({last.w + w, last.x + w * x, last.y + w * y, last.xx + w * x * x,
                     last.xy + w * x * y, last.yy + w * y * y, last.xq + w * x * q,
                     last.yq + w * y * q, last.qq + w * q * q});
  }
}

}  // namespace ilss
