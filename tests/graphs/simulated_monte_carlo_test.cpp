// Monte Carlo of whole shipped systems: readings drawn anew, constants wrong in every use alike.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "framework/semantics/monte_carlo.h"
#include "sensors/register.h"

namespace ilss {
namespace {

/// First order and Monte Carlo of a shipped graph.
struct Drawn {
  Plan plan;
  System system;
  MonteCarloOutput result;

  Drawn(const std::string& graph, const std::vector<std::string>& sets, std::size_t trials)
      : plan(read(graph, sets)), system(plan, 1) {
    system.expect();
    result = run_monte_carlo(system, {}, {.trials = trials}).at(0);
  }
  double first_order(std::size_t c) const {
    return system.node(plan.outputs.front()).output().estimate.lineage.standard_deviation(c);
  }
  double deviation(std::size_t c) const {
    const auto i = static_cast<Eigen::Index>(c);
    return std::sqrt(result.covariance(i, i));
  }

  static Plan read(const std::string& graph, const std::vector<std::string>& sets) {
    static const Registry& registry = *[] {  // which plans refer to
      auto* made = new Registry;
      register_sensors(*made);
      return made;
    }();
    Diagnostics diagnostics;
    std::vector<Override> overrides;
    for (const std::string& set : sets)
      overrides.push_back(parse_override(set, "test", diagnostics).value());
    auto plan = read_plan(ILSS_SOURCE_DIR "/graphs/" + graph, registry, overrides, diagnostics);
    for (const Diagnostic& d : diagnostics.sorted()) ADD_FAILURE() << format_diagnostic(d);
    return std::move(plan.value());
  }
};

TEST(SimulatedMonteCarlo, OfSonarsIsTheirFirstOrder) {
  const Drawn drawn("wall_pose_sonar.yaml", {}, 100'000);
  for (std::size_t c = 0; c < 4; ++c) {
    EXPECT_NEAR(drawn.deviation(c), drawn.first_order(c), 0.02 * drawn.first_order(c));
    EXPECT_NEAR(drawn.result.coverage[c], 0.95, 0.005);
  }
}

// Both sonars' mounts are wrong by far more than they scatter: the scene does not know it, the
// wall line must suffer from it.
TEST(SimulatedMonteCarlo, ShowsSystematicErrorsThatTheSimulationDoesNotHave) {
  const Drawn drawn("wall_pose_sonar.yaml",
                    {"left.range_std=1 um", "right.range_std=1 um", "left.mount.z.std=5 mm",
                     "right.mount.z.std=5 mm"},
                    20'000);
  EXPECT_GT(drawn.first_order(1), 4e-3);
  for (const std::size_t c : {1, 3})
    EXPECT_NEAR(drawn.deviation(c), drawn.first_order(c), 0.03 * drawn.first_order(c));
}

// One target height feeds the camera system once, whatever else is drawn.
TEST(SimulatedMonteCarlo, OfTheFusedSystemRedoesImageSonarsAndWeights) {
  const Drawn drawn("wall_pose_fused.yaml", {}, 1500);
  for (std::size_t c = 0; c < 2; ++c)
    EXPECT_NEAR(drawn.deviation(c), drawn.first_order(c), 0.08 * drawn.first_order(c));
  EXPECT_EQ(drawn.result.faults, 0U);
}

}  // namespace
}  // namespace ilss
