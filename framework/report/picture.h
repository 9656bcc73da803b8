// What a tick gave that has a place in the plane, gathered to be drawn.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "framework/runtime/characteristic_output.h"

namespace ilss {

/// A place with its error; metres, to the right and up in the picture.
struct UncertainPoint {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};

/// A reading: where it is, and a standard deviation of its range along its ray.
struct PictureReading {
  Eigen::Vector2d at;
  Eigen::Vector2d deviation;
};

/// A piece of surface between two ends; a piece of a circle where it has a centre.
struct PictureStroke {
  UncertainPoint from;
  UncertainPoint to;
  std::optional<Eigen::Vector2d> centre;
  std::string text;  ///< what it says of itself
};

/// A single place. An edge where a surface ends is crossed out, all else is ringed.
struct PictureMark {
  UncertainPoint point;
  bool is_jump;
  std::string text;
};

/// Where a sensor's rays start, and the first and last of them.
struct PictureField {
  Eigen::Vector2d origin;
  Eigen::Vector2d first;
  Eigen::Vector2d last;
  double far;  ///< beyond this distance from the origin (m), readings stand alone
};

/// What one module gave.
struct PictureLayer {
  std::string module;
  std::string content;  ///< "240 readings"
  std::vector<PictureReading> readings = {};
  std::vector<PictureStroke> strokes = {};
  std::vector<PictureMark> marks = {};
  std::optional<PictureField> field = {};

  bool empty() const { return readings.empty() && strokes.empty() && marks.empty(); }
};

/// The simulated world behind a sensor's readings, as the sensor sees it: walls and pillars.
struct PictureScene {
  struct Pillar {
    Eigen::Vector2d centre;
    double radius;
  };
  std::string module;  ///< the sensor
  std::string frame;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> walls = {};
  std::vector<Pillar> pillars = {};
};
/// The scene that a node simulates its readings in; nothing where it simulates none.
using SceneBehind = std::function<std::optional<PictureScene>(std::size_t node)>;

/// Which of a frame's axes lie where, so that forward is up: the sensors' planes have x to the
/// right and z up, the robot's has x up and z to the right, those of REP-103 x up and y to the
/// left.
struct PictureAxes {
  std::string right = "x";
  std::string up = "z";
  double right_sign = 1;  ///< of the axis's numbers to the right
};

/// One tick, in one frame.
struct Picture {
  std::string title;
  std::string subtitle;
  std::string frame;
  PictureAxes axes = {};
  std::vector<PictureLayer> layers = {};
  std::vector<PictureScene> scenes = {};
  std::vector<std::string> left_out = {};  ///< messages on what is in another frame
};

/// Gathers what the modules gave in a tick, by what their payloads' descriptors call it.
///
/// Scans are samples with a column `bearing` (rad) and either `origin_x`, `origin_z`,
/// `inverse_range` and `deviation` (its standard deviation), rays in the scan's frame from x
/// towards z; or `range`, counter-clockwise, beside components `mount_x`, `mount_z`,
/// `mount_heading`, `range_std` and `quantum`, which place it in the robot's plane. Payloads and
/// elements of a set say by their components where they are: `x` and `z` (or `y`), from `start_x`
/// ... to `end_x` ..., about `centre_x` ....
///
/// The frame is that of the first output that can be drawn, or else the first module's. Nothing
/// where there is none. `scene_behind` may be empty.
std::optional<Picture> picture_of(const TickView& tick, const SceneBehind& scene_behind = {});

}  // namespace ilss
