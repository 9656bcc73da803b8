#include "sensors/features/fixate.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "framework/estimate/angle.h"

namespace ilss {
namespace {

/// From straight ahead to the left, of a place right and ahead.
double to_the_left(double x, double z) { return std::atan2(-x, z); }

/// The place of a corner or an edge, which have it in the same components.
struct Place {
  static constexpr std::size_t of_x = index_of<Corner>("x");
  static constexpr std::size_t of_z = index_of<Corner>("z");
  static_assert(of_x == index_of<SurfaceEdge>("x") && of_z == index_of<SurfaceEdge>("z"));

  double x;
  double z;

  explicit Place(const Estimate& feature) : x(feature.value[of_x]), z(feature.value[of_z]) {}
};

}  // namespace

void Fixate::Options::declare(OptionVisitor& visit) {
  visit("edge", edge, "which edges count");
  visit("bearing", bearing,
        "it starts with the edge nearest to this direction, from straight ahead to the left",
        {.unit = "rad"});
  visit("gate", gate, "how far from where it is expected an edge may be",
        {.unit = "m", .minimum = 0});
  visit("patience", patience, "scans that a lost edge is expected to go on", {.minimum = 0});
  visit("stop", stop, "how far the head turns to either side", {.unit = "rad", .minimum = 0});
}

Interface Fixate::interface() {
  return {.inputs = {{"features", &descriptor<RangeFeatures>()}},
          .output = &descriptor<HeadAngle>(),
          .frame_of_input = 0};
}

void Fixate::reset() {
  last_.reset();
  before_.reset();
  missed_ = 0;
}

double Fixate::expected_bearing() const {
  if (!last_) return options_.bearing;
  const Place place(last_->place);
  return to_the_left(place.x, place.z);
}

/// Whether a feature is an edge of the kind that counts: a corner, a jump, or either.
bool Fixate::is_wanted(const Estimate& feature) const {
  const bool is_corner = feature.type->name == Corner<double>::name;
  const bool is_jump = feature.type->name == SurfaceEdge<double>::name;
  return (is_corner && options_.edge != FixatedEdge::jump) ||
         (is_jump && options_.edge != FixatedEdge::corner);
}

const Estimate* Fixate::choose(std::span<const Estimate> features, double time) const {
  const Estimate* best = nullptr;
  double least = INFINITY;
  double expected_x = 0;
  double expected_z = 0;
  const bool follows = last_ && missed_ <= options_.patience;
  if (follows) {
    const Place last(last_->place);
    expected_x = last.x;
    expected_z = last.z;
    if (before_ && last_->time > before_->time) {
      const Place before(before_->place);
      const double share = (time - last_->time) / (last_->time - before_->time);
      expected_x += share * (last.x - before.x);
      expected_z += share * (last.z - before.z);
    }
  }
  for (const Estimate& feature : features) {
    if (!is_wanted(feature)) continue;
    const Place place(feature);
    const double distance =
        follows ? std::hypot(place.x - expected_x, place.z - expected_z)
                : std::abs(wrap_angle(to_the_left(place.x, place.z) - expected_bearing()));
    if (distance >= least || (follows && distance > options_.gate)) continue;
    least = distance;
    best = &feature;
  }
  return best;
}

Outcome<> Fixate::evaluate(const Evaluation& evaluation, Output& output) {
  const Output& features = *evaluation.inputs[0];
  const double time = seconds(evaluation.time);
  const Estimate* edge = choose(features.elements, time);
  if (edge == nullptr) {
    ++missed_;
    return Fault{FaultKind::no_detection,
                 last_ ? "the edge is not where it is expected" : "the scan has no such edge"};
  }
  if (missed_ > options_.patience) last_.reset();
  missed_ = 0;
  before_ = std::move(last_);
  last_ = Sighting{time, *edge};
  // The head looks where the edge will be one scan later: as far on as it came since the last one.
  const double lead = before_ ? 1 : 0;
  const auto at = [&](std::size_t i) {
    const double now = last_->place.value[i];
    return before_ ? now + lead * (now - before_->place.value[i]) : now;
  };
  const double x = at(Place::of_x);
  const double z = at(Place::of_z);
  const double mount = payload_of<Parameters>(evaluation.parameters).mount_heading;
  const double angle = wrap_angle(to_the_left(x, z) - mount);
  if (!(std::abs(angle) <= options_.stop))
    return Fault{FaultKind::out_of_range,
                 fmt::format("the edge is at {:.1f} deg, behind the head's stop at {:.1f} deg",
                             angle / radians_per_degree, options_.stop / radians_per_degree)};
  assign<HeadAngle>(output.estimate, {angle});
  const double square = x * x + z * z;
  // An edge also has a direction, which does not matter.
  std::array<double, dimension_of<SurfaceEdge>> by_now{};
  by_now[Place::of_x] = -(1 + lead) * z / square;
  by_now[Place::of_z] = (1 + lead) * x / square;
  std::array<double, dimension_of<SurfaceEdge>> by_before{};
  by_before[Place::of_x] = lead * z / square;
  by_before[Place::of_z] = -lead * x / square;
  const double by_mount = -1;
  std::array<LineageTerm, 3> terms{{{by_now.data(), &last_->place.lineage},
                                    {&by_mount, &evaluation.parameters.lineage},
                                    {by_before.data(), nullptr}}};
  if (before_) terms[2].lineage = &before_->place.lineage;
  compose({terms.data(), before_ ? terms.size() : 2}, 1, output.estimate.lineage);
  return {};
}

}  // namespace ilss
