// The text formats in which laser scans are recorded, one line a scan.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "framework/module/outcome.h"

namespace ilss {

/// A scan as a line of a log tells it.
struct LaserRecord {
  double first_bearing = 0;         ///< rad, counter-clockwise from forward
  double step = 0;                  ///< rad, from beam to beam
  double time = 0;                  ///< s, of the log's own clock
  std::vector<double> ranges = {};  ///< m, as recorded: codes of the device included
};

/// Which of a CARMEN log's messages to read.
enum class CarmenMessage { flaser, rlaser, robotlaser1 };

/// The message's name as it stands in logs: "FLASER".
std::string_view message_name(CarmenMessage message);

/// Reads a line of a CARMEN log: nothing where it is another message or a comment. `FLASER n r1 ..
/// rn x y theta odom_x odom_y odom_theta time host logger_time` (RLASER alike) carries no angles:
/// 180 and 360 beams start at -90 degrees, 181 and 361 reach +90; other counts are spread over 180
/// degrees in the latter way. `ROBOTLASER1 type start fov resolution max_range accuracy remission n
/// r1 .. rn m remissions .. x y theta ...` does. Faults: bad_data where a number is missing or is
/// none, or the count does not fit the line; the message says at which word.
Outcome<std::optional<LaserRecord>> parse_carmen(std::string_view line, CarmenMessage message);

/// Reads a line of the URG-04LX logs that BreezySLAM uses: 24 numbers, of which the first is the
/// time in us, then ranges in mm over 240 degrees; 682 steps of 360/1024 degrees. Faults: bad_data.
Outcome<std::optional<LaserRecord>> parse_urg(std::string_view line);

/// Reads a line of comma-separated values (commas, blanks or tabs): the time in s, then ranges in m
/// from the right to the left, the first and the last `field_of_view` (rad) apart and the same to
/// either side. `inf` is no return, as is 0. Nothing for an empty line, a comment (#) or a header.
/// Faults: bad_data.
Outcome<std::optional<LaserRecord>> parse_laser_csv(std::string_view line, double field_of_view);

}  // namespace ilss
