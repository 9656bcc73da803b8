// A simulated camera before a wall with a target, and the modules behind it, for the camera tests.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "sensors/camera/camera.h"
#include "sensors/camera/target_points.h"

namespace ilss {

inline constexpr double degree = std::numbers::pi / 180;

/// Range and angle of the wall as the robot sees it, as in Table 1 of Henderson & Dekhil 1997.
struct WallPoseTruth {
  double range;  ///< m
  double angle;  ///< rad
};
inline constexpr std::array<WallPoseTruth, 5> paper_poses = {{{0.919, -21 * degree},
                                                              {0.930, 20 * degree},
                                                              {1.242, 0},
                                                              {1.164, -11 * degree},
                                                              {1.283, 6 * degree}}};

/// A wall at x = 0 along z with stripes 300 mm apart, two of which bracket the optical axis from
/// each of the paper's poses.
inline constexpr double stripe_spacing = 0.3;
inline constexpr double target_height = 0.2;
inline constexpr double first_stripe = -1.391;  // z, m
inline Scene target_scene() {
  Scene scene;
  Wall wall;
  wall.from = {0, -3};
  wall.to = {0, 3};
  WallTarget target;
  target.along = first_stripe - wall.from.z;
  target.height = target_height;
  target.stripe_count = 10;
  target.stripe_spacing = stripe_spacing;
  target.line_length = 6;
  wall.targets.push_back(target);
  scene.walls.push_back(wall);
  return scene;
}

/// A module of one input run by hand.
struct CameraRig {
  Camera::Options options;
  Estimate parameters{descriptor<Camera::Parameters>()};
  Output image;

  explicit CameraRig(const Scene& scene = target_scene()) {
    options.input.scene.emplace();
    options.input.scene->content = scene;
  }

  double& parameter(const std::string& name) {
    return parameters.value[*descriptor<Camera::Parameters>().find(name)];
  }
  void place(const WallPoseTruth& pose) {
    parameter("robot.x") = -pose.range;
    parameter("robot.z") = 0;
    parameter("robot.heading") = -pose.angle;
  }
  Image<double> intrinsics() const {
    Image<double> result{};
    const auto out = components(result);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = parameters.value[i];
    return result;
  }
  /// Heights of the target's line at the three columns, by geometry (m on the image plane).
  TargetRows<double> true_rows(const WallPoseTruth& pose) const {
    const double heading = -pose.angle;
    const double focal = parameters.value[3];
    const double axis = pose.range * std::tan(heading);  // z where the optical axis meets the wall
    const double right =
        first_stripe + stripe_spacing * std::ceil((axis - first_stripe) / stripe_spacing);
    const auto height = [&](double z) {
      const double depth = std::cos(heading) * pose.range + std::sin(heading) * z;
      return focal * target_height / depth;
    };
    return {height(right - stripe_spacing), height(axis), height(right)};
  }
};

/// The evaluation of one module by hand.
inline Outcome<> run(Module& module, const Estimate& parameters, const Output* input,
                     std::uint64_t seed, Output& output, std::uint32_t owner = 1) {
  const std::array<const Output*, 1> inputs = {input};
  const Evaluation evaluation{
      static_cast<std::int64_t>(seed & 0xffff),   {}, seed, owner, parameters,
      {inputs.data(), input == nullptr ? 0u : 1u}};
  return module.evaluate(evaluation, output);
}

}  // namespace ilss
