// Moments of a run, and when data were acquired: integer nanoseconds, so that no sum of periods
// drifts and equal moments compare equal.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

namespace ilss {

/// The clock of a run. It is told what time it is, tick by tick; nobody asks it.
struct RunClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = std::chrono::nanoseconds;
  using time_point = std::chrono::time_point<RunClock>;
  static constexpr bool is_steady = true;
};

using Duration = RunClock::duration;
/// Since the start of the run, or, where the run follows a log, since the epoch of its stamps.
using Time = RunClock::time_point;

/// A duration as the nearest number to compute with (s).
constexpr double seconds(Duration duration) { return static_cast<double>(duration.count()) / 1e9; }
/// A moment as a number to compute with (s since the clock's zero).
constexpr double seconds(Time time) { return seconds(time.time_since_epoch()); }

/// The duration of so many seconds, to the nearest nanosecond; what is beyond 292 years, or NaN, is
/// the largest there is.
inline Duration duration_of(double seconds) {
  constexpr double largest = 9.2e18;  // ns
  const double nanoseconds = seconds * 1e9;
  if (!(nanoseconds < largest)) return Duration::max();
  if (nanoseconds < -largest) return Duration::min();
  return Duration(std::llround(nanoseconds));
}
/// The moment at so many seconds.
inline Time time_at(double seconds) { return Time(duration_of(seconds)); }

/// How old is at `now` what is from `then`; what is beyond all durations is the longest there is.
constexpr Duration age_of(Time then, Time now) {
  Duration::rep age = 0;
  const bool is_beyond =
      __builtin_sub_overflow(now.time_since_epoch().count(), then.time_since_epoch().count(), &age);
  if (is_beyond) [[unlikely]]
    return then < now ? Duration::max() : Duration::min();
  return Duration(age);
}

/// When the data in an output were acquired: the oldest and the newest of them.
struct Acquisition {
  Time oldest = {};
  Time newest = {};

  static constexpr Acquisition at(Time time) { return {time, time}; }
  /// Widens the range by another's.
  void include(const Acquisition& other) {
    oldest = std::min(oldest, other.oldest);
    newest = std::max(newest, other.newest);
  }
  bool operator==(const Acquisition&) const = default;
};

}  // namespace ilss
