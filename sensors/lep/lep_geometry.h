// The ranging geometry of the LEP sensor: image position and scan angle against range.
#pragma once

#include <cmath>
#include <numbers>

namespace ilss {

/// The sensor's intrinsic parameters (Pears 1997, figure 2). The projection frame has its origin
/// where the laser turns, x to the right and z forward. The defaults are the shipped sensor's: f
/// and d are not published, but their product follows from Table 2.
template <typename T>
struct LepGeometry {
  T focal_length = T(0.05);  ///< f (m)
  T baseline = T(0.086);     ///< d, from the laser's to the lens's centre of turning (m)
  T vergence = T(7.07 * std::numbers::pi / 180);  ///< gamma, of the lens towards the laser (rad)
  T lens_distance = T(0.06);  ///< s, of the lens behind its centre of turning (m)
};

/// The two factors of the geometry at a scan angle (rad, from z towards x):
///   A = d (sin theta - cos theta tan gamma) - s / cos gamma,   B = d (cos theta + sin theta tan
///   gamma)
/// so that, with z = r cos theta in equation 10, p (u A - 1) = f (tan gamma - u B) for an object at
/// inverse range u = 1 / r: equations 6 and 10 in a form without their division by p, which passes
/// through 0 inside the field.
template <typename T>
struct LepRay {
  T a, b, focal_tangent, focal_length;

  /// `Angle` is T, or double where the scan angle is exact.
  template <typename Angle>
  LepRay(const LepGeometry<T>& g, const Angle& scan_angle) {
    using std::cos;
    using std::sin;
    using std::tan;
    const Angle c = cos(scan_angle);
    const Angle s = sin(scan_angle);
    const T tangent = tan(g.vergence);
    a = g.baseline * (s - c * tangent) - g.lens_distance / cos(g.vergence);
    b = g.baseline * (c + s * tangent);
    focal_tangent = g.focal_length * tangent;
    focal_length = g.focal_length;
  }

  /// The inverse range (1/m) of what is seen at image position p (m); equation 6.
  T inverse_range(const T& p) const { return (p + focal_tangent) / (p * a + focal_length * b); }
  /// The image position (m) of an object at inverse range u (1/m); equation 10.
  T image_position(const T& u) const {
    return (focal_tangent - focal_length * b * u) / (a * u - T(1));
  }
};

}  // namespace ilss
