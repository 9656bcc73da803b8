#include "src/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "framework/report/set_text.h"
#include "sensors/features/range_features.h"
#include "sensors/laser/laser_mount.h"
#include "sensors/laser/scan_points.h"
#include "sensors/range/range_scan.h"

namespace ilss {
namespace {

/// Where in a payload's components a place stands.
struct Place {
  std::size_t right;
  std::size_t up;
  PictureAxes axes;
};

std::optional<std::size_t> find_length(const PayloadDescriptor& payload, const std::string& name) {
  const auto found = payload.find(name);
  return found && payload.components[*found].unit == "m" ? found : std::nullopt;
}

/// In the robot's plane x is forward, in a sensor's z: forward is up.
bool is_robot(const std::string& frame) { return frame == "robot"; }

/// The place whose components' names begin with `prefix`: "start_x" and "start_z".
std::optional<Place> find_place(const Estimate& estimate, const std::string& prefix) {
  const PayloadDescriptor& payload = *estimate.type;
  const auto x = find_length(payload, prefix + "x");
  if (!x) return std::nullopt;
  if (const auto z = find_length(payload, prefix + "z"))
    return is_robot(estimate.frame) ? Place{*z, *x, {.right = "z", .up = "x"}} : Place{*x, *z, {}};
  if (const auto y = find_length(payload, prefix + "y"))
    return Place{*y, *x, {.right = "y", .up = "x", .right_sign = -1}};
  return std::nullopt;
}

UncertainPoint point_at(const Estimate& estimate, const Place& place) {
  const double sign = place.axes.right_sign;
  const Eigen::MatrixXd covariance = estimate.lineage.covariance();
  const auto right = static_cast<Eigen::Index>(place.right);
  const auto up = static_cast<Eigen::Index>(place.up);
  UncertainPoint point;
  point.at << sign * estimate.value[place.right], estimate.value[place.up];
  point.covariance << covariance(right, right), sign * covariance(right, up),
      sign * covariance(up, right), covariance(up, up);
  return point;
}

/// Adds what an estimate's components say of its place; the axes in which they do so, if any.
std::optional<PictureAxes> add_estimate(const Estimate& estimate, PictureLayer& layer) {
  const PayloadDescriptor& type = *estimate.type;
  const auto start = find_place(estimate, "start_");
  const auto end = find_place(estimate, "end_");
  if (start && end) {
    PictureStroke stroke{point_at(estimate, *start),
                         point_at(estimate, *end),
                         {},
                         type.name + "  " + component_line(estimate)};
    if (const auto centre = find_place(estimate, "centre_"))
      stroke.centre = point_at(estimate, *centre).at;
    layer.strokes.push_back(std::move(stroke));
    return start->axes;
  }
  const auto place = find_place(estimate, "");
  if (!place) return std::nullopt;
  const bool is_jump = type.name == SurfaceEdge<double>::name;
  layer.marks.push_back(
      {point_at(estimate, *place), is_jump, type.name + "  " + component_line(estimate)});
  return place->axes;
}

/// Adds the readings of a scan, and the field in which it looked.
PictureAxes add_scan(const Output& scan, PictureLayer& layer) {
  const auto readings = readings_of(scan);
  const bool x_is_up = is_robot(scan.estimate.frame);
  PictureAxes axes = x_is_up ? PictureAxes{.right = "z", .up = "x"} : PictureAxes{};
  if (readings.empty()) return axes;
  const auto place = [&](double x, double z) {
    return x_is_up ? Eigen::Vector2d(z, x) : Eigen::Vector2d(x, z);
  };
  const auto along = [&](const RangeReading& reading, double range) {
    return place(range * std::cos(reading.bearing), range * std::sin(reading.bearing));
  };
  const auto origin = [&](const RangeReading& reading) {
    return place(reading.origin_x, reading.origin_z);
  };
  std::vector<double> ranges;
  for (const RangeReading& reading : readings) {
    const double range = 1 / reading.inverse_range;
    if (!std::isfinite(range)) continue;
    ranges.push_back(range);
    layer.readings.push_back({origin(reading) + along(reading, range),
                              along(reading, reading.deviation * range * range)});
  }
  if (ranges.empty()) return axes;
  // Up to the first and last reading, but hardly farther than nearly all of them: a reading of
  // nothing may be anywhere.
  const auto most = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() * 95 / 100);
  std::nth_element(ranges.begin(), most, ranges.end());
  const double far = 1.2 * *most;
  const auto border = [&](const RangeReading& reading) -> Eigen::Vector2d {
    return origin(reading) + along(reading, std::min(far, 1 / reading.inverse_range));
  };
  layer.field = {origin(readings.back()), border(readings.front()), border(readings.back()), far};
  return axes;
}

/// What a node's output looks like, in which frame and axes.
struct DrawnLayer {
  PictureLayer layer;
  std::string frame;
  PictureAxes axes = {};
};

/// Whether a later module gives the same scan again, corrected.
bool is_corrected(const Plan& plan, std::size_t scan) {
  for (const PlanNode& node : plan.nodes)
    if (node.interface.output == plan.nodes[scan].interface.output)
      for (const PlanInput& input : node.inputs)
        if (input.node == scan) return true;
  return false;
}

/// Adds a laser's returns, in the robot's plane by the mount that the scan carries.
DrawnLayer draw_laser_scan(const Plan& plan, std::size_t node, const Output& scan) {
  DrawnLayer drawn{{plan.nodes[node].name, samples_text(scan)}, "robot", {.right = "z", .up = "x"}};
  if (is_corrected(plan, node)) return drawn;
  const LaserMount mount = mount_of(scan.estimate);
  const Eigen::Vector2d origin(mount.z, mount.x);
  const double deviation = noise_of(scan.estimate).range_deviation();
  std::vector<Eigen::Vector2d> points;
  for (const LaserBeam& beam : beams_of(scan)) {
    if (!(beam.range > 0)) continue;
    const double bearing = mount.heading - beam.bearing;
    const Eigen::Vector2d along(std::sin(bearing), std::cos(bearing));
    points.emplace_back(origin + beam.range * along);
    drawn.layer.readings.push_back({points.back(), deviation * along});
  }
  if (!points.empty())
    drawn.layer.field = {origin, points.front(), points.back(),
                         (points.front() - origin).norm() + (points.back() - origin).norm()};
  return drawn;
}

DrawnLayer draw(const Plan& plan, std::size_t node, const Output& output) {
  if (output.estimate.type->name == LaserScan<double>::name)
    return draw_laser_scan(plan, node, output);
  const std::string& module = plan.nodes[node].name;
  PictureLayer layer{module, samples_text(output)};
  PictureAxes axes;
  if (output.estimate.type->name == RangeScan<double>::name) {
    axes = add_scan(output, layer);
    return {std::move(layer), plan.nodes[node].frame, axes};
  }
  if (output.estimate.type->element.empty()) {
    layer.content = output.estimate.type->name;
    axes = add_estimate(output.estimate, layer).value_or(axes);
    return {std::move(layer), plan.nodes[node].frame, axes};
  }
  layer.content = element_counts_text(output.elements);
  for (const Estimate& element : output.elements)
    axes = add_estimate(element, layer).value_or(axes);
  return {std::move(layer), plan.nodes[node].frame, axes};
}

}  // namespace

