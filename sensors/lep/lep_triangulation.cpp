#include "sensors/lep/lep_triangulation.h"

#include <fmt/format.h>

#include <numbers>

#include "framework/estimate/angle.h"

namespace ilss {
namespace {}  // namespace

void LepTriangulation::Options::declare(OptionVisitor& visit) {
  visit("frame", frame, "the frame of the point: origin where the laser turns, z along angle 0");
}

void LepTriangulation::set_frames(Interface& interface, const Options& options) {
  interface.frame = options.frame;
  interface.frame_of_input.reset();
}

Fault LepTriangulation::impossible_sensor(double scan_angle, double vergence) {
  return {
      FaultKind::out_of_range,
      fmt::format("the sensor needs a focal length above 0, and a scan angle ({:.2f} deg) and a "
                  "vergence ({:.2f} deg) within 90 deg",
                  scan_angle * degrees_per_radian, vergence * degrees_per_radian)};
}

Fault LepTriangulation::impossible_image(double position, double scan_angle) {
  return {FaultKind::out_of_range,
          fmt::format("no point in front of the sensor shows at {:.4f} mm when the laser points to "
                      "{:.2f} deg",
                      1e3 * position, scan_angle * degrees_per_radian)};
}

}  // namespace ilss
