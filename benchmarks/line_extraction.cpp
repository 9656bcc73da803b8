// What the line extractors make of simulated LEP scans: how often they find what is there, whether
// their stated errors are true, and how long they take. Prints docs/lep.md's tables.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "framework/estimate/random.h"
#include "sensors/range/ekf_line_extractor.h"
#include "sensors/range/line_extractor.h"
#include "tests/sensors/lep_rig.h"

namespace {

using namespace ilss;

std::uint64_t seed = 2026;

/// A surface of a scene: a line, or a pillar where `radius` is above 0.
struct Surface {
  InverseLine line = {};
  double x = 0;
  double z = 0;
  double radius = 0;
};

struct Situation {
  std::string name;
  Scene scene;
  std::vector<Surface> surfaces;  ///< that should be found, from left to right
};

struct Variant {
  std::string name;
  std::unique_ptr<Module> module;
};

/// What became of the scans of one situation.
struct Tally {
  std::size_t scans = 0;
  std::size_t exact = 0;    ///< as many segments as surfaces, each of its kind
  std::size_t found = 0;    ///< surfaces that a segment belongs to
  std::size_t extra = 0;    ///< segments beyond those
  double nees_per_dof = 0;  ///< sum over found surfaces
  double batch_nees = 0;    ///< of the fit with known segmentation
  double square[2] = {};    ///< of the errors of rho and phi
  double batch_square[2] = {};
  std::size_t compared = 0;
  double seconds = 0;
  std::size_t readings = 0;
};

Surface wall_surface(const Wall& wall) { return {line_of({}, wall)}; }

std::vector<Situation> situations() {
  std::vector<Situation> list;
  const auto add_edges = [&](const std::string& name, const Scene& scene) {
    Situation s{name, scene, {}};
    for (const Wall& wall : scene.walls) s.surfaces.push_back(wall_surface(wall));
    list.push_back(s);
  };
  add_edges("convex edge, 0.7 m", edge_scene(0.7, 120 * degree));
  add_edges("convex edge, 1.2 m", edge_scene(1.2, 120 * degree));
  add_edges("concave corner, 1.5 m", edge_scene(1.5, 90 * degree, false));
  {
    Situation s{"step of 5 cm, 1 m", {}, {}};
    s.scene.walls = {{{1, -3}, {1, 0.1}, 0.8, {}},
                     {{1, 0.1}, {1.05, 0.1}, 0.8, {}},
                     {{1.05, 0.1}, {1.05, 3}, 0.8, {}}};
    s.surfaces = {wall_surface(s.scene.walls[0]), wall_surface(s.scene.walls[2])};
    list.push_back(s);
  }
  {
    Situation s{"pillar, 0.9 m, before a wall", {}, {}};
    s.scene.walls = {{{1.6, -3}, {1.6, 3}, 0.8, {}}};
    s.scene.pillars = {{{1.0, 0}, 0.1, 0.8}};
    const Surface wall = wall_surface(s.scene.walls[0]);
    s.surfaces = {wall, {{}, 0, 1.0, 0.1}, wall};
    list.push_back(s);
  }
  {
    Situation s{"doorway, 1.2 m, a wall behind", {}, {}};
    s.scene.walls = {{{1.2, -3}, {1.2, -0.2}, 0.8, {}},
                     {{1.2, 0.2}, {1.2, 3}, 0.8, {}},
                     {{2, -3}, {2, 3}, 0.8, {}}};
    const Surface front = wall_surface(s.scene.walls[0]);
    s.surfaces = {front, wall_surface(s.scene.walls[2]), front};
    list.push_back(s);
  }
  return list;
}

/// Squared error of a segment, normalised by its own covariance and divided by its dimensions; and
/// of its rho and phi.
double normalised_error(const Estimate& segment, const Surface& truth, double* square) {
  const bool arc = segment.type->name == ArcSegment<double>::name;
  Eigen::VectorXd error(arc ? 3 : 2);
  if (arc) {
    error << segment.value[0] - truth.x, segment.value[1] - truth.z,
        segment.value[2] - truth.radius;
  } else {
    const double norm = std::hypot(truth.line.x, truth.line.z);
    error << segment.value[0] - 1 / norm,
        wrap_angle(segment.value[1] - std::atan2(truth.line.z, truth.line.x));
    for (int i = 0; i < 2; ++i) square[i] += error[i] * error[i];
  }
  const Eigen::MatrixXd covariance =
      segment.lineage.covariance().topLeftCorner(error.size(), error.size());
  return error.dot(covariance.llt().solve(error)) / static_cast<double>(error.size());
}

/// The readings on each surface of a two-walled edge: up to the ray that passes the apex.
std::vector<ReadingRun> edge_runs(std::span<const RangeReading> readings, double apex) {
  std::size_t corner = 0;
  while (corner < readings.size() &&
         std::atan2(apex - readings[corner].origin_z, -readings[corner].origin_x) <
             readings[corner].bearing)
    ++corner;
  return {{0, corner}, {corner, readings.size()}};
}

void compare_with_batch(const Output& scan, const Situation& situation, Tally& tally) {
  const std::span<const RangeReading> readings = readings_of(scan);
  const auto runs = edge_runs(readings, situation.scene.walls[0].from.x);
  for (std::size_t i = 0; i < 2; ++i) {
    const InverseLine& truth = situation.surfaces[i].line;
    const auto fit = fit_line(readings, std::span(&runs[i], 1), truth,
                              payload_of<RangeScan>(scan.estimate).noise_correlation);
    if (!fit) continue;
    tally.batch_nees += nees(*fit, truth) / 2;
    const double rho = 1 / std::hypot(fit->line.x, fit->line.z) - 1 / std::hypot(truth.x, truth.z);
    const double phi =
        wrap_angle(std::atan2(fit->line.z, fit->line.x) - std::atan2(truth.z, truth.x));
    tally.batch_square[0] += rho * rho;
    tally.batch_square[1] += phi * phi;
  }
}

void judge(const Output& features, const Situation& situation, const Output& scan, Tally& tally) {
  std::vector<const Estimate*> segments;
  for (const Estimate& element : features.elements)
    if (element.type->name == LineSegment<double>::name ||
        element.type->name == ArcSegment<double>::name)
      segments.push_back(&element);
  ++tally.scans;
  const auto is_kind = [](const Estimate& segment, const Surface& surface) {
    return (segment.type->name == ArcSegment<double>::name) == (surface.radius > 0);
  };
  bool exact = segments.size() == situation.surfaces.size();
  for (std::size_t i = 0; exact && i < segments.size(); ++i)
    exact = is_kind(*segments[i], situation.surfaces[i]);
  // A surface is found where a segment of its kind lies within 5 cm and 10 degrees of it.
  std::vector<char> used(segments.size(), 0);
  for (const Surface& surface : situation.surfaces) {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      if (used[i] || !is_kind(*segments[i], surface)) continue;
      const std::vector<double>& v = segments[i]->value;
      const double norm = std::hypot(surface.line.x, surface.line.z);
      const bool near =
          surface.radius > 0
              ? std::hypot(v[0] - surface.x, v[1] - surface.z) < 0.05
              : std::abs(v[0] - 1 / norm) < 0.05 &&
                    std::abs(wrap_angle(v[1] - std::atan2(surface.line.z, surface.line.x))) <
                        10 * degree;
      if (!near) continue;
      used[i] = 1;
      ++tally.found;
      break;
    }
  }
  tally.extra += static_cast<std::size_t>(std::count(used.begin(), used.end(), 0));
  if (!exact) return;
  ++tally.exact;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    tally.nees_per_dof += normalised_error(*segments[i], situation.surfaces[i], tally.square);
    ++tally.compared;
  }
  if (situation.surfaces.size() == 2 && situation.scene.walls.size() == 2)
    compare_with_batch(scan, situation, tally);
}

