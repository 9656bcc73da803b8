// Geometry of two sonars that see one wall: which wall gives both ranges, and where it is touched.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include "framework/estimate/differentiate.h"
#include "sensors/sonar/sonar_reading.h"
#include "sensors/wall/wall_points.h"

namespace ilss {

/// Where in its beam a sonar touches the wall: on the edge to the left (-), at the foot of the
/// perpendicular (0), or on the edge to the right (+).
enum class Contact { left_edge = -1, tangent = 0, right_edge = 1 };

/// The contacts of both sonars as an index into `wall_contacts`: "(0,+)".
int contact_label(Contact left, Contact right);

/// A straight wall: unit normal (cos bearing, sin bearing), distance n · p = `range` of its points.
/// Range is signed here: a wall between the frame's origin and a sonar that looks at it from
/// beyond has it negative.
struct WallLine {
  double range;
  double bearing;
};

/// A wall that gives both readings.
struct WedgeSolution {
  Contact left;
  Contact right;
  int root;  ///< which of a case's two tangents: +1 or -1
  WallLine wall;
};

/// Every wall that gives both readings; at most two for each of the nine cases.
class WedgeSolutions {
 public:
  static constexpr std::size_t capacity = 18;

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const WedgeSolution& operator[](std::size_t i) const { return solutions_[i]; }
  const WedgeSolution* begin() const { return solutions_.data(); }
  const WedgeSolution* end() const { return solutions_.data() + size_; }

  /// A whole family of walls fits as well: the geometry does not determine one.
  bool undetermined = false;

 private:
  friend WedgeSolutions solve_wedge(const SonarReading<double>&, const SonarReading<double>&);
  void add(const WedgeSolution& solution, bool inside);

  std::array<WedgeSolution, capacity> solutions_;
  std::array<bool, capacity> inside_;  ///< not on its case's boundary
  std::size_t size_ = 0;
};

/// Solves all nine cases in closed form and keeps the walls that reproduce both readings in their
/// own case; one found by two neighbouring cases (it lies on their boundary) counts once. Readings
/// must be positive and finite, beam half angles inside (0, pi/2).
WedgeSolutions solve_wedge(const SonarReading<double>& left, const SonarReading<double>& right);

/// The wall as people read it: "range 912 mm, angle -21.00 deg, contact (0,+)".
std::string describe(const WedgeSolution& solution);

/// What a contact says of a wall: n · (x, z) + offset = wall range. On a beam's edge (x, z) is the
/// touched point and offset is 0; for a tangent (x, z) is the sonar and offset its reading.
template <typename T>
struct ContactCondition {
  T x, z, offset;
};

template <typename T>
ContactCondition<T> contact_condition(const SonarReading<T>& sonar, Contact contact) {
  using std::cos;
  using std::sin;
  if (contact == Contact::tangent) return {sonar.mount_x, sonar.mount_z, sonar.range};
  const T direction =
      sonar.mount_heading + static_cast<double>(static_cast<int>(contact)) * sonar.beam_half_angle;
  return {sonar.mount_x + sonar.range * cos(direction),
          sonar.mount_z + sonar.range * sin(direction), T(0.0)};
}

/// The wall's normal from two conditions. Subtracting them, n · v = k |v| with v from the left
/// point to the right one and k = (left offset - right offset) / |v|, hence
/// n = k v/|v| + root sqrt(1 - k²) w, w being v/|v| turned from x to z by a right angle.
/// The square root is of (|v| - |difference|)(|v| + |difference|), exact for near-equal ones.
template <typename T>
std::array<T, 2> wedge_normal(const ContactCondition<T>& left, const ContactCondition<T>& right,
                              int root) {
  using std::sqrt;
  const T vx = right.x - left.x;
  const T vz = right.z - left.z;
  const T difference = left.offset - right.offset;
  const T squared = vx * vx + vz * vz;
  const T length = sqrt(squared);
  const T across = static_cast<double>(root) * sqrt((length - difference) * (length + difference));
  return {(difference * vx - across * vz) / squared, (difference * vz + across * vx) / squared};
}

/// The points where the two sonars touch the wall, in a given case.
template <typename T>
WallPoints<T> wedge_points(const SonarReading<T>& left, const SonarReading<T>& right,
                           const WedgeSolution& solution) {
  const auto l = contact_condition(left, solution.left);
  const auto r = contact_condition(right, solution.right);
  WallPoints<T> points{l.x, l.z, r.x, r.z, {contact_label(solution.left, solution.right)}};
  if (solution.left != Contact::tangent && solution.right != Contact::tangent) return points;
  const auto normal = wedge_normal(l, r, solution.root);
  points.x1 += l.offset * normal[0];
  points.z1 += l.offset * normal[1];
  points.x2 += r.offset * normal[0];
  points.z2 += r.offset * normal[1];
  return points;
}

}  // namespace ilss
