// The shipped graph of the LEP sensor's line extraction, with its head still and turning.
#include <gtest/gtest.h>

#include "framework/estimate/consistency.h"
#include "framework/runtime/runner.h"
#include "sensors/lep/lep_scan.h"
#include "sensors/register.h"

namespace ilss {
namespace {

Plan shipped_plan() {
  static const Registry* const registry = [] {
    auto* made = new Registry;
    register_sensors(*made);
    return made;
  }();
  Diagnostics diagnostics;
  auto plan = read_plan(ILSS_SOURCE_DIR "/graphs/lep_lines.yaml", *registry, {}, diagnostics);
  for (const Diagnostic& d : diagnostics.sorted()) ADD_FAILURE() << format_diagnostic(d);
  return std::move(plan.value());
}

constexpr double scan_time = 256.0 / 2500;  // s

/// The two walls of scenes/convex_edge.yaml from where the robot stands, 1.2 m before the edge.
void expect_the_two_walls(const Runner& runner, const Plan& plan, int tick) {
  const Output& features = runner.system().node(plan.outputs.front()).output();
  std::vector<const Estimate*> lines;
  for (const Estimate& element : features.elements)
    if (element.type->name == "line_segment") lines.push_back(&element);
  ASSERT_EQ(lines.size(), 2u) << "tick " << tick;
  const double half = std::atan2(1.732, 1.0);
  const double rho = 1.2 * std::sin(half);
  for (std::size_t i = 0; i < 2; ++i) {
    // The left wall recedes to the left, so its normal points to the right.
    const double phi = i == 0 ? half : std::numbers::pi - half;
    const Eigen::Vector2d error(lines[i]->value[0] - rho, lines[i]->value[1] - phi);
    const NormalizedError nees =
        normalized_squared_error(error, lines[i]->lineage.covariance().topLeftCorner(2, 2));
    EXPECT_LT(nees.value, chi_square_quantile(2, 0.99999)) << "tick " << tick << ", line " << i;
    EXPECT_LT(std::abs(error[0]), 0.03);
  }
}

void schedule(Runner& runner, const Plan& plan, const std::string& name, double value,
              double time) {
  for (std::size_t i = 0; i < plan.commands.size(); ++i)
    if (plan.commands[i].name == name) return runner.schedule({i, value, time_at(time)});
  FAIL() << name;
}

TEST(LepLines, AreTwoInEveryScan) {
  const Plan plan = shipped_plan();
  Runner runner(plan, 1);
  for (int tick = 0; tick < 50; ++tick) {
    runner.step(time_at(scan_time * (tick + 1)));
    expect_the_two_walls(runner, plan, tick);
  }
}

TEST(LepLines, StayWhereTheyAreWhileTheHeadTurnsOnCommand) {
  const Plan plan = shipped_plan();
  Runner runner(plan, 2);
  schedule(runner, plan, "turn", 0.15, 0.03);
  schedule(runner, plan, "turn", -0.15, 0.62);
  schedule(runner, plan, "look_at", 0.07, 1.93);
  schedule(runner, plan, "look_at", 4.0, 2.5);
  double least = 0;
  double most = 0;
  for (int tick = 0; tick < 40; ++tick) {
    runner.step(time_at(scan_time * (tick + 1)));
    expect_the_two_walls(runner, plan, tick);
    const auto readings = lep_readings_of(runner.system().node(plan.find("lep").value()).output());
    ASSERT_FALSE(readings.empty());
    const double head = readings.front().head;
    least = std::min(least, head);
    most = std::max(most, head);
  }
  EXPECT_NEAR(most, 0.15 * (0.62 - 0.03), 0.02) << "the head did turn";
  EXPECT_LT(least, -0.08);
  EXPECT_EQ(runner.commander().refused(), 1u) << "4 rad are beyond the stops";
}

/// The shipped system with one wall's mean behind it, and a calibration that is ten times as
/// uncertain, redrawn about the simulated sensor's truth.
Plan averaging_plan(RandomBits& random) {
  static const Registry* const registry = [] {
    auto* made = new Registry;
    register_sensors(*made);
    return made;
  }();
  Diagnostics diagnostics;
  const Node graph = parse_document(
      "ilss: lep_mean\n"
      "modules:\n"
      "  lines: {type: {ilss: lep_lines.yaml}}\n"
      "  wall: {type: wall_from_segments, bearing: 100 deg}\n"
      "  mean: {type: average}\n"
      "network: {serial: [lines, wall, mean]}\n",
      "lep_mean.yaml", diagnostics);
  auto plan = build_plan(graph, ILSS_SOURCE_DIR "/graphs", *registry, {}, diagnostics);
  for (const Diagnostic& d : diagnostics.sorted()) ADD_FAILURE() << format_diagnostic(d);
  const Estimate& truth = plan->nodes[plan->find("lines.lep").value()].parameters;
  Estimate& calibration = plan->nodes[plan->find("lines.ranging").value()].parameters;
  const Lineage fitted = calibration.lineage;
  calibration.lineage.reset(calibration.dimension());
  for (std::size_t i = 0; i < calibration.dimension(); ++i) calibration.value[i] = truth.value[i];
  for (std::size_t k = 0; k < fitted.size(); ++k) {
    std::vector<double> column(fitted.column(k).begin(), fitted.column(k).end());
    const double error = draw_normal(random);
    for (std::size_t i = 0; i < column.size(); ++i) {
      column[i] *= 10;
      calibration.value[i] += column[i] * error;
    }
    calibration.lineage.add(fitted.sources()[k], column);
  }
  return std::move(plan.value());
}

// A mean of 100 scans is as wrong as it says, since its calibration's error does not average out.
TEST(LepLines, MeanOfManyScansIsAsWrongAsItsCalibrationMakesIt) {
  constexpr std::uint64_t seed = 261;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  ConsistencyStatistic statistic;
  double systematic = 0;
  double total = 0;
  for (std::uint64_t run = 0; run < 200; ++run) {
    RandomBits random(derive_seed(seed, run));
    const Plan plan = averaging_plan(random);
    Runner runner(plan, derive_seed(seed + 1, run));
    for (int tick = 0; tick < 100; ++tick) runner.step(time_at(scan_time * (tick + 1)));
    const Estimate& wall = runner.system().node(plan.outputs.front()).output().estimate;
    // How far each of its two points lies from the left wall.
    const double half = std::atan2(1.732, 1.0);
    Eigen::Matrix<double, 2, 4> normal = Eigen::Matrix<double, 2, 4>::Zero();
    normal(0, 0) = normal(1, 2) = std::cos(half);
    normal(0, 1) = normal(1, 3) = std::sin(half);
    const Eigen::Vector2d error =
        normal * wall.vector() - Eigen::Vector2d::Constant(1.2 * std::sin(half));
    statistic.add(
        normalized_squared_error(error, normal * wall.lineage.covariance() * normal.transpose()));
    for (std::size_t k = 0; k < wall.lineage.size(); ++k) {
      const auto column = wall.lineage.column(k);
      const double square =
          std::pow(normal.row(0).dot(Eigen::Map<const Eigen::Vector4d>(column.data())), 2);
      total += square;
      if (wall.lineage.sources()[k].persistent()) systematic += square;
    }
  }
  EXPECT_TRUE(statistic.consistent(0.99)) << statistic.mean();
  EXPECT_GT(systematic / total, 0.98);
}

}  // namespace
}  // namespace ilss
