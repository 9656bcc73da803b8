// A sonar: ranges given, recorded or simulated, with one error model for all of them.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "framework/estimate/units.h"
#include "framework/module/module_type.h"
#include "framework/record/csv_file.h"
#include "sensors/scene/scene.h"
#include "sensors/sonar/sonar_reading.h"

namespace ilss {

/// How a range's error grows with range: sd² = constant² + (proportional · range)².
struct RangeError {
  double constant = 0;      ///< m
  double proportional = 0;  ///< share of the range
  void declare(OptionVisitor& visit);
};

/// One range, as if the sonar had just measured it.
struct GivenRange {
  double range = 0;  ///< m
  void declare(OptionVisitor& visit);
};

/// A column of a recording, one row a reading.
struct RangeColumn {
  std::filesystem::path file = {};
  std::string column = "1";
  std::string unit = "m";
  void declare(OptionVisitor& visit);
};

/// Where readings come from: exactly one of these.
struct SonarInput {
  std::vector<GivenRange> values;
  std::optional<RangeColumn> csv;
  std::optional<FileOf<Scene>> scene;
  void declare(OptionVisitor& visit);
};

/// Sensor: range r to the nearest point of any wall inside the beam (Henderson & Dekhil 1997, sec.
/// 2.3), with a fresh error a tick, of constant sd or of variance constant² + (proportional r)²
/// (Schenkat & Veigel found the variance to depend on range). Beam and mount pass into the output
/// with their own, persistent errors. A simulated range is exact but for that noise, the
/// parameters' values being the truth.
/// Pending between readings where `period` > 1. Faults: no_detection without an echo (recorded as
/// an empty cell); end_of_data after the last reading; bad_data for a recorded cell that is no
/// number; device_lost for a recording that cannot be read or lacks the column; out_of_range for a
/// reading that is not positive.
class Sonar final : public Module {
 public:
  static constexpr std::string_view name = "sonar";
  static constexpr std::string_view description =
      "range to the nearest point of a wall inside the beam";
  static constexpr std::string_view reference = "Henderson & Dekhil 1997, sec. 2.3";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static constexpr std::array faults = {FaultKind::no_detection, FaultKind::out_of_range,
                                        FaultKind::end_of_data, FaultKind::bad_data,
                                        FaultKind::device_lost};

  template <typename T>
  struct Parameters {
    T beam_half_angle, mount_x, mount_z, mount_heading, robot_x, robot_z, robot_heading;
    static constexpr std::string_view name = "sonar_parameters";
    static constexpr auto fields = Fields{
        {"beam_half_angle", "rad", "half the beam's opening angle", polaroid_half_angle},
        {"mount.x", "m", "the sonar's place, forward of the frame's origin", 0},
        {"mount.z", "m", "the sonar's place, to the right of the frame's origin", 0},
        {"mount.heading", "rad", "the beam's axis, positive to the right", 0, Geometry::circular},
        {"robot.x", "m", "where the robot stands in the scene", 0},
        {"robot.z", "m", "where the robot stands in the scene", 0},
        {"robot.heading", "rad", "where the robot looks in the scene", 0, Geometry::circular}};
  };

  struct Options {
    std::optional<double> range_std;
    std::optional<RangeError> range_error;
    std::optional<double> no_echo;
    std::optional<double> max_range;
    std::int64_t period = 1;
    std::string frame = "robot";
    SonarInput input;
    void declare(OptionVisitor& visit);
  };

  static Interface interface(const Options& options);

  explicit Sonar(Options options) : options_(std::move(options)) {}

  Outcome<> open() override;
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;

  /// The error model at the operating point's range; components that the point leaves out (NaN)
  /// take the parameters. Without a point: the first reading, or the scene's range without noise.
  Outcome<> expect(const Evaluation& evaluation, const Output* operating_point,
                   Output& output) override;

 private:
  double standard_deviation(double range) const;
  Outcome<double> acquire(const Evaluation& evaluation, std::size_t reading) const;
  Outcome<double> recorded_range(const RangeColumn& source, std::size_t reading) const;
  Outcome<double> scene_range(const Estimate& parameters) const;
  Outcome<> emit(const Evaluation& evaluation, double range, Output& output) const;

  Options options_;
  std::shared_ptr<const CsvFile> recording_;
  std::size_t column_ = 0;
  UnitConversion conversion_;  ///< of the recording, to m
};

}  // namespace ilss
