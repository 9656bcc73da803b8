// When a run's ticks are: by a period, by the machine's clock, or by the times of its data.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

#include "framework/graph/system.h"

namespace ilss {

/// Where the times of a run's ticks come from.
enum class Pacing {
  simulated,  ///< a period from tick to tick, counted from 0, as fast as the modules go
  real,       ///< the same by the machine's clock: each tick waits for its time
  data,       ///< the sources' own clocks: a tick whenever data of a log were acquired
};

/// Tells a run the time of one tick after the other.
class Pacer {
 public:
  /// @pre period > 0. Waiting ends once `interrupted` (may be null) is set.
  Pacer(Pacing pacing, Duration period, const std::atomic<bool>* interrupted)
      : pacing_(pacing), period_(period), interrupted_(interrupted) {}

  /// The time of the next tick, once it has come; nothing where the system's data are at their end,
  /// or where it is interrupted meanwhile. The first one starts the machine's clock.
  std::optional<Time> next(System& system);

  bool is_interrupted() const {
    return interrupted_ != nullptr && interrupted_->load(std::memory_order_relaxed);
  }
  /// Periods of the real clock that went by while a tick took longer.
  std::int64_t missed_periods() const { return missed_periods_; }

 private:
  Time simulated_time() const;
  std::optional<Time> real_time();
  std::optional<Time> data_time(System& system) const;

  Pacing pacing_;
  Duration period_;
  const std::atomic<bool>* interrupted_;
  std::int64_t ticks_ = 0;
  std::int64_t periods_ = 0;  ///< of the real clock that have gone by
  std::int64_t missed_periods_ = 0;
  std::chrono::steady_clock::time_point began_;
};

}  // namespace ilss
