// What instrumentation costs: a clock reading, and recording a latency.
#include <benchmark/benchmark.h>

#include <array>
#include <chrono>
#include <random>
#include <vector>

#include "framework/runtime/cycle_clock.h"
#include "framework/runtime/latency_histogram.h"

namespace ilss {
namespace {

void steady_clock_now(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(std::chrono::steady_clock::now());
}
BENCHMARK(steady_clock_now);

void cycle_clock_now(benchmark::State& state) {
  const CycleClock& clock = CycleClock::instance();
  for (auto _ : state) benchmark::DoNotOptimize(clock.now());
}
BENCHMARK(cycle_clock_now);

void record_latency(benchmark::State& state) {
  std::mt19937 generator(1);
  std::lognormal_distribution<double> duration(5, 1);
  std::vector<std::uint64_t> durations(1024);
  for (auto& d : durations) d = static_cast<std::uint64_t>(duration(generator));
  LatencyHistogram histogram;
  std::size_t i = 0;
  for (auto _ : state) histogram.record(durations[i++ % durations.size()]);
  benchmark::DoNotOptimize(histogram.count());
}
BENCHMARK(record_latency);

/// One clock reading, its conversion and its record: what a module in a chain pays.
void read_and_record(benchmark::State& state) {
  const CycleClock& clock = CycleClock::instance();
  LatencyHistogram histogram;
  std::uint64_t last = clock.now();
  for (auto _ : state) {
    const std::uint64_t now = clock.now();
    histogram.record(clock.nanoseconds(last, now));
    last = now;
  }
  benchmark::DoNotOptimize(histogram.count());
}
BENCHMARK(read_and_record);

/// The same for eight modules in a row, the readings kept and recorded at the tick's end: the
/// counter waits for earlier instructions, so conversions between readings would lengthen them.
void read_eight_then_record(benchmark::State& state) {
  const CycleClock& clock = CycleClock::instance();
  std::vector<LatencyHistogram> histograms(8);
  std::array<std::uint64_t, 9> readings{};
  for (auto _ : state) {
    for (auto& reading : readings) benchmark::DoNotOptimize(reading = clock.now());
    for (std::size_t i = 0; i < histograms.size(); ++i)
      histograms[i].record(clock.nanoseconds(readings[i], readings[i + 1]));
  }
  benchmark::DoNotOptimize(histograms.data());
}
BENCHMARK(read_eight_then_record);

}  // namespace
}  // namespace ilss
