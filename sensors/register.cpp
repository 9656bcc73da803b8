#include "sensors/register.h"

#include "sensors/scene/scene_wall.h"
#include "sensors/sonar/sonar.h"
#include "sensors/wall/planar_transform.h"
#include "sensors/wall/wall_pose.h"
#include "sensors/wall/wedge_sonar_line.h"

namespace ilss {

void register_sensors(Registry& registry) {
  registry.add<PlanarTransform>();
  registry.add<SceneWall>();
  registry.add<Sonar>();
  registry.add<WallPoseModule>();
  registry.add<WedgeSonarLine>();
}

}  // namespace ilss
