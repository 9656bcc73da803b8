#include "sensors/camera/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sensors/camera/scene_renderer.h"

namespace ilss {
namespace {

constexpr std::size_t image_dimension = dimension_of<Image>;

/// Takes the intrinsics with their sources from the parameters, of which they are the first.
void take_intrinsics(const Estimate& parameters, Estimate& image) {
  image.value.assign(parameters.value.begin(),
                     parameters.value.begin() + static_cast<std::ptrdiff_t>(image_dimension));
  constexpr auto rows = static_cast<Eigen::Index>(image_dimension);
  constexpr auto columns = static_cast<Eigen::Index>(dimension_of<Camera::Parameters>);
  static const Eigen::Matrix<double, rows, columns> selection =
      Eigen::Matrix<double, rows, columns>::Identity();
  const LineageTerm term{selection.data(), &parameters.lineage};
  compose({&term, 1}, image_dimension, image.lineage);
}

Outcome<> check_intrinsics(const Estimate& parameters) {
  const auto p = payload_of<Camera::Parameters>(parameters);
  if (p.pixel_pitch > 0 && p.focal_length > 0) return {};
  return Fault{FaultKind::out_of_range, "pixel_pitch and focal_length must be above 0"};
}

}  // namespace

void Camera::Input::declare(OptionVisitor& visit) {
  visit("scene", scene, "a scene file, seen by a simulated camera");
  visit("images", images, "image files, or folders of them in order of name, one a tick");
  visit("video", video, "a video file, one image a tick");
  visit("device", device, "number of a camera on this computer", {.minimum = 0, .maximum = 1000});
  const int given = (scene ? 1 : 0) + (images.empty() ? 0 : 1) + (video ? 1 : 0) + (device ? 1 : 0);
  visit.require(given == 1, "a camera's input is exactly one of scene, images, video and device");
  visit.require(!scene || scene->content.pillars.empty(),
                "the simulated camera cannot draw pillars; its scene must have none");
}

void Camera::Options::declare(OptionVisitor& visit) {
  visit("input", input, "where the images come from", {.required = true});
  visit("rows", rows, "of the image", {.minimum = 1, .maximum = 16384});
  visit("columns", columns, "of the image", {.minimum = 1, .maximum = 16384});
  visit("noise_std", noise_std, "read noise of the simulated camera, in grey levels of 255",
        {.minimum = 0, .maximum = 255});
  visit("background", background, "reflectivity that a simulated camera sees beside the walls",
        {.minimum = 0, .maximum = 1});
  visit("frame", frame, "name of the camera's frame");
}

Interface Camera::interface(const Options& options) {
  return {.inputs = {},
          .output = &descriptor<Image>(),
          .frame = options.frame,
          .draws_readings = options.input.scene.has_value()};
}

Camera::Camera(Options options) : options_(std::move(options)) {}

Outcome<> Camera::evaluate(const Evaluation& evaluation, Output& output) {
  if (auto outcome = check_intrinsics(evaluation.parameters); !outcome) return outcome;
  if (options_.input.scene)
    simulate(evaluation, options_.noise_std, output);
  else if (auto outcome = acquire(output); !outcome)
    return outcome;
  take_intrinsics(evaluation.parameters, output.estimate);
  return {};
}

Outcome<> Camera::expect(const Evaluation& evaluation, const Output* operating_point,
                         Output& output) {
  if (operating_point != nullptr) {
    output.samples = operating_point->samples;
    take_intrinsics(evaluation.parameters, output.estimate);
    output.estimate.value = operating_point->estimate.value;
    return {};
  }
  if (!options_.input.scene)
    return Fault{FaultKind::no_error_known,
                 "a camera without a scene does not know what it will see: give an operating point "
                 "of what measures in its image"};
  if (auto outcome = check_intrinsics(evaluation.parameters); !outcome) return outcome;
  simulate(evaluation, 0, output);
  output.samples.standard_deviations = {
      std::sqrt(options_.noise_std * options_.noise_std + 1.0 / 12)};
  take_intrinsics(evaluation.parameters, output.estimate);
  return {};
}

Outcome<> Camera::open() {
  if (options_.input.scene || source_ != nullptr) return {};
  auto opened = open_frames({options_.input.images, options_.input.video, options_.input.device});
  if (!opened) return opened.fault();
  source_ = std::move(*opened);
  return {};
}

Outcome<> Camera::acquire(Output& output) {
  if (Outcome<> outcome = open(); !outcome) return outcome;  // anew after a reset
  if (auto outcome = source_->next(output.samples); !outcome) return outcome;
  const auto& shape = output.samples.shape;
  if (shape[0] != static_cast<std::size_t>(options_.rows) ||
      shape[1] != static_cast<std::size_t>(options_.columns))
    return Fault{
        FaultKind::bad_data,
        fmt::format("the image has {} rows and {} columns, the camera {} and {}: set rows, "
                    "columns and the principal point",
                    shape[0], shape[1], options_.rows, options_.columns)};
  output.samples.standard_deviations.clear();
  return {};
}

const std::vector<double>& Camera::rendered(const Estimate& parameters) {
  if (rendered_for_ == parameters.value) return levels_;
  const auto p = payload_of<Parameters>(parameters);
  CameraView view{};
  view.pose = compose_poses({p.robot_x, p.robot_z, p.robot_heading},
                            {p.mount_x, p.mount_z, p.mount_heading});
  const auto intrinsics = components(view.intrinsics);
  std::copy_n(parameters.value.begin(), image_dimension, intrinsics.begin());
  view.rows = static_cast<std::size_t>(options_.rows);
  view.columns = static_cast<std::size_t>(options_.columns);
  view.background = options_.background;
  levels_ = render_scene(options_.input.scene->content, view);
  for (double& level : levels_) level *= 255;
  rendered_for_ = parameters.value;
  return levels_;
}

void Camera::simulate(const Evaluation& evaluation, double noise_std, Output& output) {
  const std::vector<double>& levels = rendered(evaluation.parameters);
  const std::span<std::uint8_t> grey =
      make_levels(output.samples, static_cast<std::size_t>(options_.rows),
                  static_cast<std::size_t>(options_.columns));
  output.samples.standard_deviations.clear();
  RandomBits bits = evaluation.random();
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const double level = noise_std > 0 ? levels[i] + noise_std * draw_normal(bits) : levels[i];
    grey[i] = static_cast<std::uint8_t>(std::clamp(std::round(level), 0.0, 255.0));
  }
}

}  // namespace ilss
