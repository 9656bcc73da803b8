// No memory is allocated from tick to tick once buffers have grown.
#include <gtest/gtest.h>

#include "framework/estimate/units.h"
#include "framework/runtime/run.h"
#include "tests/allocation_count.h"
#include "tests/framework/runtime/test_modules.h"

namespace ilss {
namespace {

using runtime_test::plan_of;

/// Allocations in 1,000 ticks after the first 100.
std::size_t allocations_of(const std::string& text, Folding folding) {
  const Plan plan = plan_of(text);
  ilss::Run run(plan, {.period = duration_of(0.01), .folding = folding});
  while (run.ticks() < 100) run.step();
  const std::size_t before = allocation_count;
  while (run.ticks() < 1100) run.step();
  const std::size_t counted = allocation_count - before;
  for (std::size_t i = 0; i < plan.nodes.size(); ++i)
    EXPECT_GT(run.runner().outcomes(i).outputs, 500U) << plan.nodes[i].name;
  return counted;
}

const std::string diamond = R"(
ilss: diamond
constants:
  step: {value: 1, std: 0.1}
modules:
  counter: {type: counter, std: 0.3}
  left: {type: increment, step: $step}
  right: {type: increment, step: {value: 2, std: 0.2}}
  difference: {type: subtract}
  last: {type: increment, step: $step}
network:
  serial: [counter, combine: [left, right], difference, last]
)";

/// Eight sensors of different rates into one sum, in which everything can fold; two of them have
/// more sources than components, which folds by owner.
const std::string eight_sources = R"(
ilss: eight
modules:
  a: {type: counter, std: 1, parts: 3}
  b: {type: counter, std: 2}
  c: {type: counter, std: 3, period: 2}
  d: {type: counter, std: 4, parts: 2}
  e: {type: counter, std: 5}
  f: {type: counter, std: 6}
  g: {type: counter, std: 7}
  h: {type: counter, std: 8}
  sum: {type: sum}
  next: {type: increment, step: {value: 1, std: 0.5}}
network:
  serial: [combine: [a, b, c, d, e, f, g, h], sum, next]
)";

TEST(Allocation, IsCountedWithinTheLibraryToo) {
  SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED();
  const std::size_t before = allocation_count;
  EXPECT_EQ(dimension_name("kg.m2.s-3"), "a quantity in kg.m2.s-3");
  EXPECT_GT(allocation_count, before);
}

TEST(Allocation, NoneInTheSteadyStateOfADiamondWithUncertainParameters) {
  SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED();
  for (const Folding folding : {Folding::none, Folding::per_owner, Folding::all})
    EXPECT_EQ(allocations_of(diamond, folding), 0U) << static_cast<int>(folding);
}

TEST(Allocation, NoneInTheSteadyStateOfEightSourcesFoldedOrNot) {
  SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED();
  for (const Folding folding : {Folding::none, Folding::per_owner, Folding::all})
    EXPECT_EQ(allocations_of(eight_sources, folding), 0U) << static_cast<int>(folding);
}

TEST(Allocation, NoneInTheSteadyStateOfALoopThatACommandCloses) {
  SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED();
  EXPECT_EQ(allocations_of("modules: {dial: {type: dial}, next: {type: increment, step: 0.001}}\n"
                           "network: {serial: [dial, next]}\n"
                           "commands: {a_name_that_is_too_long_to_be_held_within_a_string: "
                           "{to: dial.set, from: next.value}}\n",
                           Folding::per_owner),
            0U);
}

TEST(Allocation, FoldingEightSourcesTogetherLeavesOneRandomColumnATickOfTheSameVariance) {
  const Plan plan = plan_of(eight_sources);
  System folded(plan, 1, Folding::all);
  System whole(plan, 1, Folding::none);
  for (int tick = 0; tick < 4; ++tick) {
    folded.evaluate(time_at(tick));
    whole.evaluate(time_at(tick));
    const auto sum = plan.find("sum").value();
    const Lineage& lineage = folded.node(sum).output().estimate.lineage;
    // One column of this tick, and one that a held reading brings along from the tick before.
    EXPECT_LE(lineage.size(), 2U);
    EXPECT_EQ(whole.node(sum).output().estimate.lineage.size(), 11U);
    EXPECT_NEAR(lineage.variance(0), whole.node(sum).output().estimate.lineage.variance(0), 1e-9);
  }
}

}  // namespace
}  // namespace ilss
