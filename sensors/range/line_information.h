// What readings say of the line they lie on, added up so that any run of them is fitted at once.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "sensors/range/range_scan.h"

namespace ilss {

/// A line that misses the origin as m = (cos phi, sin phi) / rho: m · x = 1 on the line.
struct InverseLine {
  double x = 0;
  double z = 0;
};

/// The weighted least squares of inverse ranges over a run of readings. A ray from o in direction e
/// meets the line m at inverse range u = m · e / (1 - m · o), so u = m · (e + u o): linear in m
/// with the regressor h = e + u o. Since rays start within centimetres of the origin, the noise
/// that u brings into h does not matter (its square over the ranges').
struct LineInformation {
  double hxhx = 0, hxhz = 0, hzhz = 0;  ///< sum of w h hᵀ
  double hxu = 0, hzu = 0;              ///< sum of w h u
  double uu = 0;                        ///< sum of w u²

  LineInformation operator-(const LineInformation& other) const {
    return {hxhx - other.hxhx, hxhz - other.hxhz, hzhz - other.hzhz,
            hxu - other.hxu,   hzu - other.hzu,   uu - other.uu};
  }
  LineInformation operator+(const LineInformation& other) const {
    return {hxhx + other.hxhx, hxhz + other.hxhz, hzhz + other.hzhz,
            hxu + other.hxu,   hzu + other.hzu,   uu + other.uu};
  }

  double determinant() const { return hxhx * hzhz - hxhz * hxhz; }
  /// The best line.
  InverseLine line() const {
    const double d = determinant();
    return {(hzhz * hxu - hxhz * hzu) / d, (hxhx * hzu - hxhz * hxu) / d};
  }
  /// Chi² of the readings about their best line.
  double chi_squared() const {
    const double gain =
        (hzhz * hxu * hxu - 2 * hxhz * hxu * hzu + hxhx * hzu * hzu) / determinant();
    return std::max(0.0, uu - gain);
  }
  /// Chi² of the readings about a given line.
  double chi_squared(const InverseLine& m) const {
    return std::max(0.0, uu - 2 * (m.x * hxu + m.z * hzu) + m.x * m.x * hxhx +
                             2 * m.x * m.z * hxhz + m.z * m.z * hzhz);
  }
};

/// Running sums of a scan's readings: the information of any run [begin, end) in constant time.
class LineInformationSums {
 public:
  void clear() { sums_.assign(1, {}); }
  std::size_t size() const { return sums_.size() - 1; }

  /// Adds a reading whose ray starts at (origin_x, origin_z) in direction (direction_x,
  /// direction_z), with weight 1 / variance, or 0 to leave it out.
  void add(double direction_x, double direction_z, double origin_x, double origin_z, double u,
           double weight) {
    const double hx = direction_x + u * origin_x;
    const double hz = direction_z + u * origin_z;
    const double wx = weight * hx;
    const double wz = weight * hz;
    const double wu = weight * u;
    const LineInformation& last = sums_.back();
    sums_.push_back({last.hxhx + wx * hx, last.hxhz + wx * hz, last.hzhz + wz * hz,
                     last.hxu + wx * u, last.hzu + wz * u, last.uu + wu * u});
  }

  LineInformation of(std::size_t begin, std::size_t end) const { return sums_[end] - sums_[begin]; }

 private:
  std::vector<LineInformation> sums_ = std::vector<LineInformation>(1);
};

}  // namespace ilss
