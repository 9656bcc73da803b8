// The vision line's error by first order and by Monte Carlo: the figures that
// benchmarks/compare_uncertainties holds against the Python package `uncertainties`.
#include "sensors/camera/vision_line.h"

#include <benchmark/benchmark.h>

#include "framework/graph/given_outputs.h"
#include "framework/semantics/monte_carlo.h"
#include "sensors/register.h"

namespace ilss {
namespace {

constexpr std::string_view graph_text = R"(
modules:
  rows: {type: camera, focal_length: 6 mm, pixel_pitch: 40 um, input: {images: [none.png]}}
  target_points: {type: target_points}
  vision_line: {type: vision_line, target_height: HEIGHT, stripe_spacing: 300 mm, focal_length: 6 mm}
network: {serial: [rows, target_points, vision_line]}
)";

/// Three rows of sd 10 um each; `height` may carry an error.
struct Case {
  Plan plan;
  std::unique_ptr<System> system;
  std::size_t rows;
  std::size_t line;

  explicit Case(const std::string& height) : plan(plan_with(height)) {
    rows = *plan.find("target_points");
    line = *plan.find("vision_line");
    Output given{Estimate(*plan.nodes[rows].interface.output, plan.nodes[rows].frame)};
    given.estimate.value = {1.05e-3, 1.0e-3, 0.97e-3};
    for (std::uint32_t i = 0; i < 3; ++i)
      given.estimate.lineage.add({static_cast<std::uint32_t>(rows), i, 0}, i, 10e-6);
    system = std::make_unique<System>(
        plan, 1, SystemOptions{.stand_ins = given_outputs({{rows, {given, true}}})});
    system->expect();
    if (!system->node(line).outcome.has_output()) throw std::runtime_error("no wall line");
  }

  static Plan plan_with(const std::string& height) {
    static const std::unique_ptr<Registry> registry = [] {  // plans refer to its types
      auto made = std::make_unique<Registry>();
      register_sensors(*made);
      return made;
    }();
    Diagnostics diagnostics;
    std::string text(graph_text);
    text.replace(text.find("HEIGHT"), 6, height);
    const Node graph = parse_document(text, "benchmark", diagnostics);
    auto plan = build_plan(graph, ".", *registry, {}, diagnostics);
    for (const Diagnostic& d : diagnostics.sorted()) throw std::runtime_error(format_diagnostic(d));
    return std::move(*plan);
  }
};

constexpr const char* exact_height = "200 mm";
constexpr const char* uncertain_height = "{value: 200 mm, std: 0.2 mm}";

/// Values, lineage and covariance of all four components.
void first_order(benchmark::State& state, const char* height) {
  const Case c(height);
  const auto module = c.plan.nodes[c.line].type->create(c.plan.nodes[c.line].settings);
  const Output* inputs[] = {&c.system->node(c.rows).output()};
  Output output = c.system->node(c.line).output();
  const Evaluation evaluation{.parameters = c.plan.nodes[c.line].parameters, .inputs = inputs};
  Eigen::MatrixXd covariance(4, 4);
  for (auto _ : state) {
    auto outcome = module->evaluate(evaluation, output);
    benchmark::DoNotOptimize(outcome);
    output.estimate.lineage.covariance(covariance);
    benchmark::DoNotOptimize(covariance.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK_CAPTURE(first_order, rows_uncertain, exact_height);
BENCHMARK_CAPTURE(first_order, height_uncertain_too, uncertain_height);

/// A million trials with everything that `ilss predict` prints of them, on all cores.
void monte_carlo_million(benchmark::State& state, const char* height) {
  const Case c(height);
  for (auto _ : state) {
    auto result = run_monte_carlo(*c.system, {c.rows}, {.trials = 1'000'000});
    benchmark::DoNotOptimize(result);
  }
}
BENCHMARK_CAPTURE(monte_carlo_million, rows_uncertain, exact_height)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(monte_carlo_million, height_uncertain_too, uncertain_height)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace ilss
