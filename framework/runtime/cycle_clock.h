// The cheapest clock that only goes forward: for timing modules of a few nanoseconds.
#pragma once

#include <chrono>
#include <cstdint>

namespace ilss {

/// Counts ticks of the processor's time stamp counter where that is invariant (the same rate in
/// every power state), else nanoseconds of std::chrono::steady_clock. A run reads it once between
/// two neighbouring modules: the end of one is the beginning of the next. The counter is read
/// without waiting for earlier instructions to end, so a boundary may be off by some ten
/// nanoseconds; sums over neighbours are not.
class CycleClock {
 public:
  /// The clock of this machine. The first call measures its rate, for about a millisecond.
  static const CycleClock& instance();

  /// Ticks since some moment.
  std::uint64_t now() const noexcept {
#if defined(__x86_64__)
    if (counts_cycles_) return __builtin_ia32_rdtsc();
#endif
    return steady_nanoseconds();
  }

  /// The time from one reading to a later one (ns); 0 where two processors' counters disagree on
  /// which is later.
  std::uint64_t nanoseconds(std::uint64_t from, std::uint64_t to) const noexcept {
    const auto ticks = static_cast<std::int64_t>(to - from);  // signed: converts in one instruction
    const auto elapsed =
        static_cast<std::int64_t>(static_cast<double>(ticks) * nanoseconds_per_tick_);
    return elapsed > 0 ? static_cast<std::uint64_t>(elapsed) : 0;
  }

 private:
  CycleClock();

  static std::uint64_t steady_nanoseconds() noexcept {
    return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                          std::chrono::steady_clock::now().time_since_epoch())
                                          .count());
  }

  bool counts_cycles_ = false;  ///< ticks are processor cycles
  double nanoseconds_per_tick_ = 1;
};

}  // namespace ilss