Variant ours() { return {"", std::make_unique<LineExtractor>(LineExtractor::Options{})}; }

std::vector<Variant> filters() {
  std::vector<Variant> list;
  for (const double gate : {2.0, 3.0, 4.0, 5.0})
    for (const bool clustered : {false, true}) {
      EkfLineExtractor::Options options;
      options.gate = gate;
      if (clustered) options.cluster_gate = gate;
      list.push_back({fmt::format(", g = {}{}", gate, clustered ? ", clustered" : ""),
                      std::make_unique<EkfLineExtractor>(options)});
    }
  return list;
}

void print_head() {
  fmt::print(
      "| scene | right | found | false a scan | NEES | var. of rho | var. of phi | ns a reading |\n"
      "|---|---|---|---|---|---|---|---|\n");
}

void print(const std::string& name, const Tally& t, std::size_t surfaces) {
  const auto n = static_cast<double>(t.scans);
  const auto ratio = [&](int i) {
    return t.batch_square[i] == 0 ? std::string("-")
                                  : fmt::format("{:.2f}", t.square[i] / t.batch_square[i]);
  };
  const double per_surface = t.nees_per_dof / static_cast<double>(t.compared);
  fmt::print("| {} | {:.2f} % | {:.2f} % | {:.2f} | {} | {} | {} | {:.0f} |\n", name,
             100 * static_cast<double>(t.exact) / n,
             100 * static_cast<double>(t.found) / n / static_cast<double>(surfaces),
             static_cast<double>(t.extra) / n,
             t.compared == 0 ? std::string("-") : fmt::format("{:.3f}", per_surface), ratio(0),
             ratio(1), t.seconds * 1e9 / static_cast<double>(t.readings));
}

