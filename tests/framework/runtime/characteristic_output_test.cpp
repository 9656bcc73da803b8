// What observers see of a module in a tick.
#include "framework/runtime/characteristic_output.h"

#include <gtest/gtest.h>

#include "framework/runtime/runner.h"
#include "tests/framework/runtime/test_modules.h"

namespace ilss {
namespace {

using runtime_test::plan_of;

const std::string slow_and_fast = R"(
modules:
  slow: {type: counter, period: 3, delay: 20 ms, std: 0.1}
  fast: {type: counter, fault_at: 2}
  next: {type: increment}
network: {combine: [slow, {serial: [fast, next]}]}
)";

/// A runner after so many ticks of 0.1 s.
class Ran {
 public:
  Ran(const Plan& plan, int ticks) : runner_(plan) {
    for (int tick = 0; tick < ticks; ++tick) runner_.step(time_at(0.1 * tick));
  }
  TickView tick(std::span<const VerdictReport> verdicts = {}) const {
    return {runner_.system(), {.counts = runner_.counts(), .verdicts = verdicts}};
  }

 private:
  Runner runner_;
};

TEST(CharacteristicOutput, SaysWhichModuleGaveWhatAndWhen) {
  const Plan plan = plan_of(slow_and_fast);
  const Ran ran(plan, 1);
  const CharacteristicOutput slow = ran.tick().output(0);
  EXPECT_EQ(slow.tick, 0);
  EXPECT_EQ(slow.time, time_at(0));
  EXPECT_EQ(&slow.module, &plan.nodes[slow.node]);
  EXPECT_EQ(slow.module.name, "slow");
  EXPECT_TRUE(slow.outcome.has_output());
  EXPECT_EQ(slow.origin, nullptr);
  ASSERT_NE(slow.output, nullptr);
  EXPECT_EQ(slow.output, slow.latest);
  EXPECT_EQ(slow.acquired(), Acquisition::at(time_at(-0.02)));
  EXPECT_EQ(slow.age(), duration_of(0.02));
}

TEST(CharacteristicOutput, OfAPendingModuleHoldsTheLatestWithItsAge) {
  const Plan plan = plan_of(slow_and_fast);
  const Ran ran(plan, 2);
  const CharacteristicOutput slow = ran.tick().output(0);
  EXPECT_TRUE(slow.outcome.is_pending());
  EXPECT_EQ(slow.output, nullptr);
  ASSERT_NE(slow.latest, nullptr);
  EXPECT_EQ(slow.age(), duration_of(0.12));
}

TEST(CharacteristicOutput, OfAFaultNamesTheModuleItComesFrom) {
  const Plan plan = plan_of(slow_and_fast);
  const Ran ran(plan, 3);
  const CharacteristicOutput next = ran.tick().output(1);
  EXPECT_TRUE(next.outcome.is_fault());
  ASSERT_NE(next.origin, nullptr);
  EXPECT_EQ(next.origin->name, "fast");
  EXPECT_EQ(next.latest, nullptr);
  EXPECT_FALSE(next.age());
  EXPECT_FALSE(next.acquired());
}

TEST(CharacteristicOutput, HasAVerdictOnlyWhereItsOutputWasJudged) {
  const Plan plan = plan_of(slow_and_fast);
  const Ran ran(plan, 2);
  const std::vector<VerdictReport> verdicts(2);
  EXPECT_EQ(ran.tick().output(1).verdict, nullptr);
  EXPECT_EQ(ran.tick(verdicts).output(1).verdict, &verdicts[1]);
  EXPECT_EQ(ran.tick(verdicts)[plan.find("next").value()].verdict, &verdicts[1]);
  EXPECT_EQ(ran.tick(verdicts)[plan.find("fast").value()].verdict, nullptr);
  EXPECT_EQ(ran.tick(verdicts).output(0).verdict, nullptr) << "it is pending";
}

TEST(TickView, AVerdictOnSomeOutputsIsOnThese) {
  const Plan plan = plan_of(
      "modules: {a: {type: counter}, b: {type: counter}, c: {type: counter}}\n"
      "network: {combine: [a, b, c]}\n");
  System system(plan, 1);
  system.evaluate(time_at(0));
  const std::vector<VerdictReport> verdicts(1);
  const TickView tick(system, {.verdicts = verdicts, .first_judged = 1});
  EXPECT_EQ(tick.output(0).verdict, nullptr);
  EXPECT_EQ(tick.output(1).verdict, &verdicts[0]);
  EXPECT_EQ(tick.output(2).verdict, nullptr);
  EXPECT_EQ(tick[1].verdict, &verdicts[0]);
}

TEST(CharacteristicOutput, HoldsTheComputeTimeThatTheRunnerMeasured) {
  const Plan plan = plan_of(slow_and_fast);
  Runner runner(plan);
  runner.step(time_at(0));
  const TickView tick(runner.system(), {.counts = runner.counts()});
  for (std::size_t i = 0; i < tick.size(); ++i)
    EXPECT_EQ(static_cast<std::uint64_t>(tick[i].compute_time.count()), runner.compute_ns(i));
}

TEST(TickView, TheSystemsOutcomeIsAFaultBeforePendingBeforeAnOutput) {
  const Plan plan = plan_of(slow_and_fast);
  EXPECT_TRUE(Ran(plan, 1).tick().deciding_output().outcome.has_output());
  EXPECT_EQ(Ran(plan, 2).tick().deciding_output().module.name, "slow");
  EXPECT_EQ(Ran(plan, 3).tick().deciding_output().module.name, "next");
}

}  // namespace
}  // namespace ilss
