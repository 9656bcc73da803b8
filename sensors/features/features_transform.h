// Moves a set of features from one frame into another, with the error of the pose between them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>

#include "framework/module/module_type.h"
#include "sensors/features/range_features.h"
#include "sensors/wall/planar_pose.h"
#include "sensors/wall/planar_transform.h"

namespace ilss {

/// A feature in another frame, with its exact derivatives.
struct MovedFeature {
  static constexpr int most = static_cast<int>(dimension_of<ArcSegment>);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most, 1> value;
  /// By the feature's components, and by the pose's x, z and heading.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most, most> by_feature;
  using ByPose = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, most, 3>;
  ByPose by_pose;
};

/// Moves a line_segment, arc_segment, corner or edge by `pose`, that of the feature's frame in the
/// other one. Places: p' = pose + R(heading) p. A line: phi' = phi + heading, rho' = rho + n' ·
/// pose with its normal n' = (cos phi', sin phi'), and where that is negative, -rho' and phi' + pi;
/// an edge's phi turns with the line that it is the end of. The radius, counts and places in the
/// scan stay as they are. From camera axes, x and z are exchanged first, and phi is pi/2 - phi.
MovedFeature move_feature(const Estimate& feature, const PlanarPose<double>& pose, PlaneAxes axes);

/// Where the pose of the input's frame comes from.
enum class PoseSource { mount, input };
constexpr std::array<std::string_view, 2> choices(PoseSource) { return {"mount", "input"}; }

/// Function: a set of features in another frame, x forward and z to the right, by the rules of
/// `move_feature`. The features' frame stands at `mount`, a pose that is known once and for all
/// (its errors are systematic); with `pose: input`, at `mount` in a frame that the second input, a
/// planar_pose, says tick by tick where it is: the robot's pose in the world, from a localisation.
/// All features share the pose's errors, so their cross-covariances are exact. Where the
/// plan cannot tell the correlation of features and pose, each feature's covariance is a bound.
/// Faults: not_finite where a moved feature or its error is not finite; bad_data where an element
/// is none of range_features.
class FeaturesTransform final : public Module {
 public:
  static constexpr std::string_view name = "features_transform";
  static constexpr std::string_view description =
      "features in another frame, by a mount or a pose with its error";
  static constexpr ModuleKind kind = ModuleKind::function;
  static constexpr std::array faults = {FaultKind::not_finite, FaultKind::bad_data};

  template <typename T>
  using Parameters = PlanarTransform::Parameters<T>;

  struct Options {
    std::string from = "robot";
    std::string to = "world";
    PlaneAxes axes = PlaneAxes::robot;
    PoseSource pose = PoseSource::mount;
    void declare(OptionVisitor& visit);
  };

  static Interface interface(const Options& options);

  explicit FeaturesTransform(Options options) : options_(std::move(options)) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;

 private:
  /// The pose of the features' frame, and how it follows from the mount and the input pose.
  struct Pose {
    PlanarPose<double> value;
    Eigen::Matrix3d by_mount;
    Eigen::Matrix3d by_input;
  };

  Pose pose_of(const Evaluation& evaluation) const;
  Outcome<> move(const Evaluation& evaluation, const Pose& pose, std::size_t index,
                 Estimate& element) const;

  Options options_;
};

}  // namespace ilss
