// The shipped graph that fuses camera and sonars, at the simulated wall.
#include <gtest/gtest.h>

#include "framework/estimate/consistency.h"
#include "framework/semantics/verdict.h"
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
  auto plan = read_plan(ILSS_SOURCE_DIR "/graphs/wall_pose_fused.yaml", *registry, {}, diagnostics);
  for (const Diagnostic& d : diagnostics.sorted()) ADD_FAILURE() << format_diagnostic(d);
  return std::move(plan.value());
}

const Estimate& estimate_of(const System& system, const std::string& node) {
  return system.node(system.plan().find(node).value()).output().estimate;
}

TEST(WallPoseFused, IsPredictedToBeBetterThanEitherSystem) {
  const Plan plan = shipped_plan();
  System system(plan, 1);
  system.expect();
  const Estimate& fused = estimate_of(system, "fused");
  for (const char* alone : {"vision_pose", "sonar_pose"})
    for (std::size_t c = 0; c < 2; ++c)
      EXPECT_LT(fused.lineage.standard_deviation(c),
                estimate_of(system, alone).lineage.standard_deviation(c))
          << alone;
  EXPECT_EQ(judge(system).at(0).verdict, Verdict::linear_ok);
}

TEST(WallPoseFused, RandomErrorsOfTheRunAreAsStated) {
  const std::uint64_t seed = 1;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  const Plan plan = shipped_plan();
  System system(plan, seed);
  const std::vector<double> truth = {1.242, 0};
  ConsistencyStatistic statistic;
  for (int tick = 0; tick < 2000; ++tick) {
    system.evaluate(time_at(0.1 * tick));
    Estimate fused = estimate_of(system, "fused");
    Lineage random(2);  // a run's constants are as stated
    for (std::size_t k = 0; k < fused.lineage.size(); ++k)
      if (!fused.lineage.sources()[k].persistent())
        random.add(fused.lineage.sources()[k], fused.lineage.column(k));
    fused.lineage = random;
    statistic.add(nees(fused, truth));
  }
  EXPECT_TRUE(statistic.consistent(0.99)) << statistic.mean();
}

}  // namespace
}  // namespace ilss
