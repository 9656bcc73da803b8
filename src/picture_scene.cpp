#include "src/picture_scene.h"

#include "sensors/lep/lep_sensor.h"

namespace ilss {

std::optional<PictureScene> scene_behind(const System& system, std::size_t node, double time) {
  const PlanNode& plan_node = system.plan().nodes[node];
  const auto* sensor = dynamic_cast<const LepSensor*>(system.node(node).module.get());
  if (sensor == nullptr) return std::nullopt;
  const ScenePose vehicle =
      sensor->vehicle(payload_of<LepSensor::Parameters>(plan_node.parameters), time);
  // The LEP's frame has x to the right and z forward; a scene's poses look along x.
  const auto seen = [&](const ScenePoint& point) {
    const ScenePoint in_frame = to_frame(vehicle, point);
    return Eigen::Vector2d(in_frame.z, in_frame.x);
  };
  PictureScene result{.module = plan_node.name, .frame = plan_node.frame};
  const Scene& scene = sensor->scene();
  for (const Wall& wall : scene.walls) result.walls.emplace_back(seen(wall.from), seen(wall.to));
  for (const Pillar& pillar : scene.pillars)
    result.pillars.push_back({seen(pillar.centre), pillar.radius});
  return result;
}

}  // namespace ilss
