// A simulated laser's scan with its true segments: the best that any segmenter could do.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "framework/module/module_type.h"
#include "sensors/laser/segment/segmented_scan.h"
#include "sensors/laser/simulate/laser_world.h"
#include "sensors/laser/simulate/visible_pieces.h"

namespace ilss {

/// Sensor: the scan that a `laser_scene` of the same name and options gives, taken apart as the
/// scene has it: each piece that counts (laser_scene_features) is a segment of the beams that have
/// their ranges from it. A beam whose bearing's error let it meet something else belongs to none,
/// so a piece can lose a reading at its ends. In a study, the segmenter that others are measured
/// by. Faults: as laser_scene's.
class LaserSceneSegments final : public Module {
 public:
  static constexpr std::string_view name = "laser_scene_segments";
  static constexpr std::string_view description =
      "laser scans of a simulated scene with their true segments";
  static constexpr std::string_view reference = "Núñez et al. 2009, sec. 5";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static constexpr std::array faults = {FaultKind::out_of_range, FaultKind::degenerate};

  template <typename T>
  using Parameters = LaserWorldParameters<T>;

  struct Options {
    LaserWorldOptions world;
    std::string frame = "laser";
    void declare(OptionVisitor& visit);
  };

  static Interface interface(const Options& options);

  explicit LaserSceneSegments(const Options& options) : options_(options), world_(options.world) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;

 private:
  Options options_;
  LaserWorld world_;
  std::vector<LaserBeam> scan_;
  std::vector<std::size_t> surfaces_;
  std::vector<TracedBeam> beams_;
  std::vector<VisiblePiece> pieces_;
};

}  // namespace ilss
