// The cycle clock against std::chrono::steady_clock.
#include "framework/runtime/cycle_clock.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace ilss {
namespace {

using std::chrono::steady_clock;

double nanoseconds(steady_clock::duration duration) {
  return std::chrono::duration<double, std::nano>(duration).count();
}

TEST(CycleClock, NeverGoesBack) {
  const CycleClock& clock = CycleClock::instance();
  std::uint64_t last = clock.now();
  for (int i = 0; i < 1'000'000; ++i) {
    const std::uint64_t now = clock.now();
    ASSERT_GE(now, last);
    last = now;
  }
}

TEST(CycleClock, AgreesWithSteadyClockWithinOnePercent) {
  // Each reading stands between two of the steady clock: being interrupted widens the bounds, and
  // cannot fail the test.
  const CycleClock& clock = CycleClock::instance();
  const auto before_begin = steady_clock::now();
  const std::uint64_t begin = clock.now();
  const auto after_begin = steady_clock::now();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const auto before_end = steady_clock::now();
  const std::uint64_t end = clock.now();
  const auto after_end = steady_clock::now();
  const auto elapsed = static_cast<double>(clock.nanoseconds(begin, end));
  EXPECT_GE(elapsed, 0.99 * nanoseconds(before_end - after_begin));
  EXPECT_LE(elapsed, 1.01 * nanoseconds(after_end - before_begin));
}

TEST(CycleClock, TimeBetweenReadingsInTheWrongOrderIsZero) {
  const CycleClock& clock = CycleClock::instance();
  const std::uint64_t now = clock.now();
  EXPECT_EQ(clock.nanoseconds(now, now - 5), 0U);
}

TEST(CycleClock, IsOneClockForAllThreads) {
  std::vector<const CycleClock*> seen(4);
  std::vector<std::thread> threads;
  for (const CycleClock*& entry : seen)
    threads.emplace_back([&entry] { entry = &CycleClock::instance(); });
  for (std::thread& thread : threads) thread.join();
  for (const CycleClock* entry : seen) EXPECT_EQ(entry, &CycleClock::instance());
}

}  // namespace
}  // namespace ilss
