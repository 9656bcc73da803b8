#include "framework/report/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "framework/module/column_numbers.h"
#include "framework/report/set_text.h"

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
  const bool is_jump = type.name == "edge";
  layer.marks.push_back(
      {point_at(estimate, *place), is_jump, type.name + "  " + component_line(estimate)});
  return place->axes;
}

/// The columns of a scan whose rays each have a place of their own.
struct RayColumns {
  ColumnNumbers origin_x, origin_z, bearing, inverse_range, deviation;

  static std::optional<RayColumns> find(const Output& output) {
    const auto origin_x = ColumnNumbers::find(output, "origin_x");
    const auto origin_z = ColumnNumbers::find(output, "origin_z");
    const auto bearing = ColumnNumbers::find(output, "bearing");
    const auto inverse_range = ColumnNumbers::find(output, "inverse_range");
    const auto deviation = ColumnNumbers::find(output, "deviation");
    if (!origin_x || !origin_z || !bearing || !inverse_range || !deviation) return std::nullopt;
    return RayColumns{*origin_x, *origin_z, *bearing, *inverse_range, *deviation};
  }
};

/// Adds the readings along rays, and the field in which the sensor looked.
PictureAxes add_rays(const RayColumns& rays, bool x_is_up, PictureLayer& layer) {
  PictureAxes axes = x_is_up ? PictureAxes{.right = "z", .up = "x"} : PictureAxes{};
  const std::size_t count = rays.bearing.size();
  const auto place = [&](double x, double z) {
    return x_is_up ? Eigen::Vector2d(z, x) : Eigen::Vector2d(x, z);
  };
  const auto along = [&](std::size_t i, double range) {
    return place(range * std::cos(rays.bearing[i]), range * std::sin(rays.bearing[i]));
  };
  const auto origin = [&](std::size_t i) { return place(rays.origin_x[i], rays.origin_z[i]); };
  std::vector<double> ranges;
  for (std::size_t i = 0; i < count; ++i) {
    const double range = 1 / rays.inverse_range[i];
    if (!std::isfinite(range)) continue;
    ranges.push_back(range);
    layer.readings.push_back(
        {origin(i) + along(i, range), along(i, rays.deviation[i] * range * range)});
  }
  if (ranges.empty()) return axes;
  // Up to the first and last reading, but hardly farther than nearly all of them: a reading of
  // nothing may be anywhere.
  const auto most = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() * 95 / 100);
  std::nth_element(ranges.begin(), most, ranges.end());
  const double far = 1.2 * *most;
  const auto border = [&](std::size_t i) -> Eigen::Vector2d {
    return origin(i) + along(i, std::min(far, 1 / rays.inverse_range[i]));
  };
  layer.field = {origin(count - 1), border(0), border(count - 1), far};
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

/// What a mounted scan says of itself by its columns and components.
struct MountedScan {
  ColumnNumbers bearing, range;
  double mount_x, mount_z, mount_heading;
  double range_deviation;

  static std::optional<MountedScan> find(const Output& output) {
    const auto bearing = ColumnNumbers::find(output, "bearing");
    const auto range = ColumnNumbers::find(output, "range");
    // One taken apart into segments shows the readings of the scan before it.
    if (!bearing || !range || ColumnNumbers::find(output, "segment")) return std::nullopt;
    std::array<double, 5> values{};
    constexpr std::array names = {"mount_x", "mount_z", "mount_heading", "range_std", "quantum"};
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto component = output.estimate.type->find(names[i]);
      if (!component) return std::nullopt;
      values[i] = output.estimate.value[*component];
    }
    const auto [x, z, heading, range_std, quantum] = values;
    return MountedScan{
        *bearing, *range, x, z, heading, std::sqrt(range_std * range_std + quantum * quantum / 12)};
  }
};

/// Adds the returns of a mounted scan in the robot's plane. A range of 0 is none.
void add_returns(const MountedScan& scan, PictureLayer& layer) {
  const Eigen::Vector2d origin(scan.mount_z, scan.mount_x);
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < scan.range.size(); ++i) {
    const double range = scan.range[i];
    if (!(range > 0)) continue;
    const double bearing = scan.mount_heading - scan.bearing[i];
    const Eigen::Vector2d along(std::sin(bearing), std::cos(bearing));
    points.emplace_back(origin + range * along);
    layer.readings.push_back({points.back(), scan.range_deviation * along});
  }
  if (!points.empty())
    layer.field = {origin, points.front(), points.back(),
                   (points.front() - origin).norm() + (points.back() - origin).norm()};
}

DrawnLayer draw(const Plan& plan, std::size_t node, const Output& output) {
  const std::string& frame = plan.nodes[node].frame;
  PictureLayer layer{plan.nodes[node].name, samples_text(output)};
  if (const auto rays = RayColumns::find(output)) {
    const PictureAxes axes = add_rays(*rays, is_robot(output.estimate.frame), layer);
    return {std::move(layer), frame, axes};
  }
  if (const auto scan = MountedScan::find(output)) {
    if (!is_corrected(plan, node)) add_returns(*scan, layer);
    return {std::move(layer), "robot", {.right = "z", .up = "x"}};
  }
  PictureAxes axes;
  if (output.estimate.type->element.empty()) {
    layer.content = output.estimate.type->name;
    axes = add_estimate(output.estimate, layer).value_or(axes);
    return {std::move(layer), frame, axes};
  }
  layer.content = element_counts_text(output.elements);
  for (const Estimate& element : output.elements)
    axes = add_estimate(element, layer).value_or(axes);
  return {std::move(layer), frame, axes};
}

}  // namespace

std::optional<Picture> picture_of(const TickView& tick, const SceneBehind& scene_behind) {
  const Plan& plan = tick.plan();
  std::vector<DrawnLayer> layers(tick.size());
  for (std::size_t i = 0; i < tick.size(); ++i)
    if (const Output* output = tick[i].output) layers[i] = draw(plan, i, *output);
  std::vector<std::size_t> order = plan.outputs;
  for (std::size_t i = 0; i < tick.size(); ++i) order.push_back(i);
  const auto first = std::find_if(order.begin(), order.end(),
                                  [&](std::size_t i) { return !layers[i].layer.empty(); });
  if (first == order.end()) return std::nullopt;

  Picture picture{.title = plan.description.empty() ? plan.name : plan.description,
                  .subtitle = fmt::format("{}, tick {} at {:.3f} s", plan.name, tick.tick(),
                                          seconds(tick.time())),
                  .frame = layers[*first].frame,
                  .axes = layers[*first].axes};
  if (!picture.frame.empty()) picture.subtitle += ", frame " + picture.frame;
  for (std::size_t i = 0; i < tick.size(); ++i) {
    auto scene = scene_behind ? scene_behind(i) : std::nullopt;
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
