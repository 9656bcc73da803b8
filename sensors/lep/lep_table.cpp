#include "sensors/lep/lep_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include "framework/estimate/angle.h"

namespace ilss {
namespace {

/// The different values of a member, rising.
std::vector<double> levels(std::span<const LepCalibrationPoint> points,
                           double LepCalibrationPoint::*member) {
  std::vector<double> values;
  values.reserve(points.size());
  for (const LepCalibrationPoint& point : points) values.push_back(point.*member);
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

std::size_t index_of(const std::vector<double>& levels, double value) {
  return static_cast<std::size_t>(std::lower_bound(levels.begin(), levels.end(), value) -
                                  levels.begin());
}

}  // namespace

Outcome<LepTable> LepTable::make(std::span<const LepCalibrationPoint> points) {
  LepTable table;
  table.angles_ = levels(points, &LepCalibrationPoint::scan_angle);
  table.depths_ = levels(points, &LepCalibrationPoint::depth);
  if (table.angles_.size() < 2 || table.depths_.size() < 2)
    return Fault{FaultKind::degenerate,
                 fmt::format("a table needs two scan angles and two depths, got {} and {}",
                             table.angles_.size(), table.depths_.size())};
  const std::size_t cells = table.angles_.size() * table.depths_.size();
  const auto irregular = [&](const char* what, double angle, double depth) {
    return Fault{FaultKind::bad_data,
                 fmt::format("{} reading at {:.4f} deg and {:.4f} m: a table has one at each of "
                             "its {} scan angles and {} depths",
                             what, angle * degrees_per_radian, depth, table.angles_.size(),
                             table.depths_.size())};
  };
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  table.positions_.assign(cells, none);
  for (const LepCalibrationPoint& point : points) {
    double& entry =
        table.positions_[index_of(table.angles_, point.scan_angle) * table.depths_.size() +
                         index_of(table.depths_, point.depth)];
    if (!std::isnan(entry)) return irregular("a second", point.scan_angle, point.depth);
    entry = point.image_position;
  }
  for (std::size_t i = 0; i < cells; ++i)
    if (std::isnan(table.positions_[i]))
      return irregular("no", table.angles_[i / table.depths_.size()],
                       table.depths_[i % table.depths_.size()]);
  return table;
}

Outcome<LepTableDepth> LepTable::invert_at(std::size_t angle, double image_position) const {
  std::optional<LepTableDepth> found;
  for (std::size_t d = 0; d + 1 < depths_.size(); ++d) {
    const double here = position(angle, d);
    const double next = position(angle, d + 1);
    const double offset = (image_position - here) / (next - here);
    // Where two cells meet, the farther one has the entry; the last has both of its own.
    const bool last = d + 2 == depths_.size();
    if (!(offset >= 0 && (offset < 1 || (last && offset == 1)))) continue;
    if (found)
      return Fault{
          FaultKind::ambiguous,
          fmt::format("near {:.3f} deg the table has an image at {:.4f} mm more than once, "
                      "between {:.3f} m and {:.3f} m",
                      angles_[angle] * degrees_per_radian, 1e3 * image_position, found->depth,
                      depths_[d])};
    const double gain = (depths_[d + 1] - depths_[d]) / (next - here);
    found = {depths_[d] + offset * (depths_[d + 1] - depths_[d]), gain};
  }
  if (!found)
    return Fault{FaultKind::out_of_range,
                 fmt::format("near {:.3f} deg the table has no image at {:.4f} mm",
                             angles_[angle] * degrees_per_radian, 1e3 * image_position)};
  return *found;
}

Outcome<LepTableDepth> LepTable::invert(double scan_angle, double image_position) const {
  if (!(scan_angle >= angles_.front() && scan_angle <= angles_.back()))
    return Fault{FaultKind::out_of_range,
                 fmt::format("the table reaches from {:.3f} to {:.3f} deg; {:.3f} deg lies outside",
                             angles_.front() * degrees_per_radian,
                             angles_.back() * degrees_per_radian, scan_angle * degrees_per_radian)};
  const std::size_t upper = index_of(angles_, scan_angle);
  auto at = invert_at(upper, image_position);
  if (!at || angles_[upper] == scan_angle) return at;
  const auto before = invert_at(upper - 1, image_position);
  if (!before) return before.fault();
  const double share = (scan_angle - angles_[upper - 1]) / (angles_[upper] - angles_[upper - 1]);
  return LepTableDepth{std::lerp(before->depth, at->depth, share),
                       std::lerp(before->gain, at->gain, share)};
}

LepTableError table_error(const LepTable& table, const LepGeometry<double>& geometry,
                          const LepScanOrigin& origin) {
  LepTableError error;
  const auto angles = table.scan_angles();
  const auto depths = table.depths();
  double squares = 0;
  for (std::size_t a = 0; a + 1 < angles.size(); ++a) {
    for (std::size_t d = 0; d + 1 < depths.size(); ++d) {
      const double angle = std::midpoint(angles[a], angles[a + 1]);
      const double depth = std::midpoint(depths[d], depths[d + 1]);
      ++error.cells;
      const auto read = table.invert(angle, model_image_position(geometry, origin, angle, depth));
      if (!read) continue;
      ++error.inverted;
      const double difference = read->depth - depth;
      squares += difference * difference;
      if (std::abs(difference) > std::abs(error.largest)) error.largest = difference;
    }
  }
  if (error.inverted > 0) error.rms = std::sqrt(squares / static_cast<double>(error.inverted));
  return error;
}

LepTableError interpolation_error(const LepTable& table, const LepGeometry<double>& geometry,
                                  const LepScanOrigin& origin) {
  std::vector<LepCalibrationPoint> points;
  for (const double angle : table.scan_angles())
    for (const double depth : table.depths())
      points.push_back({.scan_angle = angle,
                        .depth = depth,
                        .image_position = model_image_position(geometry, origin, angle, depth)});
  const auto exact = LepTable::make(points);
  return table_error(*exact, geometry, origin);
}

}  // namespace ilss
