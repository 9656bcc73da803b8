// What a scan of the LEP sensor costs: simulation, ranging and extraction, bare and through the
// runtime with its instruments. 256 readings; times are per reading, but for the simulation.
#include <benchmark/benchmark.h>

#include <algorithm>

#include "framework/graph/plan.h"
#include "framework/runtime/runner.h"
#include "sensors/range/line_extractor.h"
#include "sensors/range/scan_lines.h"
#include "sensors/register.h"
#include "tests/sensors/lep_rig.h"

namespace {

using namespace ilss;

/// Ten walls: a corridor with boxes.
Scene ten_walls() {
  Scene scene;
  const auto wall = [&](ScenePoint from, ScenePoint to) {
    scene.walls.push_back({from, to, 0.8, {}});
  };
  wall({0, -1}, {1.2, -1});
  wall({1.2, -1}, {1.2, -0.6});
  wall({1.2, -0.6}, {1.6, -0.6});
  wall({1.6, -0.6}, {1.6, -1});
  wall({1.6, -1}, {2.2, -1});
  wall({2.2, -1}, {2.2, 1});
  wall({2.2, 1}, {1.4, 1});
  wall({1.4, 1}, {1.4, 0.5});
  wall({1.4, 0.5}, {1.0, 0.5});
  wall({1.0, 0.5}, {1.0, 1});
  return scene;
}

void per_reading(benchmark::State& state, std::size_t readings) {
  state.counters["per reading"] =
      benchmark::Counter(static_cast<double>(readings) * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void simulate_scan_of_ten_walls(benchmark::State& state) {
  const LepRig rig(ten_walls());
  std::uint64_t seed = 0;
  for (auto _ : state) benchmark::DoNotOptimize(rig.images(++seed));
}
BENCHMARK(simulate_scan_of_ten_walls)->Unit(benchmark::kMicrosecond);

void range_scan(benchmark::State& state) {
  const LepRig rig(ten_walls());
  const Output images = rig.images(1);
  Output ranges;
  ranges.estimate = Estimate(descriptor<RangeScan>(), "lep");
  LepRanging ranging;
  const Output* input = &images;
  const Evaluation evaluation{
      .tick = 0, .parameters = rig.ranging_parameters, .inputs = {&input, 1}};
  for (auto _ : state) benchmark::DoNotOptimize(ranging.evaluate(evaluation, ranges).has_output());
  per_reading(state, readings_of(ranges).size());
}
BENCHMARK(range_scan);

/// Finding and fitting the segments, without their estimates.
void extract_segments(benchmark::State& state) {
  const LepRig rig(edge_scene(1.2, 120 * degree));
  const Output scan = rig.scan(1);
  const auto shared = payload_of<RangeScan>(scan.estimate);
  ScanLines lines{ScanLinesRule{}};
  for (auto _ : state) {
    lines.begin(shared.noise_correlation, shared.beam_width);
    for (const RangeReading& reading : readings_of(scan)) lines.add(reading);
    lines.finish();
    benchmark::DoNotOptimize(lines.segments().size());
  }
  per_reading(state, readings_of(scan).size());
}
BENCHMARK(extract_segments);

/// `line_extractor` in a running system, fed a scan at every tick.
class GivenScan final : public Module {
 public:
  static constexpr std::string_view name = "given_scan";
  static constexpr std::string_view description = "one scan again and again";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static Interface interface() { return {{}, &descriptor<RangeScan>(), "lep", {}}; }
  Outcome<> evaluate(const Evaluation&, Output& output) override {
    static const Output scan = LepRig(edge_scene(1.2, 120 * degree)).scan(1);
    output = scan;
    return {};
  }
};

void run_line_extractor(benchmark::State& state) {
  Registry registry;
  register_sensors(registry);
  registry.add<GivenScan>();
  Diagnostics diagnostics;
  const Node graph = parse_document(
      "{ilss: lines, modules: {scan: {type: given_scan}, lines: {type: line_extractor}}, "
      "network: {serial: [scan, lines]}}",
      "lines.yaml", diagnostics);
  const auto plan = build_plan(graph, ".", registry, {}, diagnostics);
  Runner runner(*plan);
  double time = 0;
  for (auto _ : state) runner.step(time_at(time += 0.1));
  per_reading(state, 256);
}
BENCHMARK(run_line_extractor);

}  // namespace
