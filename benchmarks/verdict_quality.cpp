// How good the verdicts are: at random operating points of the shipped wall-pose systems each
// verdict is held against what Monte Carlo finds. Prints the table of docs/error_model.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cmath>
#include <map>
#include <mutex>
#include <thread>

#include "framework/graph/given_outputs.h"
#include "framework/graph/plan.h"
#include "framework/semantics/monte_carlo.h"
#include "framework/semantics/verdict.h"
#include "sensors/register.h"

namespace ilss {
namespace {

/// A system and which of its modules' outputs are judged.
struct Subject {
  std::string name;
  std::string graph;
};

const std::string graph_start = R"(
constants: {robot_x: -1 m, robot_heading: 0 deg}
modules:
  system:
    type: {ilss: GRAPH}
    set: {constants.robot_x: $robot_x, constants.robot_heading: $robot_heading}
)";

std::string graph_of(const std::string& file, const std::string& rest) {
  std::string text = graph_start + rest;
  return text.replace(text.find("GRAPH"), 5, file);
}

std::vector<Subject> subjects() {
  const std::string vision = "wall_pose_vision.yaml";
  const std::string sonar = "wall_pose_sonar.yaml";
  return {{"vision: wall points", graph_of(vision, "network: system\n")},
          {"vision: wall pose",
           graph_of(vision,
                    "  to_robot: {type: planar_transform}\n  pose: {type: wall_pose}\n"
                    "network: {serial: [system, to_robot, pose]}\n")},
          {"sonar: wall points", graph_of(sonar, "network: system\n")},
          {"sonar: wall pose",
           graph_of(sonar, "  pose: {type: wall_pose}\nnetwork: {serial: [system, pose]}\n")}};
}

/// What one operating point showed.
struct Point {
  Verdict verdict;
  bool piloted;
  bool fine;            ///< intervals and ellipsoid hold 93 to 97 %, nearly all trials answer
  bool intervals_fine;  ///< the components' intervals alone
  double scale;
};

constexpr double least_coverage = 0.93;
constexpr double most_coverage = 0.97;

bool within(double coverage) {
  return std::isnan(coverage) || (coverage >= least_coverage && coverage <= most_coverage);
}

/// Multiplies every error of the plan's parameters.
void scale_errors(Plan& plan, double factor) {
  for (PlanNode& node : plan.nodes) {
    Lineage scaled(node.parameters.dimension());
    std::vector<double> column;
    for (std::size_t k = 0; k < node.parameters.lineage.size(); ++k) {
      const auto from = node.parameters.lineage.column(k);
      column.assign(from.begin(), from.end());
      for (double& x : column) x *= factor;
      scaled.add(node.parameters.lineage.sources()[k], column);
    }
    node.parameters.lineage = std::move(scaled);
  }
}

/// The same for what its sensors and estimators are expected to add.
std::map<std::size_t, OperatingPoint> scaled_outputs(const Plan& plan, const System& nominal,
                                                     double factor) {
  std::map<std::size_t, OperatingPoint> points;
  for (std::size_t i = 0; i < plan.nodes.size(); ++i) {
    if (plan.nodes[i].type->kind == ModuleKind::function) continue;
    if (!nominal.node(i).outcome.has_output()) continue;
    if (plan.nodes[i].interface.output->samples) continue;
    Output output = nominal.node(i).output();
    Lineage scaled(output.estimate.dimension());
    std::vector<double> column;
    for (std::size_t k = 0; k < output.estimate.lineage.size(); ++k) {
      const auto from = output.estimate.lineage.column(k);
      column.assign(from.begin(), from.end());
      for (double& x : column) x *= factor;
      scaled.add(output.estimate.lineage.sources()[k], column);
    }
    output.estimate.lineage = std::move(scaled);
    points[i] = {std::move(output), true};
  }
  return points;
}

double uniform(RandomBits& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1p-53);
}

