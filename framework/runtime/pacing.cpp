#include "framework/runtime/pacing.h"

#include <algorithm>
#include <thread>

namespace ilss {

std::optional<Time> Pacer::next(System& system) {
  std::optional<Time> time;
  switch (pacing_) {
    case Pacing::simulated:
      time = simulated_time();
      break;
    case Pacing::real:
      time = real_time();
      break;
    case Pacing::data:
      time = data_time(system);
      break;
  }
  if (time) ++ticks_;
  return time;
}

Time Pacer::simulated_time() const {
  Duration::rep product = 0;
  return __builtin_mul_overflow(ticks_, period_.count(), &product) ? Time::max()
                                                                   : Time(Duration(product));
}

/// Waits for the next period to begin.
std::optional<Time> Pacer::real_time() {
  using Clock = std::chrono::steady_clock;
  if (ticks_ == 0) {
    began_ = Clock::now();
    return Time{};
  }
  const std::int64_t now = (Clock::now() - began_) / period_;
  missed_periods_ += std::max<std::int64_t>(now - periods_ - 1, 0);
  periods_ = std::max(now, periods_ + 1);
  const Clock::time_point begins = began_ + periods_ * period_;
  constexpr std::chrono::milliseconds patience(50);
  while (Clock::now() < begins && !is_interrupted())
    std::this_thread::sleep_until(std::min(begins, Clock::now() + patience));
  if (is_interrupted()) return std::nullopt;
  return Time(std::chrono::duration_cast<Duration>(Clock::now() - began_));
}

/// Stamps that run backwards are taken as of the tick before.
std::optional<Time> Pacer::data_time(System& system) const {
  const std::optional<Time> next = system.next_data_time();
  return next && ticks_ > 0 ? std::max(*next, system.time()) : next;
}

}  // namespace ilss
