#include "src/picture_scene.h"

#include "sensors/laser/simulate/laser_scene.h"
#include "sensors/lep/lep_sensor.h"

namespace ilss {

namespace {

/// A scene as seen by something in it: the pose looks along the picture's up.
PictureScene seen_from(const ScenePose& pose, const Scene& scene, const std::string& module) {
  PictureScene result{.module = module, .frame = {}};
  const auto seen = [&](const ScenePoint& point) {
    const ScenePoint in_frame = to_frame(pose, point);
    return Eigen::Vector2d(in_frame.z, in_frame.x);
  };
  for (const Wall& wall : scene.walls) result.walls.emplace_back(seen(wall.from), seen(wall.to));
  for (const Pillar& pillar : scene.pillars)
    result.pillars.push_back({seen(pillar.centre), pillar.radius});
  return result;
}

}  // namespace

std::optional<PictureScene> scene_behind(const System& system, std::size_t node, double time) {
  const PlanNode& plan_node = system.plan().nodes[node];
  const Module* module = system.node(node).module.get();
  if (const auto* lep = dynamic_cast<const LepSensor*>(module)) {
    // The LEP's frame has x to the right and z forward; a scene's poses look along x.
    const ScenePose vehicle =
        lep->vehicle(payload_of<LepSensor::Parameters>(plan_node.parameters), time);
    PictureScene scene = seen_from(vehicle, lep->scene(), plan_node.name);
    scene.frame = plan_node.frame;
    return scene;
  }
  const auto* laser = dynamic_cast<const LaserScene*>(module);
  if (laser == nullptr || laser->scene() == nullptr) return std::nullopt;
  PictureScene scene = seen_from(laser->stand().robot, *laser->scene(), plan_node.name);
  scene.frame = "robot";
  return scene;
}

}  // namespace ilss
