#include "sensors/wall/wedge.h"

#include <fmt/format.h>

#include <numbers>

#include "framework/estimate/angle.h"

namespace ilss {
namespace {

constexpr double right_angle = std::numbers::pi / 2;
// How far outside its case's bounds a wall may lie and still count, so that rounding loses none on
// a boundary, where both neighbours give the same wall; twins closer than `same_wall` are one.
constexpr double boundary_tolerance = 1e-7;
constexpr double same_wall = 1e-6;
constexpr double grazing = 1e-6;
constexpr double rounding = 1e-12;

/// The normals (rad, relative to the beam's axis) under which a contact occurs.
struct Span {
  double from;
  double to;
};

Span span_of(const SonarReading<double>& sonar, Contact contact) {
  const double half_angle = sonar.beam_half_angle;
  switch (contact) {
    case Contact::left_edge:
      return {-half_angle - right_angle, -half_angle};
    case Contact::tangent:
      return {-half_angle, half_angle};
    case Contact::right_edge:
      return {half_angle, half_angle + right_angle};
  }
  return {};
}

/// Whether any wall touches both sonars in these ways, whatever the ranges.
bool spans_overlap(const SonarReading<double>& left, Contact left_contact,
                   const SonarReading<double>& right, Contact right_contact) {
  const Span l = span_of(left, left_contact);
  const Span r = span_of(right, right_contact);
  const double separation = wrap_angle(left.mount_heading + (l.from + l.to) / 2 -
                                       right.mount_heading - (r.from + r.to) / 2);
  return std::abs(separation) < (l.to - l.from + r.to - r.from) / 2;
}

/// How far inside a contact's span a wall's normal lies (rad); negative: outside. A wall that an
/// edge merely grazes would pass through the sonar itself: it counts as far outside.
double depth(const SonarReading<double>& sonar, Contact contact, double bearing) {
  const double delta = wrap_angle(bearing - sonar.mount_heading);
  if (contact == Contact::tangent) return sonar.beam_half_angle - std::abs(delta);
  const double beyond_edge = static_cast<int>(contact) * delta - sonar.beam_half_angle;
  if (beyond_edge >= right_angle - grazing) return -std::numbers::pi;
  return beyond_edge;
}

bool same_place_and_axis(const SonarReading<double>& left, const SonarReading<double>& right) {
  return std::hypot(left.mount_x - right.mount_x, left.mount_z - right.mount_z) <= rounding &&
         std::abs(wrap_angle(left.mount_heading - right.mount_heading)) <= rounding;
}

}  // namespace

int contact_label(Contact left, Contact right) {
  return 5 + 3 * static_cast<int>(left) + static_cast<int>(right);
}

void WedgeSolutions::add(const WedgeSolution& solution, bool inside) {
  for (std::size_t i = 0; i < size_; ++i) {
    const WallLine& other = solutions_[i].wall;
    if (std::abs(wrap_angle(other.bearing - solution.wall.bearing)) > same_wall ||
        std::abs(other.range - solution.wall.range) > same_wall)
      continue;
    if (inside && !inside_[i]) {
      solutions_[i] = solution;
      inside_[i] = true;
    }
    return;
  }
  solutions_[size_] = solution;
  inside_[size_++] = inside;
}

WedgeSolutions solve_wedge(const SonarReading<double>& left, const SonarReading<double>& right) {
  constexpr std::array contacts = {Contact::left_edge, Contact::tangent, Contact::right_edge};
  WedgeSolutions solutions;
  solutions.undetermined = same_place_and_axis(left, right);
  for (const Contact l : contacts) {
    const auto left_condition = contact_condition(left, l);
    for (const Contact r : contacts) {
      if (!spans_overlap(left, l, right, r)) continue;
      const auto right_condition = contact_condition(right, r);
      const double separation =
          std::hypot(right_condition.x - left_condition.x, right_condition.z - left_condition.z);
      const double difference = std::abs(left_condition.offset - right_condition.offset);
      if (difference > separation + rounding) continue;
      if (separation <= rounding) {
        solutions.undetermined = true;
        continue;
      }
      for (const int root : {-1, 1}) {
        const auto normal = wedge_normal(left_condition, right_condition, root);
        const WallLine wall{
            normal[0] * left_condition.x + normal[1] * left_condition.z + left_condition.offset,
            std::atan2(normal[1], normal[0])};
        const double inside = std::min(depth(left, l, wall.bearing), depth(right, r, wall.bearing));
        if (inside >= -boundary_tolerance) solutions.add({l, r, root, wall}, inside > 0);
      }
    }
  }
  return solutions;
}

std::string describe(const WedgeSolution& solution) {
  const bool behind = solution.wall.range < 0;
  const double angle = wrap_angle(solution.wall.bearing + (behind ? std::numbers::pi : 0.0));
  return fmt::format("range {:.1f} mm, angle {:.2f} deg, contact {}",
                     1e3 * std::abs(solution.wall.range), angle * 180 / std::numbers::pi,
                     wall_contacts[contact_label(solution.left, solution.right)]);
}

}  // namespace ilss