std::optional<Picture> picture_of(const System& system, double time) {
  const Plan& plan = system.plan();
  std::vector<DrawnLayer> layers(system.size());
  for (std::size_t i = 0; i < system.size(); ++i)
    if (system.node(i).outcome.has_output()) layers[i] = draw(plan, i, system.node(i).output());
  std::vector<std::size_t> order = plan.outputs;
  for (std::size_t i = 0; i < system.size(); ++i) order.push_back(i);
  const auto first = std::find_if(order.begin(), order.end(),
                                  [&](std::size_t i) { return !layers[i].layer.empty(); });
  if (first == order.end()) return std::nullopt;

  Picture picture{
      .title = plan.description.empty() ? plan.name : plan.description,
      .subtitle = fmt::format("{}, tick {} at {:.3f} s", plan.name, system.ticks() - 1, time),
      .frame = layers[*first].frame,
      .axes = layers[*first].axes};
  if (!picture.frame.empty()) picture.subtitle += ", frame " + picture.frame;
  for (std::size_t i = 0; i < system.size(); ++i) {
    auto scene = scene_behind(system, i, time);
    if (scene && scene->frame == picture.frame) picture.scenes.push_back(std::move(*scene));
    if (layers[i].layer.empty()) continue;
    const std::string& frame = layers[i].frame;
    if (frame == picture.frame)
      picture.layers.push_back(std::move(layers[i].layer));
    else
      picture.left_out.push_back(fmt::format("'{}' is in frame {}, the picture in {}: left out",
                                             plan.nodes[i].name, frame.empty() ? "(none)" : frame,
                                             picture.frame.empty() ? "(none)" : picture.frame));
  }
  return picture;
}

}  // namespace ilss
