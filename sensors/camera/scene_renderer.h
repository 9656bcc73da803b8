// What a camera sees of a scene, without noise.
#pragma once

#include <vector>

#include "sensors/camera/image.h"
#include "sensors/scene/scene.h"

namespace ilss {

/// A camera in a scene. Its optical axis lies in the plane from which targets' heights count.
struct CameraView {
  ScenePose pose;  ///< in the world; looks along its heading
  Image<double> intrinsics;
  std::size_t rows;
  std::size_t columns;
  double background = 0;  ///< reflectivity seen where there is no wall
};

/// The mean reflectivity that each pixel sees (rows x columns, row-major), by exact area coverage:
/// edges have no sampling bias. Nearer walls hide farther ones. Without lens distortion exact to
/// rounding; with it edges are cut into pieces of a quarter of a pixel.
std::vector<double> render_scene(const Scene& scene, const CameraView& view);

}  // namespace ilss
