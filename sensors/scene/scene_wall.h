// The true pose of a simulated wall: ground truth that is a module like any other.
#pragma once

#include "framework/module/module_type.h"
#include "sensors/scene/scene.h"
#include "sensors/wall/wall_pose.h"

namespace ilss {

/// Gives the exact wall_pose of one wall of a scene as seen from the robot, without any error, so
/// that a study can judge estimates of that wall against it. The wall's line counts, not its ends.
/// Frame: "robot". Faults: degenerate where the line passes through the robot's origin.
class SceneWall final : public Module {
 public:
  static constexpr std::string_view name = "scene_wall";
  static constexpr std::string_view description =
      "the exact pose of a simulated wall, as truth to judge estimates by";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static constexpr std::array faults = {FaultKind::degenerate};

  template <typename T>
  struct Parameters {
    T robot_x, robot_z, robot_heading;
    static constexpr std::string_view name = "scene_wall_parameters";
    static constexpr auto fields = Fields{
        {"robot.x", "m", "where the robot stands in the scene", 0},
        {"robot.z", "m", "where the robot stands in the scene", 0},
        {"robot.heading", "rad", "where it looks, positive to the right", 0, Geometry::circular}};
  };

  struct Options {
    FileOf<Scene> scene;
    std::int64_t wall = 0;
    void declare(OptionVisitor& visit);
  };

  static Interface interface();

  explicit SceneWall(Options options) : options_(std::move(options)) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;

 private:
  Options options_;
};

}  // namespace ilss
