// A laser's scan as ranges in the robot's plane, as the line extractors take them.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "framework/module/module_type.h"
#include "sensors/laser/laser_scan.h"
#include "sensors/range/range_scan.h"

namespace ilss {

/// Estimator: turns a laser_scan into a range_scan of the robot's plane (x forward, z to the
/// right), with the laser's mount and the offset and scale of its ranges as systematic errors
/// (`error_1`: 1 m of offset, `error_2`: relative scale). A range's own error is its noise and its
/// quantum's, q²/12. Beams without return are left out. Faults: no_detection where no beam
/// returned; no_error_known where range_std and quantum are 0;
/// out_of_range where the scale is not above 0.
class LaserRanging final : public Module {
 public:
  static constexpr std::string_view name = "laser_ranging";
  static constexpr std::string_view description =
      "a laser's scan as ranges in the robot's plane, with its mount's and ranges' systematic "
      "errors";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr std::array faults = {FaultKind::no_detection, FaultKind::no_error_known,
                                        FaultKind::out_of_range};

  template <typename T>
  struct Parameters {
    T offset, scale, mount_x, mount_z, mount_heading;
    static constexpr std::string_view name = "laser_ranging_parameters";
    static constexpr auto fields =
        Fields{{"offset", "m", "taken from every range", 0},
               {"scale", "1", "that every range, less the offset, is multiplied by", 1},
               {"mount.x", "m", "the laser's place, forward of the robot's origin", 0},
               {"mount.z", "m", "the laser's place, to the right", 0},
               {"mount.heading", "rad", "where the laser looks, positive to the right", 0, true}};
  };

  struct Options {
    std::string frame = "robot";
    double beam_width = 0;
    void declare(OptionVisitor& visit);
  };

  static Interface interface(const Options& options);

  explicit LaserRanging(Options options) : options_(std::move(options)) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;

 private:
  Options options_;
};

}  // namespace ilss
