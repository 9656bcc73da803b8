// Laser scans from a recording.
#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "framework/module/module_type.h"
#include "framework/record/skipped_lines.h"
#include "framework/record/text_log.h"
#include "sensors/laser/acquire/laser_records.h"
#include "sensors/laser/laser_scan.h"

namespace ilss {

/// The format of a laser log.
enum class LaserLogFormat { flaser, rlaser, robotlaser1, urg, csv };
constexpr std::array<std::string_view, 5> choices(LaserLogFormat) {
  return {"FLASER", "RLASER", "ROBOTLASER1", "urg", "csv"};
}

/// Sensor: scans of a log, one a tick: CARMEN's FLASER, RLASER or ROBOTLASER1 messages, URG-04LX
/// logs, or CSV. Ranges from `no_return` on, below `min_range` or not above 0 are no returns. The
/// error of a range is what the data sheet says (`range_std`, `quantum`), the same at every range.
/// The mount passes into the output with its own, persistent errors.
/// A scan a tick, or, in a run that follows its data, each at the log's own time. A CSV has the
/// time in s, then ranges in m from the right to the left; its times rise and all its scans have as
/// many ranges. Faults, with file and line: bad_data where a line is no scan (with `skip_bad` left
/// out and counted); end_of_data after the last scan; device_lost where the file cannot be read or
/// has no scan.
class LaserLog final : public Module {
 public:
  static constexpr std::string_view name = "laser_log";
  static constexpr std::string_view description = "laser scans from a recording";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static constexpr std::array faults = {FaultKind::bad_data, FaultKind::end_of_data,
                                        FaultKind::device_lost};

  template <typename T>
  struct Parameters {
    T mount_x, mount_z, mount_heading;
    static constexpr std::string_view name = "laser_log_parameters";
    static constexpr auto fields =
        Fields{{"mount.x", "m", "the laser's place, forward of the robot's origin", 0},
               {"mount.z", "m", "the laser's place, to the right", 0},
               {"mount.heading", "rad", "where the laser looks, positive to the right", 0,
                Geometry::circular}};
  };

  struct Options {
    std::filesystem::path file;
    LaserLogFormat format = LaserLogFormat::flaser;
    double range_std = 0.01;
    double bearing_std = 0;
    double quantum = 0;
    double min_range = 0.02;
    double no_return = 80;
    double field_of_view = 3.14159265358979312;
    std::int64_t first = 0;
    bool skip_bad = false;
    std::string frame = "laser";
    void declare(OptionVisitor& visit);
  };

  static Interface interface(const Options& options);

  explicit LaserLog(Options options) : options_(std::move(options)) {}

  Outcome<> open() override;
  std::optional<Time> next_time() override;
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
  std::string note() const override { return skipped_.text(); }
  void reset() override;

 private:
  std::optional<Time> time_of_bad_scan() const;
  Outcome<std::optional<LaserRecord>> parse(std::string_view line) const;
  Outcome<> check_continuity(const LaserRecord& record) const;
  Outcome<std::optional<LaserRecord>> read_next();
  void emit(const Evaluation& evaluation, const LaserRecord& record, Output& output);

  Options options_;
  std::shared_ptr<const TextLog> log_;
  std::size_t next_ = 0;           ///< line
  std::int64_t scans_passed_ = 0;  ///< scans before the first wanted one
  bool has_begun_ = false;         ///< whether a tick has asked for a scan
  std::size_t beams_ = 0;          ///< of the last scan
  double time_ =
      -std::numeric_limits<double>::infinity();  ///< of the last scan, by the log's clock
  SkippedLines skipped_;
  /// The scan, fault or end that comes next, where somebody has asked for its time.
  std::optional<Outcome<std::optional<LaserRecord>>> ahead_;
};

}  // namespace ilss
