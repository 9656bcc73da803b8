// Runs an extractor over LEP scans or given readings, and judges its features against the truth.
#pragma once

#include <string>
#include <vector>

#include "framework/estimate/consistency.h"
#include "sensors/features/range_features.h"
#include "sensors/range/line_extractor.h"
#include "tests/sensors/lep_rig.h"
#include "tests/sensors/module_run.h"

namespace ilss {

inline ModuleRun extract(Module& extractor, const Output& scan, std::int64_t tick = 0) {
  Tick at;
  at.inputs = {&scan};
  at.tick = tick;
  return run(extractor, at);
}

/// The elements of a type, in order.
template <template <typename> class Payload>
std::vector<const Estimate*> elements_of(const Output& features) {
  std::vector<const Estimate*> list;
  for (const Estimate& element : features.elements)
    if (element.type->name == Payload<double>::name) list.push_back(&element);
  return list;
}

/// Segments and arcs, in order.
inline std::vector<const Estimate*> segments_of(const Output& features) {
  std::vector<const Estimate*> list;
  for (const Estimate& element : features.elements)
    if (element.type->name == LineSegment<double>::name ||
        element.type->name == ArcSegment<double>::name)
      list.push_back(&element);
  return list;
}

/// The normalised error of some components of an estimate, one after another from `first`.
inline NormalizedError error_of(const Estimate& estimate, std::size_t first,
                                const std::vector<double>& truth) {
  std::vector<double> all = estimate.value;
  std::copy(truth.begin(), truth.end(), all.begin() + static_cast<std::ptrdiff_t>(first));
  const auto at = static_cast<Eigen::Index>(first);
  const Eigen::VectorXd error =
      difference(estimate, all).segment(at, static_cast<Eigen::Index>(truth.size()));
  return normalized_squared_error(
      error, estimate.lineage.covariance().block(at, at, error.size(), error.size()));
}

/// A line's distance and the direction of its normal.
inline std::vector<double> rho_phi(const InverseLine& line) {
  return {1 / std::hypot(line.x, line.z), std::atan2(line.z, line.x)};
}

/// Where a reading's ray meets a line.
inline std::vector<double> point_on(const RangeReading& r, const InverseLine& m) {
  const double c = std::cos(r.bearing);
  const double s = std::sin(r.bearing);
  const double range = (1 - m.x * r.origin_x - m.z * r.origin_z) / (m.x * c + m.z * s);
  return {r.origin_x + range * c, r.origin_z + range * s};
}

/// The reading whose ray passes nearest to a point.
inline const RangeReading& reading_at(std::span<const RangeReading> readings, double x, double z) {
  const RangeReading* best = readings.data();
  const auto off = [&](const RangeReading& r) {
    return std::abs(wrap_angle(std::atan2(z - r.origin_z, x - r.origin_x) - r.bearing));
  };
  for (const RangeReading& r : readings)
    if (off(r) < off(*best)) best = &r;
  return *best;
}

/// Whether any number of an output, or of its errors, is not finite.
inline bool all_finite(const Output& output) {
  const auto finite = [](const Estimate& estimate) {
    for (const double v : estimate.value)
      if (!std::isfinite(v)) return false;
    return estimate.lineage.factor().allFinite();
  };
  for (const Estimate& element : output.elements)
    if (!finite(element)) return false;
  return finite(output.estimate);
}

}  // namespace ilss
