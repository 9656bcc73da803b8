// What a tick costs beside the modules' own work. Claims, on one thread:
//  - a chain of 8 trivial modules takes about 12 ns a module; oneTBB's flow graph takes for the
//    same (function nodes, lightweight policy) from 0.6 times that to twice as much, by processor;
//  - with its instruments (a latency histogram per module) at most 50 ns a module;
//  - the cost of a tick grows linearly to 10,000 modules.
// Run: build/release/bin/bench_dispatch --benchmark_repetitions=9
// --benchmark_report_aggregates_only `per_module` is the time per module (n: ns). Compare figures
// of one run only.
#include <benchmark/benchmark.h>
#include <oneapi/tbb/flow_graph.h>

#include <memory>
#include <vector>

#include "benchmarks/chain.h"
#include "framework/graph/system.h"
#include "framework/runtime/runner.h"

namespace ilss::benchmarks {
namespace {

constexpr std::size_t chain_length = 8;

benchmark::Counter per_module(std::size_t modules) {
  return {static_cast<double>(modules),
          benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert};
}

/// A run without an output would be fast for the wrong reason.
void check_output(const System& system, benchmark::State& state) {
  if (!system.node(system.size() - 1).outcome.has_output())
    state.SkipWithError("the chain gave no output");
}

void evaluate_chain(benchmark::State& state, std::string_view first, std::string_view then) {
  const auto size = static_cast<std::size_t>(state.range(0));
  const Plan plan = plan_of(chain_text(size, first, then));
  System system(plan, 1);
  double time = 0;
  for (auto _ : state) system.evaluate(time_at(time += 0.001));
  check_output(system, state);
  state.counters["per_module"] = per_module(size);
}
BENCHMARK_CAPTURE(evaluate_chain, trivial, "tick_number", "plus_one")
    ->Arg(chain_length)
    ->RangeMultiplier(10)
    ->Range(10, 10'000);
BENCHMARK_CAPTURE(evaluate_chain, function_of_one_source, "noisy_number", "shift")
    ->Arg(chain_length);

void run_chain_with_instruments(benchmark::State& state, std::string_view first,
                                std::string_view then) {
  const Plan plan = plan_of(chain_text(chain_length, first, then));
  Runner runner(plan);
  double time = 0;
  for (auto _ : state) runner.step(time_at(time += 0.001));
  check_output(runner.system(), state);
  state.counters["per_module"] = per_module(chain_length);
}
BENCHMARK_CAPTURE(run_chain_with_instruments, trivial, "tick_number", "plus_one");
BENCHMARK_CAPTURE(run_chain_with_instruments, function_of_one_source, "noisy_number", "shift");

/// The same chain in oneTBB. The bodies are noexcept: otherwise the policy has no effect. A message
/// goes all the way within try_put, so nothing is waited for between messages.
void flow_graph_chain(benchmark::State& state) {
  namespace flow = oneapi::tbb::flow;
  using FlowNode = flow::function_node<double, double, flow::lightweight>;
  flow::graph graph;
  double last = 0;
  std::vector<std::unique_ptr<FlowNode>> nodes;
  for (std::size_t i = 0; i + 1 < chain_length; ++i)
    nodes.push_back(std::make_unique<FlowNode>(graph, flow::unlimited,
                                               [](double x) noexcept { return x + 1; }));
  nodes.push_back(std::make_unique<FlowNode>(graph, flow::unlimited,
                                             [&last](double x) noexcept { return last = x + 1; }));
  for (std::size_t i = 1; i < nodes.size(); ++i) flow::make_edge(*nodes[i - 1], *nodes[i]);
  double tick = 0;
  for (auto _ : state) {
    nodes.front()->try_put(tick += 1);
    benchmark::DoNotOptimize(last);
  }
  if (last != tick + static_cast<double>(chain_length))
    state.SkipWithError("the message did not arrive within try_put");
  graph.wait_for_all();
  state.counters["per_module"] = per_module(chain_length);
}
BENCHMARK(flow_graph_chain);

}  // namespace
}  // namespace ilss::benchmarks
