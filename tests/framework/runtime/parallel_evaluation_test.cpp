// Ticks by several threads give what ticks by one give.
#include "framework/runtime/parallel_evaluation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/framework/runtime/test_modules.h"

namespace ilss {
namespace {

using runtime_test::plan_of;

/// Layers of modules that each take two of the layer above, with a selector in the middle.
std::string layers(int width, int depth) {
  std::string modules = "  use: {type: switch}\n";
  for (int i = 0; i < width; ++i) {
    modules += "  s" + std::to_string(i) +
               ": {type: counter, std: 1, period: " + std::to_string(1 + i % 3) + "}\n";
    for (int d = 0; d < depth; ++d)
      modules += "  m" + std::to_string(d) + "_" + std::to_string(i) + ": {type: subtract}\n";
  }
  const auto name = [](int d, int i) {
    return d < 0 ? "s" + std::to_string(i) : "m" + std::to_string(d) + "_" + std::to_string(i);
  };
  std::string all = "ilss: layers\nmodules:\n" + modules + "network:\n  combine:\n";
  for (int d = 0; d < depth; ++d)
    for (int i = 0; i < width; ++i)
      all += "    - {serial: [{combine: [" + name(d - 1, i) + ", " + name(d - 1, (i + 1) % width) +
             "]}, " + name(d, i) + "]}\n";
  all += "    - {serial: [{combine: [" + name(depth - 1, 0) + ", " + name(depth - 1, 1) +
         "]}, use]}\n";
  return all;
}

TEST(ParallelEvaluation, GivesTheSameOutputsAsOneThread) {
  const Plan plan = plan_of(layers(8, 4));
  System one(plan, 5);
  System several(plan, 5);
  ParallelEvaluation parallel(several, 4);
  std::vector<std::uint64_t> counts(plan.nodes.size());
  for (int tick = 0; tick < 300; ++tick) {
    one.evaluate(time_at(0.01 * tick));
    parallel.evaluate(time_at(0.01 * tick), counts);
    for (std::size_t i = 0; i < plan.nodes.size(); ++i) {
      ASSERT_EQ(one.node(i).fresh, several.node(i).fresh);
      ASSERT_EQ(one.node(i).output().estimate.value, several.node(i).output().estimate.value);
      ASSERT_EQ(one.node(i).output().acquired, several.node(i).output().acquired);
      ASSERT_TRUE(std::ranges::equal(one.node(i).output().estimate.lineage.sources(),
                                     several.node(i).output().estimate.lineage.sources()));
    }
  }
}

TEST(ParallelEvaluation, EveryModuleThatHadItsTurnHasATime) {
  const Plan plan = plan_of(layers(3, 2));
  System system(plan, 1);
  ParallelEvaluation parallel(system, 2);
  std::vector<std::uint64_t> counts(plan.nodes.size());
  parallel.evaluate(time_at(0), counts);
  for (std::size_t i = 0; i < counts.size(); ++i) EXPECT_GT(counts[i], 0u) << plan.nodes[i].name;
}

TEST(ParallelEvaluation, SelectorWaitsForWhatItsBranchesNeed) {
  const Plan plan = plan_of(R"(
ilss: shared
modules:
  s: {type: counter}
  up: {type: increment}
  down: {type: increment, step: -1}
  use: {type: switch}
network: {combine: [s, {serial: [s, {combine: [up, down]}, use]}]}
)");
  System system(plan, 1);
  ParallelEvaluation parallel(system, 2);
  std::vector<std::uint64_t> counts(plan.nodes.size());
  for (int tick = 0; tick < 100; ++tick) {
    parallel.evaluate(time_at(tick), counts);
    const double expected = tick + 1 + (tick % 2 == 0 ? 1 : -1);
    ASSERT_EQ(system.node(plan.find("use").value()).output().estimate.value[0], expected);
  }
}

}  // namespace
}  // namespace ilss
