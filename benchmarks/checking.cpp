// What checking a graph costs. Claim: reading a generated graph of 1,000 modules into a plan, every
// check included, takes at most twice what yaml-cpp takes to parse its text.
// Run: build/release/bin/bench_checking --benchmark_repetitions=9
// --benchmark_report_aggregates_only Compare figures of one run only.
#include <benchmark/benchmark.h>
#include <yaml-cpp/yaml.h>

#include "benchmarks/chain.h"

namespace ilss::benchmarks {
namespace {

constexpr std::size_t modules = 1'000;

/// Modules with two quantities each, one of them with an uncertainty, fed in turn by one of ten
/// sensors; all side by side.
std::string wide_text() {
  constexpr std::size_t sensors = 10;
  std::string list = "ilss: wide\ndescription: A generated graph\nmodules:\n";
  std::string network = "network:\n  combine:\n";
  for (std::size_t i = 0; i < sensors; ++i)
    list += fmt::format("  sensor_{}: {{type: noisy_number}}\n", i);
  for (std::size_t i = 0; i < modules - sensors; ++i) {
    list += fmt::format(
        "  shift_{}:\n    type: shift\n    by: {{value: {} mm, std: 0.5 mm}}\n    again: {} cm\n",
        i, i, i % 7);
    network += fmt::format("    - serial: [sensor_{}, shift_{}]\n", i % sensors, i);
  }
  return list + network;
}

void yaml_cpp_load(benchmark::State& state, const std::string& text) {
  for (auto _ : state) benchmark::DoNotOptimize(YAML::Load(text));
}

void parse_and_build_plan(benchmark::State& state, const std::string& text) {
  for (auto _ : state) benchmark::DoNotOptimize(plan_of(text));
}

void parse_only(benchmark::State& state, const std::string& text) {
  for (auto _ : state) {
    Diagnostics diagnostics;
    benchmark::DoNotOptimize(parse_document(text, "benchmark.yaml", diagnostics));
  }
}

BENCHMARK_CAPTURE(yaml_cpp_load, wide, wide_text());
BENCHMARK_CAPTURE(parse_only, wide, wide_text());
BENCHMARK_CAPTURE(parse_and_build_plan, wide, wide_text());
BENCHMARK_CAPTURE(yaml_cpp_load, chain, chain_text(modules, "tick_number", "plus_one"));
BENCHMARK_CAPTURE(parse_only, chain, chain_text(modules, "tick_number", "plus_one"));
BENCHMARK_CAPTURE(parse_and_build_plan, chain, chain_text(modules, "tick_number", "plus_one"));

}  // namespace
}  // namespace ilss::benchmarks
