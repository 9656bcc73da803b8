// What a simulated laser's scan truly shows: its features without error, as truth to judge by.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "framework/module/module_type.h"
#include "sensors/features/range_features.h"
#include "sensors/laser/simulate/laser_world.h"
#include "sensors/laser/simulate/visible_pieces.h"

namespace ilss {

/// Which features of a scene: those that a segmenter is asked for, or those too small to be asked
/// for and yet no mistake where they are found.
enum class CountedPieces { counted, small };
constexpr std::array<std::string_view, 2> choices(CountedPieces) { return {"counted", "small"}; }

/// Sensor: the exact features of the scan that a `laser_scene` of the same name and options gives
/// at the same tick under the same seed of the run, as a study of sets runs its truth and its
/// alternatives. The scan is traced without noise; neighbouring beams that meet one wall or pillar
/// are a piece of it, and those of at least 10 readings and 0.5 m, or 60 degrees of the circle, are
/// `counted`. These give a line_segment or arc_segment from where the first beam meets it to where
/// the last one does (radius positive: pillars bulge), a real corner where two counted lines meet
/// between neighbouring beams, and an edge where a counted line's wall ends between its last
/// (first) beam and a neighbour that meets a farther surface. `pieces: small` gives what pieces
/// that do not count give: lines and arcs of three readings or more, and the corners and edges that
/// one of them has a part in; also an edge where a counted line meets one of them in a corner.
/// In the robot's frame at the tick's time. Faults: as laser_scene's.
class LaserSceneFeatures final : public Module {
 public:
  static constexpr std::string_view name = "laser_scene_features";
  static constexpr std::string_view description =
      "the exact features of a simulated laser's scan, as truth to judge estimates by";
  static constexpr std::string_view reference = "Núñez et al. 2009, sec. 5";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static constexpr std::array faults = {FaultKind::out_of_range, FaultKind::degenerate};

  template <typename T>
  using Parameters = LaserWorldParameters<T>;

  struct Options {
    LaserWorldOptions world;
    CountedPieces pieces = CountedPieces::counted;
    std::string frame = "robot";
    void declare(OptionVisitor& visit);
  };

  static Interface interface(const Options& options);

  explicit LaserSceneFeatures(const Options& options) : options_(options), world_(options.world) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;

 private:
  class Writer;

  Options options_;
  LaserWorld world_;
  std::vector<TracedBeam> beams_;
  std::vector<VisiblePiece> pieces_;
};

}  // namespace ilss
