// A camera: images from files, a video, a device or a simulated scene.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "framework/module/module_type.h"
#include "sensors/camera/frame_source.h"
#include "sensors/camera/image.h"
#include "sensors/scene/scene.h"

namespace ilss {

/// Acquires grey images and says what camera took them. A simulated camera renders its scene with
/// exact area coverage, adds seeded Gaussian read noise and rounds to 8 bits; a reflectivity of 1
/// is grey level 255. The intrinsics' errors go with the image as persistent sources; the grey
/// levels' noise is left to what measures in the image.
/// Faults: `end_of_data`, `bad_data` (no image, or not rows x columns), `device_lost`,
/// `out_of_range` (intrinsics that no camera has).
class Camera final : public Module {
 public:
  static constexpr std::string_view name = "camera";
  static constexpr std::string_view description =
      "grey images from files, a video, a device or a simulated scene";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static constexpr std::array faults = {FaultKind::end_of_data, FaultKind::bad_data,
                                        FaultKind::device_lost, FaultKind::out_of_range,
                                        FaultKind::no_error_known};

  /// The components of Image in their order, then the simulated camera's place: the robot in the
  /// world, and the camera in the robot's frame (x forward, z to the right).
  template <typename T>
  struct Parameters {
    T pixel_pitch, principal_row, principal_column, focal_length, k1, k2, p1, p2, k3, position_std;
    T robot_x, robot_z, robot_heading, mount_x, mount_z, mount_heading;

    static constexpr std::string_view name = "camera_parameters";
    static constexpr auto fields = Fields{
        {"pixel_pitch", "m", "from pixel to pixel on the image sensor", 40e-6},
        {"principal_row", "1", "row of the optical axis; 63.5: the middle of 128", 63.5},
        {"principal_column", "1", "column of the optical axis; 63.5: the middle of 128", 63.5},
        {"focal_length", "m", "of the lens", 6e-3},
        {"k1", "1", "radial distortion by the radius squared (OpenCV's model)", 0},
        {"k2", "1", "radial distortion by the radius to the fourth", 0},
        {"p1", "1", "tangential distortion", 0},
        {"p2", "1", "tangential distortion", 0},
        {"k3", "1", "radial distortion by the radius to the sixth", 0},
        {"position_std", "1", "error of a detected position beyond what the image shows, in pixels",
         0},
        {"robot.x", "m", "the robot in the simulated world", 0},
        {"robot.z", "m", "the robot in the simulated world", 0},
        {"robot.heading", "rad", "from the world's x axis towards z", 0, Geometry::circular},
        {"mount.x", "m", "the camera in the robot's frame, forward", 0},
        {"mount.z", "m", "the camera in the robot's frame, to the right", 0},
        {"mount.heading", "rad", "the camera in the robot's frame", 0, Geometry::circular}};
  };

  /// Where the images come from: exactly one of these.
  struct Input {
    std::optional<FileOf<Scene>> scene;
    std::vector<std::filesystem::path> images;
    std::optional<std::filesystem::path> video;
    std::optional<std::int64_t> device;
    void declare(OptionVisitor& visit);
  };

  struct Options {
    Input input;
    std::int64_t rows = 128;
    std::int64_t columns = 128;
    double noise_std = 2;
    double background = 0;
    std::string frame = "camera";
    void declare(OptionVisitor& visit);
  };

  static Interface interface(const Options& options);

  explicit Camera(Options options);
  Outcome<> open() override;
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
  /// The scene without noise, which `standard_deviations` then states; or the operating point.
  Outcome<> expect(const Evaluation& evaluation, const Output* operating_point,
                   Output& output) override;
  void reset() override { source_.reset(); }

 private:
  const std::vector<double>& rendered(const Estimate& parameters);
  Outcome<> acquire(Output& output);
  void simulate(const Evaluation& evaluation, double noise_std, Output& output);

  Options options_;
  std::unique_ptr<FrameSource> source_;
  std::vector<double> rendered_for_;  // the parameters' values that `levels_` belongs to
  std::vector<double> levels_;        // grey levels of the scene without noise
};

}  // namespace ilss
