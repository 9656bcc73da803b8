// What a second thread brings. Claim: two branches of 5 ms each take at most 0.6 of one thread's
// time in two. Run: build/release/bin/bench_parallel --benchmark_repetitions=9
// --benchmark_report_aggregates_only (real time; two free processors)
#include <benchmark/benchmark.h>

#include <chrono>

#include "benchmarks/chain.h"
#include "framework/runtime/runner.h"

namespace ilss::benchmarks {
namespace {

/// Works for 5 ms.
class Busy final : public Module {
 public:
  static constexpr std::string_view name = "busy";
  static constexpr std::string_view description = "Works for 5 ms";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static Interface interface() { return {{}, &descriptor<Number>(), "robot", {}}; }
  Outcome<> evaluate(const Evaluation&, Output& output) override {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(5);
    double value = 1;
    while (std::chrono::steady_clock::now() < end) benchmark::DoNotOptimize(value += 1e-9);
    output.estimate.value[0] = value;
    return {};
  }
};

void two_branches(benchmark::State& state) {
  Registry modules;
  modules.add<Busy>();
  Diagnostics diagnostics;
  const Node graph = parse_document(
      "modules: {left: {type: busy}, right: {type: busy}}\nnetwork: {combine: [left, right]}\n",
      "benchmark.yaml", diagnostics);
  const auto plan = build_plan(graph, ".", modules, {}, diagnostics);
  if (!plan) return state.SkipWithError("no plan");
  Runner runner(*plan, 1, {}, static_cast<unsigned>(state.range(0)));
  double time = 0;
  for (auto _ : state) runner.step(time_at(time += 0.1));
}
BENCHMARK(two_branches)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ilss::benchmarks