/// One random point of a system: nothing where the system gives no answer there to begin with.
std::optional<Point> examine(const Subject& subject, const Registry& registry,
                             const std::filesystem::path& graphs, std::uint64_t seed,
                             std::size_t trials) {
  RandomBits random(seed);
  const double range = uniform(random, 0.5, 3.0);
  const double heading = uniform(random, -30, 30);
  // From the stated errors to sixty times as much, so that both kinds of verdict are met.
  const double scale = std::exp(uniform(random, 0, std::log(60)));
  Diagnostics diagnostics;
  const auto set = [&](const std::string& text) {
    return *parse_override(text, "point", diagnostics);
  };
  const Node graph = parse_document(subject.graph, "verdict_quality", diagnostics);
  auto plan = build_plan(graph, graphs, registry,
                         {set(fmt::format("constants.robot_x={} m", -range)),
                          set(fmt::format("constants.robot_heading={} deg", heading))},
                         diagnostics);
  if (!plan) {
    for (const Diagnostic& d : diagnostics.sorted())
      fmt::print(stderr, "{}\n", format_diagnostic(d));
    std::exit(2);
  }
  System nominal(*plan, 1);
  nominal.expect();
  if (!nominal.node(plan->outputs.front()).outcome.has_output()) return std::nullopt;
  const auto points = scaled_outputs(*plan, nominal, scale);
  scale_errors(*plan, scale);
  System system(*plan, 1, {.stand_ins = given_outputs(points)});
  system.expect();
  if (!system.node(plan->outputs.front()).outcome.has_output()) return std::nullopt;
  const VerdictReport report = judge(system).front();
  Perturbation perturbation(system, plan->outputs, {}, Redo::functions);
  const MonteCarloOutput truth = run_monte_carlo(system, perturbation, trials, seed).front();
  Point point{report.verdict, report.piloted, false, false, scale};
  point.intervals_fine = std::all_of(truth.coverage.begin(), truth.coverage.end(), within);
  point.fine = point.intervals_fine && within(truth.joint_coverage) &&
               static_cast<double>(truth.faults) <=
                   largest_fault_share * static_cast<double>(truth.trials + truth.faults);
  return point;
}

std::string percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? "-"
                    : fmt::format("{:.1f} %",
                                  100.0 * static_cast<double>(part) / static_cast<double>(whole));
}

void print_row(const std::string& name, const std::vector<Point>& points) {
  std::map<Verdict, std::size_t> count;
  std::size_t believed_fine = 0;
  std::size_t intervals_fine = 0;
  std::size_t doubted_fine = 0;
  std::size_t piloted = 0;
  for (const Point& point : points) {
    ++count[point.verdict];
    piloted += point.piloted;
    const bool believed = point.verdict == Verdict::linear_ok;
    believed_fine += believed && point.fine;
    intervals_fine += believed && point.intervals_fine;
    doubted_fine += !believed && point.fine;
  }
  const std::size_t believed = count[Verdict::linear_ok];
  fmt::print("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", name, points.size(),
             percent(believed, points.size()), percent(intervals_fine, believed),
             percent(believed_fine, believed), percent(count[Verdict::second_order], points.size()),
             percent(count[Verdict::monte_carlo_required], points.size()),
             percent(count[Verdict::invalid], points.size()),
             percent(doubted_fine, points.size() - believed), percent(piloted, points.size()));
}

struct Arguments {
  std::size_t points = 6000;
  std::size_t trials = 100'000;
  std::uint64_t seed = 1;
  std::string graphs = "graphs";
};

void measure(const Arguments& arguments) {
  Registry registry;
  register_sensors(registry);
  const std::vector<Subject> all = subjects();
  std::vector<std::vector<Point>> found(all.size());
  std::mutex mutex;
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < arguments.points; i = next++) {
      const std::size_t s = i % all.size();
      // A point that a system does not answer at is drawn anew.
      for (std::uint64_t again = 0;; ++again) {
        const std::uint64_t seed = derive_seed(derive_seed(arguments.seed, i), again);
        const auto point = examine(all[s], registry, arguments.graphs, seed, arguments.trials);
        if (!point) continue;
        const std::lock_guard lock(mutex);
        found[s].push_back(*point);
        break;
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (unsigned t = 0; t < std::max(1U, std::thread::hardware_concurrency()); ++t)
      threads.emplace_back(work);
  }
  fmt::print(
      "| output | points | linear_ok | of these, intervals hold | ... and ellipsoid | "
      "second_order | monte_carlo_required | invalid | of the others, would have held | "
      "piloted |\n|---|---|---|---|---|---|---|---|---|---|\n");
  std::vector<Point> together;
  for (std::size_t s = 0; s < all.size(); ++s) {
    print_row(all[s].name, found[s]);
    together.insert(together.end(), found[s].begin(), found[s].end());
  }
  print_row("all", together);
}

}  // namespace
}  // namespace ilss

int main(int argc, char** argv) {
  ilss::Arguments arguments;
  CLI::App app("Verdicts at random operating points, held against Monte Carlo");
  app.add_option("--points", arguments.points, "Operating points")->capture_default_str();
  app.add_option("--trials", arguments.trials, "Trials a point")->capture_default_str();
  app.add_option("--seed", arguments.seed, "Seed")->capture_default_str();
  app.add_option("--graphs", arguments.graphs, "Folder of the shipped graphs")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  ilss::measure(arguments);
  return 0;
}
