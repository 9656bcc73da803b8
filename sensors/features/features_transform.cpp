#include "sensors/features/features_transform.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace ilss {
namespace {

/// Which components are a place, and which are a line.
struct PlaceParts {
  int x, z;
};
struct LineParts {
  int rho, phi;
};

template <template <typename> class Feature>
consteval int part(std::string_view name) {
  return static_cast<int>(index_of<Feature>(name));
}

template <template <typename> class Feature>
consteval PlaceParts place(std::string_view x, std::string_view z) {
  return {part<Feature>(x), part<Feature>(z)};
}

/// Where a type of feature keeps what turns and moves.
struct FeatureParts {
  const PayloadDescriptor* type;
  std::vector<PlaceParts> places;
  std::optional<LineParts> line = {};
  std::optional<int> edge_phi = {};  ///< of an edge, whose place is the first
};

const FeatureParts* parts_of(const PayloadDescriptor* type) {
  static const std::array<FeatureParts, 4> known = {
      {{&descriptor<LineSegment>(),
        {place<LineSegment>("start_x", "start_z"), place<LineSegment>("end_x", "end_z")},
        LineParts{part<LineSegment>("rho"), part<LineSegment>("phi")}},
       {&descriptor<ArcSegment>(),
        {place<ArcSegment>("centre_x", "centre_z"), place<ArcSegment>("start_x", "start_z"),
         place<ArcSegment>("end_x", "end_z")}},
       {&descriptor<Corner>(), {place<Corner>("x", "z")}},
       {&descriptor<SurfaceEdge>(), {place<SurfaceEdge>("x", "z")}, {}, part<SurfaceEdge>("phi")}}};
  const auto* const found = std::find_if(
      known.begin(), known.end(),
      [&](const FeatureParts& parts) { return type != nullptr && parts.type->name == type->name; });
  return found == known.end() ? nullptr : found;
}

/// The pose and the axes with what is computed from them once.
struct Motion {
  PlanarPose<double> pose;
  bool camera;
  double cosine = std::cos(pose.heading);
  double sine = std::sin(pose.heading);

  void move_place(const Estimate& feature, const PlaceParts& place, MovedFeature& moved) const {
    const auto [x, z] = place;
    const int forward = camera ? z : x;
    const int right = camera ? x : z;
    const double p = feature.value[static_cast<std::size_t>(forward)];
    const double q = feature.value[static_cast<std::size_t>(right)];
    const double across = cosine * p - sine * q;
    const double along = sine * p + cosine * q;
    moved.value[x] = pose.x + across;
    moved.value[z] = pose.z + along;
    moved.by_feature.row(x).setZero();
    moved.by_feature.row(z).setZero();
    moved.by_feature(x, forward) = moved.by_feature(z, right) = cosine;
    moved.by_feature(x, right) = -sine;
    moved.by_feature(z, forward) = sine;
    moved.by_pose.row(x) << 1, 0, -along;
    moved.by_pose.row(z) << 0, 1, across;
  }

  /// Turns a normal's direction; `flip` where it would point towards the origin.
  void turn(const Estimate& feature, int phi, bool flip, MovedFeature& moved) const {
    const double old = feature.value[static_cast<std::size_t>(phi)];
    moved.value[phi] = wrap_angle(direction(old) + (flip ? std::numbers::pi : 0));
    moved.by_feature.row(phi).setZero();
    moved.by_feature(phi, phi) = camera ? -1 : 1;
    moved.by_pose.row(phi) << 0, 0, 1;
  }

  void move_line(const Estimate& feature, const LineParts& line, MovedFeature& moved) const {
    const auto [rho, phi] = line;
    const double turned = direction(feature.value[static_cast<std::size_t>(phi)]);
    const double c = std::cos(turned);
    const double s = std::sin(turned);
    const double distance = feature.value[static_cast<std::size_t>(rho)] + c * pose.x + s * pose.z;
    const double by_turn = c * pose.z - s * pose.x;
    const double sign = distance < 0 ? -1 : 1;
    turn(feature, phi, distance < 0, moved);
    moved.value[rho] = sign * distance;
    moved.by_feature.row(rho).setZero();
    moved.by_feature(rho, rho) = sign;
    moved.by_feature(rho, phi) = sign * by_turn * (camera ? -1 : 1);
    moved.by_pose.row(rho) << sign * c, sign * s, sign * by_turn;
  }

  /// Of a normal after the turn.
  double direction(double phi) const {
    return (camera ? std::numbers::pi / 2 - phi : phi) + pose.heading;
  }
};

}  // namespace

