#include "sensors/laser/acquire/laser_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "framework/estimate/angle.h"

namespace ilss {
namespace {

constexpr std::size_t most_beams = 1'000'000;

/// The words of a line, one after another.
class Words {
 public:
  Words(std::string_view line, std::string_view separators)
      : rest_(line), separators_(separators) {}

  std::size_t count() const { return count_; }
  bool at_end() const { return rest_.find_first_not_of(separators_) == std::string_view::npos; }

  std::string_view next() {
    ++count_;
    const std::size_t begin = rest_.find_first_not_of(separators_);
    if (begin == std::string_view::npos) return {};
    rest_.remove_prefix(begin);
    const std::size_t end = std::min(rest_.find_first_of(separators_), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return word;
  }

  /// The next word as a finite number. Faults: bad_data with the word's place.
  Outcome<double> number(std::string_view what) {
    const std::string_view word = next();
    double value = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty())
      return Fault{FaultKind::bad_data,
                   fmt::format("the line ends at word {}; expected {}", count_, what)};
    if (error != std::errc{} || stop != word.data() + word.size() || !std::isfinite(value)) {
      constexpr std::size_t most_shown = 20;
      std::string shown(word.substr(0, most_shown));
      std::replace_if(
          shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
      return Fault{FaultKind::bad_data,
                   fmt::format("word {}: expected {}, got '{}'", count_, what, shown)};
    }
    return value;
  }

  /// The next word as a range; infinite ones, as some drivers write, are no return: 0.
  Outcome<double> range() {
    Words after = *this;
    const std::string_view word = after.next();
    if (word != "inf" && word != "Inf" && word != "+inf" && word != "Infinity")
      return number("a range");
    *this = after;
    return 0.0;
  }

 private:
  std::string_view rest_;
  std::string_view separators_;
  std::size_t count_ = 0;
};

constexpr std::string_view blanks = " \t\r";

std::optional<Fault> read_numbers(Words& words, std::size_t count, std::string_view what,
                                  std::vector<double>& into) {
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = words.number(what);
    if (!value) return value.fault();
    into.push_back(*value);
  }
  return std::nullopt;
}

Outcome<std::size_t> read_count(Words& words, std::size_t least) {
  const auto count = words.number("the number of beams");
  if (!count) return count.fault();
  if (*count != std::floor(*count) || *count < static_cast<double>(least) ||
      *count > static_cast<double>(most_beams))
    return Fault{FaultKind::bad_data,
                 fmt::format("word {}: {} is no number of beams", words.count(), *count)};
  return static_cast<std::size_t>(*count);
}

Outcome<std::optional<LaserRecord>> parse_old_laser(Words& words) {
  const auto count = read_count(words, 2);
  if (!count) return count.fault();
  LaserRecord record;
  if (const auto fault = read_numbers(words, *count, "a range", record.ranges)) return *fault;
  std::vector<double> poses;
  if (const auto fault = read_numbers(words, 7, "a pose or the time", poses)) return *fault;
  record.time = poses.back();
  record.first_bearing = -90 * radians_per_degree;
  const bool reaches_end = *count % 2 == 1;
  record.step = 180 * radians_per_degree / static_cast<double>(reaches_end ? *count - 1 : *count);
  return std::optional(std::move(record));
}

Outcome<std::optional<LaserRecord>> parse_robot_laser(Words& words) {
  LaserRecord record;
  std::vector<double> settings;
  if (const auto fault = read_numbers(words, 7, "a setting of the laser", settings)) return *fault;
  record.first_bearing = settings[1];
  record.step = settings[3];
  if (!(record.step > 0))
    return Fault{FaultKind::bad_data, fmt::format("an angular resolution of {}", record.step)};
  const auto count = read_count(words, 2);
  if (!count) return count.fault();
  if (const auto fault = read_numbers(words, *count, "a range", record.ranges)) return *fault;
  const auto remissions = read_count(words, 0);
  if (!remissions) return remissions.fault();
  std::vector<double> others;
  // Remissions, the laser's and the robot's pose, and five numbers of the robot's motion.
  if (const auto fault = read_numbers(words, *remissions + 11, "a number", others)) return *fault;
  const auto time = words.number("the time");
  if (!time) return time.fault();
  record.time = *time;
  return std::optional(std::move(record));
}

}  // namespace

std::string_view message_name(CarmenMessage message) {
  constexpr std::string_view names[] = {"FLASER", "RLASER", "ROBOTLASER1"};
  return names[static_cast<std::size_t>(message)];
}

Outcome<std::optional<LaserRecord>> parse_carmen(std::string_view line, CarmenMessage message) {
  Words words(line, blanks);
  if (words.next() != message_name(message)) return std::optional<LaserRecord>();
  return message == CarmenMessage::robotlaser1 ? parse_robot_laser(words) : parse_old_laser(words);
}

Outcome<std::optional<LaserRecord>> parse_urg(std::string_view line) {
  Words words(line, blanks);
  if (words.at_end()) return std::optional<LaserRecord>();
  constexpr std::size_t header_size = 24;
  constexpr double step = 360.0 / 1024 * radians_per_degree;
  LaserRecord record;
  std::vector<double> header;
  if (const auto fault = read_numbers(words, header_size, "a header number", header)) return *fault;
  record.time = header[0] * 1e-6;
  while (!words.at_end()) {
    const auto range = words.number("a range");
    if (!range) return range.fault();
    if (record.ranges.size() == most_beams)
      return Fault{FaultKind::bad_data, "the line has more than a million ranges"};
    record.ranges.push_back(*range * 1e-3);
  }
  if (record.ranges.size() < 2)
    return Fault{FaultKind::bad_data, "the line has no ranges behind its 24 header numbers"};
  record.step = step;
  record.first_bearing = -step * static_cast<double>(record.ranges.size() - 1) / 2;
  return std::optional(std::move(record));
}

Outcome<std::optional<LaserRecord>> parse_laser_csv(std::string_view line, double field_of_view) {
  Words words(line, ", \t\r");
  if (words.at_end() || line.front() == '#') return std::optional<LaserRecord>();
  const bool header = std::isalpha(static_cast<unsigned char>(line.front())) != 0;
  if (header) return std::optional<LaserRecord>();
  LaserRecord record;
  const auto time = words.number("the time");
  if (!time) return time.fault();
  record.time = *time;
  while (!words.at_end()) {
    const auto range = words.range();
    if (!range) return range.fault();
    record.ranges.push_back(*range);
  }
  if (record.ranges.size() < 2)
    return Fault{FaultKind::bad_data, "the line has fewer than two ranges"};
  record.first_bearing = -field_of_view / 2;
  record.step = field_of_view / static_cast<double>(record.ranges.size() - 1);
  return std::optional(std::move(record));
}

}  // namespace ilss
