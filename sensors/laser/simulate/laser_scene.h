// A laser range finder, simulated in a scene.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "framework/module/module_type.h"
#include "sensors/laser/laser_scan.h"
#include "sensors/laser/simulate/laser_world.h"

namespace ilss {

/// Sensor: scans of a simulated scene, one a tick, or of generated rooms in the manner of Núñez et
/// al. 2009, sec. 5 (generated_room.h). A beam goes to its bearing and an error of `bearing_std`,
/// its range has an error of `range_std` and is told in whole quanta; beams count from the right to
/// the left. Surfaces beyond `max_range` give no return. The robot may drive during the sweep; the
/// scan then is what a device that knows nothing of it tells. The mount's value is the simulation's
/// truth; the scan carries it with its errors.
/// Faults: out_of_range where an sd is negative; degenerate where a generated room has no place to
/// scan from.
class LaserScene final : public Module {
 public:
  static constexpr std::string_view name = "laser_scene";
  static constexpr std::string_view description =
      "laser scans of a simulated scene, or of generated rooms";
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

  explicit LaserScene(const Options& options) : options_(options), world_(options.world) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
  /// The scan without noise, with the errors that the readings would have.
  Outcome<> expect(const Evaluation& evaluation, const Output* operating_point,
                   Output& output) override;

  /// The scene of the last tick, and how the laser stood in it; nothing before the first.
  const Scene* scene() const { return stand_ ? &world_.scene() : nullptr; }
  const LaserStand& stand() const { return *stand_; }

 private:
  Outcome<> scan(const Evaluation& evaluation, bool noisy, Output& output);

  Options options_;
  LaserWorld world_;
  std::optional<LaserStand> stand_;
};

}  // namespace ilss
