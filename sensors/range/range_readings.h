// Anybody's range sensor from a recording: angles and ranges, one row a reading.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "framework/module/module_type.h"
#include "framework/record/csv_file.h"
#include "framework/record/skipped_lines.h"
#include "sensors/range/range_scan.h"

namespace ilss {

/// From which axis the recorded angles count, and towards which.
enum class AngleSense { from_x_to_z, from_z_to_x };
constexpr std::array<std::string_view, 2> choices(AngleSense) {
  return {"from_x_to_z", "from_z_to_x"};
}

/// Sensor: scans of a recording, one a tick; the same error model as for any other range sensor:
/// each reading's own noise (a column, or constant and proportional parts), and an offset and a
/// scale of all ranges, persistent sources (`error_1`: 1 m of offset, `error_2`: relative scale).
/// A scan ends after `readings` rows or, without that, where the angle jumps back.
/// Rows without a range (an empty cell) are left out; with `skip_bad`, rows that would be a fault,
/// too, and counted. Times are s, of each reading; without a
/// column, the tick's.
/// Frame: as named; the head's axis is its origin. Faults, with file and line: bad_data where a
/// cell is no number, a range, inverse range or sd is not above 0, or a range lies outside
/// `min_range` to `max_range`; no_detection where all rows of a scan are empty; end_of_data after
/// the last scan; device_lost where the file cannot be read or lacks a column.
class RangeReadings final : public Module {
 public:
  static constexpr std::string_view name = "range_readings";
  static constexpr std::string_view description = "range scans from a CSV recording";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static constexpr std::array faults = {FaultKind::bad_data, FaultKind::no_detection,
                                        FaultKind::end_of_data, FaultKind::device_lost};

  template <typename T>
  struct Parameters {
    T offset, scale, mount_x, mount_z, mount_heading;
    static constexpr std::string_view name = "range_readings_parameters";
    static constexpr auto fields =
        Fields{{"offset", "m", "taken from every range", 0},
               {"scale", "1", "that every range, less the offset, is multiplied by", 1},
               {"mount.x", "m", "where the rays start, seen from the head's axis", 0},
               {"mount.z", "m", "the same", 0},
               {"mount.heading", "rad", "how far the rays are turned in the head, from x towards z",
                0, Geometry::circular}};
  };

  struct Options {
    std::filesystem::path file;
    std::string angle = "angle";
    std::string angle_unit = "rad";
    AngleSense angles = AngleSense::from_x_to_z;
    std::string range = "range";
    std::string range_unit = "m";
    std::optional<std::string> range_std;
    double std_constant = 0;
    double std_proportional = 0;
    std::optional<std::string> head;
    std::optional<std::string> time_column;
    bool skip_bad = false;
    std::optional<std::int64_t> readings;
    double min_range = 0;
    std::optional<double> max_range;
    double noise_correlation = 0;
    double beam_width = 0;
    std::string frame = "lep";
    void declare(OptionVisitor& visit);
  };

  static Interface interface(const Options& options);

  explicit RangeReadings(Options options) : options_(std::move(options)) {}

  Outcome<> open() override;
  std::optional<Time> next_time() override;
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
  std::string note() const override { return skipped_.text(); }
  void reset() override;

 private:
  struct Columns {
    std::size_t angle, range;
    std::optional<std::size_t> range_std, head, time;
  };

  std::size_t end_of_scan() const;
  Outcome<> read_row(std::size_t row, const Evaluation& evaluation, RangeReading& reading) const;

  Options options_;
  std::shared_ptr<const CsvFile> recording_;
  Columns columns_ = {};
  double to_metres_ = 1;
  double to_radians_ = 1;
  std::size_t next_ = 0;  ///< row
  SkippedLines skipped_;
};

}  // namespace ilss