void run(const Situation& situation, double head_rate, bool bandwidth, std::size_t scans,
         std::vector<Variant> extractors) {
  LepRig rig(situation.scene);
  rig.head_rate = head_rate;
  if (bandwidth) rig.options.bandwidth = 1000;
  std::vector<Tally> tallies(extractors.size());
  std::vector<Output> outputs(extractors.size());
  const Estimate no_parameters_given(no_parameters());
  for (std::size_t k = 0; k < scans; ++k) {
    const Output scan = rig.scan(derive_seed(seed, k));
    const Output* input = &scan;
    for (std::size_t v = 0; v < extractors.size(); ++v) {
      const Evaluation evaluation{
          .tick = 0, .parameters = no_parameters_given, .inputs = {&input, 1}};
      const auto start = std::chrono::steady_clock::now();
      const Outcome<> outcome = extractors[v].module->evaluate(evaluation, outputs[v]);
      tallies[v].seconds +=
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      tallies[v].readings += readings_of(scan).size();
      if (outcome) judge(outputs[v], situation, scan, tallies[v]);
    }
  }
  for (std::size_t v = 0; v < extractors.size(); ++v)
    print(fmt::format("{}{}{}{}", situation.name, head_rate == 0 ? "" : ", head turning",
                      bandwidth ? ", 1 kHz" : "", extractors[v].name),
          tallies[v], situation.surfaces.size());
}

std::vector<Variant> only_ours() {
  std::vector<Variant> list;
  list.push_back(ours());
  return list;
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t scans = argc > 1 ? static_cast<std::size_t>(std::atoi(argv[1])) : 2000;
  if (argc > 2) seed = static_cast<std::uint64_t>(std::atoi(argv[2]));
  const std::vector<Situation> all = situations();
  constexpr double turning = 90 * degree;  // a second
  fmt::print("line_extractor, {} scans each:\n\n", scans);
  print_head();
  for (const Situation& situation : all) {
    run(situation, 0, false, scans, only_ours());
    run(situation, turning, false, scans, only_ours());
    run(situation, 0, true, scans, only_ours());
  }
  fmt::print("\nekf_line_extractor:\n\n");
  print_head();
  for (const std::size_t edge : {0U, 1U}) run(all[edge], 0, false, scans, filters());
  run(all[1], turning, false, scans, filters());
}