MovedFeature move_feature(const Estimate& feature, const PlanarPose<double>& pose, PlaneAxes axes) {
  const FeatureParts& parts = *parts_of(feature.type);
  const auto n = static_cast<Eigen::Index>(feature.dimension());
  MovedFeature moved;
  moved.value = feature.vector();
  moved.by_feature.setIdentity(n, n);
  moved.by_pose.setZero(n, 3);
  const Motion motion{pose, axes == PlaneAxes::camera};
  for (const PlaceParts& place : parts.places) motion.move_place(feature, place, moved);
  if (parts.line) motion.move_line(feature, *parts.line, moved);
  if (parts.edge_phi) {
    const double phi = motion.direction(feature.value[static_cast<std::size_t>(*parts.edge_phi)]);
    const auto [x, z] = parts.places.front();
    const double distance = std::cos(phi) * moved.value[x] + std::sin(phi) * moved.value[z];
    motion.turn(feature, *parts.edge_phi, distance < 0, moved);
  }
  return moved;
}

void FeaturesTransform::Options::declare(OptionVisitor& visit) {
  visit("from", from, "name of the features' frame");
  visit("to", to, "name of the output's frame");
  visit("axes", axes, "of the features' frame: camera is x right, z forward; robot the reverse");
  visit("pose", pose, "mount: the parameters alone; input: they, in what a second input says");
  visit.require(from != to, "'from' and 'to' name the same frame");
}

Interface FeaturesTransform::interface(const Options& options) {
  Interface interface {
    .inputs = {{"features", &descriptor<RangeFeatures>(), options.from, false}},
    .output = &descriptor<RangeFeatures>(), .frame = options.to
  };
  if (options.pose == PoseSource::input)
    interface.inputs.push_back({"pose", &descriptor<PlanarPose>(), options.to, false});
  return interface;
}

FeaturesTransform::Pose FeaturesTransform::pose_of(const Evaluation& evaluation) const {
  const auto mount = payload_of<Parameters>(evaluation.parameters);
  Pose pose{
      {mount.x, mount.z, mount.heading}, Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero()};
  if (options_.pose == PoseSource::mount) return pose;
  const auto base = payload_of<PlanarPose>(evaluation.input(1));
  const double c = std::cos(base.heading);
  const double s = std::sin(base.heading);
  const double across = c * mount.x - s * mount.z;
  const double along = s * mount.x + c * mount.z;
  pose.value = {base.x + across, base.z + along, base.heading + mount.heading};
  pose.by_mount.topLeftCorner<2, 2>() << c, -s, s, c;
  pose.by_input.setIdentity();
  pose.by_input(0, 2) = -along;
  pose.by_input(1, 2) = across;
  return pose;
}

/// Writes the element of that index in the other frame.
Outcome<> FeaturesTransform::move(const Evaluation& evaluation, const Pose& pose, std::size_t index,
                                  Estimate& element) const {
  const Estimate& feature = evaluation.inputs[0]->elements[index];
  if (parts_of(feature.type) == nullptr)
    return Fault{FaultKind::bad_data,
                 fmt::format("an element is {}; expected {}",
                             feature.type != nullptr ? feature.type->name : "nothing",
                             RangeFeatures<double>::element)};
  const MovedFeature moved = move_feature(feature, pose.value, options_.axes);
  const MovedFeature::ByPose by_mount = moved.by_pose * pose.by_mount;
  const MovedFeature::ByPose by_input = moved.by_pose * pose.by_input;
  const std::size_t rows = feature.dimension();
  const std::array<LineageTerm, 3> all = {
      {{moved.by_feature.data(), &feature.lineage},
       {by_mount.data(), &evaluation.parameters.lineage},
       {by_input.data(), evaluation.inputs.size() > 1 ? &evaluation.input(1).lineage : nullptr}}};
  const std::span<const LineageTerm> terms(all.data(), evaluation.inputs.size() + 1);
  element.type = feature.type;
  element.frame = options_.to;
  element.labels = feature.labels;
  element.value.assign(moved.value.data(), moved.value.data() + rows);
  if (evaluation.correlation_unknown)
    compose_bounded(terms, rows,
                    evaluation.fresh(static_cast<std::uint32_t>(index * Fields::capacity)),
                    element.lineage);
  else
    compose(terms, rows, element.lineage);
  const std::span<const double> factor(element.lineage.factor().data(),
                                       rows * element.lineage.size());
  const auto finite = [](double number) { return std::isfinite(number); };
  if (std::all_of(element.value.begin(), element.value.end(), finite) &&
      std::all_of(factor.begin(), factor.end(), finite))
    return {};
  return Fault{
      FaultKind::not_finite,
      fmt::format("the moved {} of number {} in its set is not finite", feature.type->name, index)};
}

Outcome<> FeaturesTransform::evaluate(const Evaluation& evaluation, Output& output) {
  const Output& features = *evaluation.inputs[0];
  const Pose pose = pose_of(evaluation);
  output.elements.resize(features.elements.size());
  for (std::size_t i = 0; i < features.elements.size(); ++i)
    if (Outcome<> outcome = move(evaluation, pose, i, output.elements[i]); !outcome) return outcome;
  output.estimate.value = features.estimate.value;
  output.estimate.lineage = features.estimate.lineage;
  return {};
}

}  // namespace ilss
