// One range from one image position of the LEP sensor.
#pragma once

#include <array>
#include <cmath>
#include <string>

#include "framework/module/function_module.h"
#include "sensors/lep/lep_detector.h"
#include "sensors/lep/lep_geometry.h"

namespace ilss {

/// What a range sensor's ray met.
template <typename T>
struct RangePoint {
  T range, x, z;
  static constexpr std::string_view name = "range_point";
  static constexpr std::string_view documentation = "where a range sensor's ray ends";
  static constexpr auto fields = Fields{{"range", "m", "from where the rays start"},
                                        {"x", "m", "to the right"},
                                        {"z", "m", "forward"}};
};

/// Function module: the point r (sin theta, cos theta) that the laser lights at scan angle theta,
/// from z towards x, seen at image position p (Pears 1997, equations 3 to 6; in the form of LepRay,
/// which holds at p = 0, too). The covariance has the rank of its causes: one reading alone moves
/// the point along its ray.
/// Faults: out_of_range for an image that no point in front of the sensor gives, a focal length
/// that is not positive, or a scan angle or vergence of 90 deg or more.
class LepTriangulation {
 public:
  static constexpr std::string_view name = "lep_triangulation";
  static constexpr std::string_view description =
      "range and place of a lit point from its image position";
  static constexpr std::string_view reference = "Pears 1997, equations 3 to 6";
  static constexpr std::array<std::string_view, 1> inputs = {"image"};
  static constexpr std::array faults = {FaultKind::out_of_range, FaultKind::not_finite};

  template <typename T>
  struct Parameters {
    T focal_length, baseline, vergence, lens_distance, scan_angle;
    static constexpr std::string_view name = "lep_triangulation_parameters";
    static constexpr auto fields = Fields{
        {"focal_length", "m", "f, from the lens to the detector",
         LepGeometry<double>().focal_length},
        {"baseline", "m", "d, from the laser's to the lens's centre of turning",
         LepGeometry<double>().baseline},
        {"vergence", "rad", "gamma, of the lens towards the laser", LepGeometry<double>().vergence},
        {"lens_distance", "m", "s, of the lens behind its centre of turning",
         LepGeometry<double>().lens_distance},
        {"scan_angle", "rad", "theta, of the laser, from z towards x", 0, Geometry::circular}};
  };

  struct Options {
    std::string frame = "projection";
    void declare(OptionVisitor& visit);
  };

  static void set_frames(Interface& interface, const Options& options);

  explicit LepTriangulation(const Options&) {}

  template <typename T>
  Outcome<RangePoint<T>> operator()(const Parameters<T>& parameters,
                                    const ImagePosition<T>& image) const {
    using std::cos;
    using std::sin;
    const double theta = scalar_value(parameters.scan_angle);
    const double gamma = scalar_value(parameters.vergence);
    if (!(std::cos(theta) > 0) || !(std::cos(gamma) > 0) ||
        !(scalar_value(parameters.focal_length) > 0))
      return impossible_sensor(theta, gamma);
    const LepRay<T> ray({parameters.focal_length, parameters.baseline, parameters.vergence,
                         parameters.lens_distance},
                        parameters.scan_angle);
    const T inverse_range = ray.inverse_range(image.position);
    // A point behind the sensor would give the same image where the denominator has passed 0.
    const double denominator = scalar_value(image.position * ray.a + ray.focal_length * ray.b);
    if (!(scalar_value(inverse_range) > 0) || !(denominator * scalar_value(ray.b) > 0))
      return impossible_image(scalar_value(image.position), theta);
    const T range = 1.0 / inverse_range;
    return RangePoint<T>{range, range * sin(parameters.scan_angle),
                         range * cos(parameters.scan_angle)};
  }

 private:
  static Fault impossible_sensor(double scan_angle, double vergence);
  static Fault impossible_image(double position, double scan_angle);
};

}  // namespace ilss
