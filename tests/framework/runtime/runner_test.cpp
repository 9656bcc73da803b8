// The runner's instruments, and that they change nothing.
#include "framework/runtime/runner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/framework/runtime/test_modules.h"

namespace ilss {
namespace {

using runtime_test::plan_of;

const std::string mixed = R"(
ilss: mixed
modules:
  fast: {type: counter, std: 0.1, fault_at: 5}
  slow: {type: counter, period: 2, std: 0.2}
  next: {type: increment}
  difference: {type: subtract}
network:
  serial:
    - combine: [{serial: [fast, next]}, slow]
    - difference
)";

TEST(Runner, CountsEachOutcomeByModule) {
  const Plan plan = plan_of(mixed);
  Runner runner(plan, 1);
  for (int tick = 0; tick < 10; ++tick) runner.step(time_at(tick));
  const auto outcomes = [&](const char* name) { return runner.outcomes(plan.find(name).value()); };
  EXPECT_EQ(outcomes("fast").outputs, 9U);
  EXPECT_EQ(outcomes("fast").faults(FaultKind::no_detection), 1U);
  EXPECT_EQ(outcomes("slow").outputs, 5U);
  EXPECT_EQ(outcomes("slow").pending, 5U);
  EXPECT_EQ(outcomes("difference").outputs, 9U);
  EXPECT_EQ(outcomes("difference").faults(), 1U);
}

TEST(Runner, LatencyHoldsTheTicksInWhichTheModuleWorked) {
  const Plan plan = plan_of(mixed);
  Runner runner(plan, 1);
  for (int tick = 0; tick < 10; ++tick) runner.step(time_at(tick));
  const auto count = [&](const char* name) {
    return runner.latency(plan.find(name).value()).count();
  };
  EXPECT_EQ(count("fast"), 10U);  // its own fault is work
  EXPECT_EQ(count("slow"), 5U);
  EXPECT_EQ(count("next"), 9U);  // the fault from above is not
  EXPECT_EQ(runner.end_to_end().count(), 10U);
}

TEST(Runner, ModuleTimesAddUpToTheTickWithinRounding) {
  const Plan plan = plan_of(mixed);
  Runner runner(plan, 1);
  for (int tick = 0; tick < 100; ++tick) {
    runner.step(time_at(tick));
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < plan.nodes.size(); ++i) sum += runner.compute_ns(i);
    EXPECT_LE(sum, runner.compute_ns());
    EXPECT_GE(sum + plan.nodes.size(), runner.compute_ns());  // each loses less than 1 ns
  }
}

TEST(Runner, SameSeedGivesTheSameOutputsBitForBitMeasuredOrNot) {
  const Plan plan = plan_of(mixed);
  Runner measured(plan, 42);
  Runner again(plan, 42);
  System bare(plan, 42);
  for (int tick = 0; tick < 200; ++tick) {
    measured.step(time_at(0.1 * tick));
    again.step(time_at(0.1 * tick));
    bare.evaluate(time_at(0.1 * tick));
    for (std::size_t i = 0; i < plan.nodes.size(); ++i) {
      const Output& one = measured.system().node(i).output();
      for (const System* other :
           {static_cast<const System*>(&bare), static_cast<const System*>(&again.system())}) {
        const Output& two = other->node(i).output();
        ASSERT_EQ(one.estimate.value, two.estimate.value);
        ASSERT_EQ(one.acquired, two.acquired);
        ASSERT_TRUE(
            std::ranges::equal(one.estimate.lineage.sources(), two.estimate.lineage.sources()));
        ASSERT_EQ(one.estimate.lineage.factor(), two.estimate.lineage.factor());
      }
    }
  }
}

TEST(Runner, ProfileHasTheMedianAndTheWorstOfEachModuleThatWorked) {
  const Plan plan = plan_of(R"(
ilss: profiled
modules:
  never: {type: counter, fault_at: 0}
  next: {type: increment}
network: {serial: [never, next]}
)");
  Runner runner(plan);
  runner.step(time_at(0));
  const Profile profile = runner.profile();
  EXPECT_EQ(profile.plan, "profiled");
  ASSERT_EQ(profile.modules.size(), 1U);
  EXPECT_EQ(profile.modules[0].module, "never");
  const LatencySummary summary = runner.latency(0).summary();
  EXPECT_EQ(std::llround(profile.modules[0].time.typical * 1e9),
            static_cast<long long>(summary.p50));
  EXPECT_EQ(std::llround(profile.modules[0].time.worst * 1e9),
            static_cast<long long>(summary.p999));
}

}  // namespace
}  // namespace ilss
