#include "sensors/scene/scene_wall.h"

namespace ilss {

void SceneWall::Options::declare(OptionVisitor& visit) {
  visit("scene", scene, "the scene's file", {.required = true});
  visit("wall", wall, "which wall of the scene, counted from 0", {.minimum = 0});
  visit.require(
      scene.content.walls.empty() || wall < static_cast<std::int64_t>(scene.content.walls.size()),
      "the scene has fewer walls than the parameter 'wall' asks for");
}

Interface SceneWall::interface() { return {{}, &descriptor<WallPose>(), "robot", {}}; }

Outcome<> SceneWall::evaluate(const Evaluation& evaluation, Output& output) {
  const auto robot = payload_of<Parameters>(evaluation.parameters);
  const ScenePose pose{robot.robot_x, robot.robot_z, robot.robot_heading};
  const Wall& wall = options_.scene.content.walls[static_cast<std::size_t>(options_.wall)];
  const ScenePoint from = to_frame(pose, wall.from);
  const ScenePoint to = to_frame(pose, wall.to);
  const auto truth = wall_pose_through(from.x, from.z, to.x, to.z);
  if (!truth) return truth.fault();
  assign<WallPose>(output.estimate, *truth);
  return {};
}

}  // namespace ilss
