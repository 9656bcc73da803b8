// How long a laser scan takes from beams to features, stage by stage: on real logs, by every
// segmenter, and as the number of beams grows. Prints docs/laser.md's tables.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "framework/module/registry.h"
#include "sensors/features/range_features.h"
#include "sensors/laser/acquire/laser_log.h"
#include "sensors/laser/segment/segmented_scan.h"
#include "sensors/register.h"

namespace {

using namespace ilss;

constexpr std::array<const char*, 8> segmenters = {"split_and_merge",
                                                   "split_and_merge_fuzzy",
                                                   "iterative_end_point_fit",
                                                   "curvature_scale_space",
                                                   "hough",
                                                   "cuba",
                                                   "triangle_area",
                                                   "maximum_likelihood"};

double median(std::vector<double> values) {
  if (values.empty()) return NAN;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A module with all that a tick of it needs.
class Stage {
 public:
  Stage(const Registry& registry, const char* type, const Output* input) {
    const ModuleType* found = registry.find(type);
    parameters_ = Estimate(*found->parameters);
    module_ = found->create({});
    output_.estimate = Estimate(*found->interface({}).output, "robot");
    if (input != nullptr) inputs_ = {input};
  }
  const Output& output() const { return output_; }

  /// Evaluates a tick: its time in microseconds, or nothing on a fault.
  std::optional<double> run(std::int64_t tick) {
    const Evaluation evaluation{tick,   time_at(0.1 * static_cast<double>(tick)), 1, 1, parameters_,
                                inputs_};
    const auto begin = std::chrono::steady_clock::now();
    const bool good = module_->evaluate(evaluation, output_).has_output();
    const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - begin;
    if (!good) return std::nullopt;
    return time.count();
  }

 private:
  Estimate parameters_;
  std::unique_ptr<Module> module_;
  Output output_;
  std::vector<const Output*> inputs_;
};

/// The stages from beams to features, with the times of all scans.
struct Pipeline {
  Stage breakpoints, segmenter, features;
  std::vector<double> breakpoint_times = {}, segmenter_times = {}, feature_times = {}, all = {};

  Pipeline(const Registry& registry, const char* type, const Output* scan)
      : breakpoints(registry, "breakpoints", scan),
        segmenter(registry, type, &breakpoints.output()),
        features(registry, "laser_features", &segmenter.output()) {}

  void run(std::int64_t tick) {
    const auto a = breakpoints.run(tick);
    const auto b = a ? segmenter.run(tick) : std::nullopt;
    const auto c = b ? features.run(tick) : std::nullopt;
    if (a) breakpoint_times.push_back(*a);
    if (b) segmenter_times.push_back(*b);
    if (!c) return;
    feature_times.push_back(*c);
    all.push_back(*a + *b + *c);
  }
};

Output empty_scan() {
  Output scan;
  scan.estimate = Estimate(descriptor<LaserScan>(), "laser");
  return scan;
}

struct Log {
  const char* file;
  LaserLogFormat format;
  double range_std, quantum, no_return;
};

void measure_log(const Registry& registry, const std::filesystem::path& folder, const Log& log) {
  const std::filesystem::path file = folder / log.file;
  if (!std::filesystem::exists(file)) {
    fmt::print("\n{}: skipped, {} is not here\n", log.file, file.string());
    return;
  }
  fmt::print("\n{}\n{:<26}{:>8}{:>14}{:>12}{:>12}{:>12}\n", log.file, "median us a scan", "scans",
             "breakpoints", "segmenter", "features", "all three");
  for (const char* segmenter : segmenters) {
    LaserLog::Options options;
    options.file = file;
    options.format = log.format;
    options.range_std = log.range_std;
    options.quantum = log.quantum;
    options.no_return = log.no_return;
    LaserLog source(options);
    Output scan = empty_scan();
    Pipeline pipeline(registry, segmenter, &scan);
    const Estimate parameters(descriptor<LaserLog::Parameters>());
    std::int64_t tick = 0;
    if (const auto opened = source.open(); !opened) {
      fmt::print("{}: {}\n", segmenter, opened.fault().message);
      continue;
    }
    while (source.evaluate({tick, {}, 1, 1, parameters, {}}, scan).has_output())
      pipeline.run(tick++);
    fmt::print("{:<26}{:>8}{:>14.2f}{:>12.2f}{:>12.2f}{:>12.2f}\n", segmenter, tick,
               median(pipeline.breakpoint_times), median(pipeline.segmenter_times),
               median(pipeline.feature_times), median(pipeline.all));
  }
}

/// A square room, seen all round by so many beams.
void fill_room(std::size_t beams, Output& scan) {
  std::mt19937_64 draw(1);
  constexpr double range_std = 1e-4;  // beams so near to each other do not pass for breaks then
  std::normal_distribution<double> noise(0, range_std);
  const auto rows = make_beams(scan, beams);
  for (std::size_t i = 0; i < beams; ++i) {
    const double bearing = -std::numbers::pi + 2 * std::numbers::pi * static_cast<double>(i) /
                                                   static_cast<double>(beams);
    const double wall = 4 / std::max(std::abs(std::cos(bearing)), std::abs(std::sin(bearing)));
    rows[i] = {bearing, wall + noise(draw)};
  }
  assign<LaserScan>(scan.estimate,
                    {.range_std = range_std, .bearing_std = 0, .quantum = 0, .max_range = 80});
}

void measure_growth(const Registry& registry) {
  fmt::print("\nA square room, beams all round; ns a beam, breakpoints to features\n{:<26}",
             "segmenter");
  constexpr std::array<std::size_t, 6> sizes = {360, 1000, 3000, 10000, 30000, 100000};
  for (const std::size_t beams : sizes) fmt::print("{:>10}", beams);
  fmt::print("\n");
  for (const char* segmenter : {"iterative_end_point_fit", "triangle_area"}) {
    fmt::print("{:<26}", segmenter);
    for (const std::size_t beams : sizes) {
      Output scan = empty_scan();
      fill_room(beams, scan);
      Pipeline pipeline(registry, segmenter, &scan);
      const auto runs = static_cast<std::int64_t>(std::max<std::size_t>(5, 300000 / beams));
      for (std::int64_t tick = 0; tick < runs; ++tick) pipeline.run(tick);
      fmt::print("{:>10.1f}", 1e3 * median(pipeline.all) / static_cast<double>(beams));
    }
    fmt::print("\n");
  }
}

}  // namespace

/// laser_features [FOLDER]: where the logs are, ../shared/data/laser by default.
int main(int argc, char** argv) {
  Registry registry;
  register_sensors(registry);
  const std::filesystem::path folder = argc > 1 ? argv[1] : "../shared/data/laser";
  constexpr std::array<Log, 4> logs = {
      {{"intel-corrected.log.gz", LaserLogFormat::flaser, 0.005, 0.01, 40},
       {"freiburg-101-corrected.log.gz", LaserLogFormat::flaser, 0.005, 0.01, 40},
       {"freiburg-079-corrected.log.gz", LaserLogFormat::flaser, 0.005, 0.01, 40},
       {"urg04lx-exp1.dat.gz", LaserLogFormat::urg, 0.01, 0.001, 5.6}}};
  for (const Log& log : logs) measure_log(registry, folder, log);
  measure_growth(registry);
}
