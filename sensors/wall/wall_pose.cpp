#include "sensors/wall/wall_pose.h"

namespace ilss {

void WallPoseModule::set_frames(Interface& interface) {
  interface.inputs[0].frame = "robot";
  interface.frame = "robot";
  interface.frame_of_input.reset();
}

}  // namespace ilss
