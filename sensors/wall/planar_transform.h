// Moves wall points from one frame into another, with the error of the mount between them.
#pragma once

#include <array>
#include <cmath>
#include <string>

#include "framework/module/function_module.h"
#include "sensors/wall/wall_points.h"

namespace ilss {

/// Which way a frame's axes point: camera has x to the right and z forward; robot has x forward and
/// z to the right.
enum class PlaneAxes { camera, robot };
constexpr std::array<std::string_view, 2> choices(PlaneAxes) { return {"camera", "robot"}; }

/// Function module: p_to = mount + R(heading) p_from, p_from first turned into x forward and z to
/// the right. The output has the robot's axes. The mount's uncertainty passes into the points.
class PlanarTransform {
 public:
  static constexpr std::string_view name = "planar_transform";
  static constexpr std::string_view description =
      "wall points from a mounted sensor's frame into the robot's";
  static constexpr std::array<std::string_view, 1> inputs = {"points"};

  template <typename T>
  struct Parameters {
    T x, z, heading;
    static constexpr std::string_view name = "planar_transform_parameters";
    static constexpr auto fields =
        Fields{{"mount.x", "m", "the input frame's origin, forward in the output frame", 0},
               {"mount.z", "m", "the input frame's origin, to the right in the output frame", 0},
               {"mount.heading", "rad", "where the input frame looks, positive to the right", 0,
                Geometry::circular}};
  };

  struct Options {
    std::string from = "camera";
    std::string to = "robot";
    PlaneAxes axes = PlaneAxes::camera;
    void declare(OptionVisitor& visit);
  };

  static void set_frames(Interface& interface, const Options& options);

  explicit PlanarTransform(const Options& options) : axes_(options.axes) {}

  template <typename T>
  Outcome<WallPoints<T>> operator()(const Parameters<T>& mount, const WallPoints<T>& points) const {
    using std::cos;
    using std::sin;
    const T c = cos(mount.heading);
    const T s = sin(mount.heading);
    const bool camera = axes_ == PlaneAxes::camera;
    const auto move = [&](const T& x, const T& z, T& out_x, T& out_z) {
      const T& forward = camera ? z : x;
      const T& right = camera ? x : z;
      out_x = mount.x + c * forward - s * right;
      out_z = mount.z + s * forward + c * right;
    };
    WallPoints<T> out{};
    move(points.x1, points.z1, out.x1, out.z1);
    move(points.x2, points.z2, out.x2, out.z2);
    out.label = points.label;
    return out;
  }

 private:
  PlaneAxes axes_;
};

}  // namespace ilss
