#include "framework/runtime/cycle_clock.h"

#if defined(__x86_64__)
#include <cpuid.h>
#endif

namespace ilss {

#if defined(__x86_64__)
namespace {

/// Whether the time stamp counter runs at one rate in every power state (CPUID 8000_0007h, EDX bit
/// 8; the kernel's constant_tsc and nonstop_tsc).
bool has_invariant_counter() {
  unsigned a = 0;
  unsigned b = 0;
  unsigned c = 0;
  unsigned d = 0;
  return __get_cpuid(0x80000007, &a, &b, &c, &d) != 0 && (d & (1U << 8U)) != 0;
}

/// The same moment on both clocks.
struct Moment {
  std::uint64_t ticks;
  std::chrono::steady_clock::time_point steady;
};

/// The tightest of several attempts, so that being interrupted between the readings does not count.
Moment read_both() {
  Moment best{};
  std::uint64_t tightest = UINT64_MAX;
  for (int attempt = 0; attempt < 8; ++attempt) {
    const std::uint64_t before = __builtin_ia32_rdtsc();
    const auto steady = std::chrono::steady_clock::now();
    const std::uint64_t after = __builtin_ia32_rdtsc();
    if (after - before >= tightest) continue;
    tightest = after - before;
    best = {before + tightest / 2, steady};
  }
  return best;
}

}  // namespace

CycleClock::CycleClock() : counts_cycles_(has_invariant_counter()) {
  if (!counts_cycles_) return;
  const Moment begin = read_both();
  while (std::chrono::steady_clock::now() < begin.steady + std::chrono::milliseconds(1)) {
  }
  const Moment end = read_both();
  const std::chrono::duration<double, std::nano> elapsed = end.steady - begin.steady;
  nanoseconds_per_tick_ = elapsed.count() / static_cast<double>(end.ticks - begin.ticks);
}
#else
CycleClock::CycleClock() = default;
#endif

const CycleClock& CycleClock::instance() {
  static const CycleClock clock;
  return clock;
}

}  // namespace ilss
