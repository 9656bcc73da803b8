// One tick after another: what a System makes of rates, ages, faults and exceptions.
#include "framework/graph/system.h"

#include <gtest/gtest.h>

#include "tests/framework/runtime/test_modules.h"

namespace ilss {
namespace {

using runtime_test::plan_of;

const NodeState& node(const System& system, std::string_view name) {
  return system.node(system.plan().find(name).value());
}
double value(const System& system, std::string_view name) {
  return node(system, name).output().estimate.value.at(0);
}

TEST(System, InstanceThatFeedsTwoBranchesIsEvaluatedOnceATick) {
  const Plan plan = plan_of(R"(
ilss: diamond
modules:
  counter: {type: counter, std: 1}
  up: {type: increment, step: 2}
  down: {type: increment, step: -2}
  difference: {type: subtract}
network:
  serial:
    - counter
    - combine: [up, down]
    - difference
)");
  System system(plan, 1);
  for (int tick = 0; tick < 3; ++tick) system.evaluate(time_at(tick));
  EXPECT_LT(value(system, "counter"), 4);
  EXPECT_GE(value(system, "counter"), 3);
  EXPECT_EQ(value(system, "difference"), 4);
  EXPECT_EQ(node(system, "difference").output().estimate.lineage.variance(0), 0);
}

TEST(System, ModuleWhoseInputsAreNotDueIsPendingAndHoldsItsOutput) {
  const Plan plan = plan_of(R"(
ilss: slow
modules:
  counter: {type: counter, period: 3}
  next: {type: increment}
network: {serial: [counter, next]}
)");
  System system(plan, 1);
  system.evaluate(time_at(0));
  EXPECT_TRUE(node(system, "next").outcome.has_output());
  system.evaluate(time_at(1));
  EXPECT_TRUE(node(system, "next").outcome.is_pending());
  EXPECT_TRUE(node(system, "next").has_value);
  EXPECT_FALSE(node(system, "next").fresh);
  EXPECT_EQ(value(system, "next"), 2);
  EXPECT_EQ(node(system, "next").output().acquired.oldest, time_at(0));
  system.evaluate(time_at(2));
  system.evaluate(time_at(3));
  EXPECT_EQ(value(system, "next"), 3);
  EXPECT_EQ(node(system, "next").output().acquired.oldest, time_at(3));
}

TEST(System, CombineOfTwoRatesTakesTheSlowOnesLatestOutputWithItsSourceAndAge) {
  const Plan plan = plan_of(R"(
ilss: rates
modules:
  fast: {type: counter, std: 3}
  slow: {type: counter, period: 2, std: 4}
  difference: {type: subtract}
network: {serial: [combine: [fast, slow], difference]}
)");
  System system(plan, 1);
  for (int tick = 0; tick < 4; ++tick) system.evaluate(time_at(tick));
  const Output& output = node(system, "difference").output();
  EXPECT_TRUE(node(system, "difference").fresh);
  EXPECT_EQ(output.estimate.value[0], value(system, "fast") - value(system, "slow"));
  EXPECT_EQ(output.acquired.oldest, time_at(2));
  EXPECT_DOUBLE_EQ(output.estimate.lineage.variance(0), 25);
  std::vector<std::int64_t> ticks;
  for (const Source& source : output.estimate.lineage.sources()) ticks.push_back(source.tick);
  EXPECT_EQ(ticks, (std::vector<std::int64_t>{3, 2}));
}

TEST(System, ModuleIsPendingUntilEveryInputHasHadAValue) {
  const Plan plan = plan_of(R"(
ilss: late
modules:
  fast: {type: counter}
  late: {type: counter, first: 2}
  difference: {type: subtract}
network: {serial: [combine: [fast, late], difference]}
)");
  System system(plan, 1);
  system.evaluate(time_at(0));
  system.evaluate(time_at(1));
  EXPECT_TRUE(node(system, "difference").outcome.is_pending());
  EXPECT_FALSE(node(system, "difference").has_value);
  system.evaluate(time_at(2));
  EXPECT_EQ(value(system, "difference"), 2);
}

TEST(System, InputOlderThanMaxAgeIsTheFaultStaleUntilAFreshOneComes) {
  const Plan plan = plan_of(R"(
ilss: aging
modules:
  fast: {type: counter}
  slow: {type: counter, period: 4}
  difference: {type: subtract}
network:
  serial:
    - combine: {of: [fast, slow], max_age: 200 ms}
    - difference
)");
  System system(plan, 1);
  std::vector<bool> stale;
  for (int tick = 0; tick < 5; ++tick) {
    system.evaluate(time_at(0.1 * tick));
    const NodeState& state = node(system, "difference");
    stale.push_back(state.outcome.is_fault());
    if (!state.outcome.is_fault()) continue;
    EXPECT_EQ(state.outcome.fault().kind, FaultKind::stale);
    EXPECT_EQ(state.outcome.fault().message, "'slow' is 0.3 s old; at most 0.2 s are allowed");
    EXPECT_EQ(state.origin, system.plan().find("difference"));
    EXPECT_FALSE(state.has_value);
  }
  EXPECT_EQ(stale, (std::vector<bool>{false, false, false, true, false}));
}

TEST(System, FreshDataThatIsOldAlreadyIsStaleToo) {
  const Plan plan = plan_of(R"(
ilss: delayed
modules:
  fast: {type: counter}
  delayed: {type: counter, delay: 1 s}
  difference: {type: subtract}
network: {serial: [combine: {of: [fast, delayed], max_age: 0.5 s}, difference]}
)");
  System system(plan, 1);
  system.evaluate(time_at(10));
  ASSERT_TRUE(node(system, "difference").outcome.is_fault());
  EXPECT_EQ(node(system, "difference").outcome.fault().kind, FaultKind::stale);
}

TEST(System, FaultTravelsDownWithItsOriginAndEndsWithIt) {
  const Plan plan = plan_of(R"(
ilss: faulty
modules:
  counter: {type: counter, fault_at: 1}
  first: {type: increment}
  second: {type: increment}
network: {serial: [counter, first, second]}
)");
  System system(plan, 1);
  system.evaluate(time_at(0));
  system.evaluate(time_at(1));
  for (const char* name : {"counter", "first", "second"}) {
    const NodeState& state = node(system, name);
    ASSERT_TRUE(state.outcome.is_fault()) << name;
    EXPECT_EQ(state.outcome.fault().kind, FaultKind::no_detection);
    EXPECT_EQ(state.outcome.fault().message, "nothing");
    EXPECT_EQ(state.origin, system.plan().find("counter"));
    EXPECT_FALSE(state.has_value);
  }
  system.evaluate(time_at(2));
  EXPECT_TRUE(node(system, "second").outcome.has_output());
  EXPECT_FALSE(node(system, "second").origin.has_value());
  EXPECT_EQ(value(system, "second"), 4);
}

TEST(System, ValueHeldBeforeAFaultIsNotUsedAfterIt) {
  const Plan plan = plan_of(R"(
ilss: held
modules:
  slow: {type: counter, period: 3, fault_at: 1}
  fast: {type: counter}
  difference: {type: subtract}
network: {serial: [combine: [fast, slow], difference]}
)");
  System system(plan, 1);
  system.evaluate(time_at(0));
  EXPECT_TRUE(node(system, "difference").outcome.has_output());
  system.evaluate(time_at(1));
  EXPECT_TRUE(node(system, "difference").outcome.is_fault());
  system.evaluate(time_at(2));  // `slow` is pending again, its value of tick 0 gone with the fault
  EXPECT_TRUE(node(system, "difference").outcome.is_pending());
  system.evaluate(time_at(3));
  EXPECT_TRUE(node(system, "difference").outcome.has_output());
}

TEST(System, WhatAModuleThrowsBecomesTheFaultInternal) {
  const Plan plan = plan_of(R"(
ilss: throwing
modules:
  thrower: {type: thrower}
  odd: {type: thrower, odd: true}
  early: {type: thrower, early: true}
network: {combine: [thrower, odd, early]}
)");
  System system(plan, 1);
  for (int tick = 0; tick < 2; ++tick) {
    system.evaluate(time_at(tick));
    for (const auto& [name, message] : {std::pair{"thrower", "the module threw: out of luck"},
                                        {"odd", "the module threw"},
                                        {"early", "cannot be created: no such device"}}) {
      const NodeState& state = node(system, name);
      ASSERT_TRUE(state.outcome.is_fault()) << name;
      EXPECT_EQ(state.outcome.fault().kind, FaultKind::internal);
      EXPECT_EQ(state.outcome.fault().message, message);
      EXPECT_EQ(state.origin, system.plan().find(name));
    }
  }
}

TEST(System, SeedsDependOnTheModulesNameAndTheTickNotOnTheOrderInTheFile) {
  const std::string head = "ilss: order\nmodules:\n";
  const std::string tail = "network: {combine: [a, b]}\n";
  const std::string a = "  a: {type: counter, std: 1}\n";
  const std::string b = "  b: {type: counter, std: 1}\n";
  const Plan first = plan_of(head + a + b + tail);
  const Plan second = plan_of(head + b + a + tail);
  System one(first, 7);
  System other(second, 7);
  System reseeded(first, 8);
  for (int tick = 0; tick < 10; ++tick) {
    one.evaluate(time_at(tick));
    other.evaluate(time_at(tick));
    reseeded.evaluate(time_at(tick));
    EXPECT_EQ(value(one, "a"), value(other, "a"));
    EXPECT_EQ(value(one, "b"), value(other, "b"));
    EXPECT_NE(value(one, "a"), value(one, "b"));
    EXPECT_NE(value(one, "a"), value(reseeded, "a"));
  }
}

}  // namespace
}  // namespace ilss
