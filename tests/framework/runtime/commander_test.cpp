// Commands in a running system: when they are given, in which order, and what comes of them.
#include "framework/runtime/commander.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "framework/runtime/runner.h"
#include "tests/framework/runtime/test_modules.h"

namespace ilss {
namespace {

using runtime_test::plan_of;

const std::string dial = R"(
modules: {dial: {type: dial}, counter: {type: counter}}
network: {combine: [dial, counter]}
commands: {set: dial.set, add: dial.add, text: dial.text, time: dial.time}
)";

/// Schedules a command by its name.
void schedule(Runner& runner, const std::string& name, CommandValue value, double time) {
  const std::vector<PlanCommand>& commands = runner.system().plan().commands;
  for (std::size_t i = 0; i < commands.size(); ++i)
    if (commands[i].name == name) return runner.schedule({i, std::move(value), time_at(time)});
  FAIL() << name;
}

/// A node's value after a tick.
double value_of(const Runner& runner, const std::string& node) {
  const System& system = runner.system();
  return system.node(system.plan().find(node).value()).output().estimate.value.at(0);
}

/// The first node's values over so many ticks of 0.1 s.
std::vector<double> values_over(Runner& runner, int ticks) {
  std::vector<double> values;
  for (int tick = 0; tick < ticks; ++tick) {
    runner.step(time_at(0.1 * tick));
    values.push_back(value_of(runner, "dial"));
  }
  return values;
}

TEST(Commander, GivesACommandBeforeTheFirstTickThatIsNotBeforeItsTime) {
  const Plan plan = plan_of(dial);
  Runner runner(plan);
  schedule(runner, "set", 7.0, 0.15);
  EXPECT_EQ(values_over(runner, 4), (std::vector<double>{0, 0, 7, 7}));
}

TEST(Commander, GivesACommandOfTimeZeroBeforeTheFirstTick) {
  const Plan plan = plan_of(dial);
  Runner runner(plan);
  schedule(runner, "set", 7.0, 0);
  EXPECT_EQ(values_over(runner, 1), (std::vector<double>{7}));
}

TEST(Commander, ATickAtTheVeryTimeIsNotMissedByRounding) {
  // 3 x 0.7 = 2.0999999999999996, a rounding before 2.1.
  const Plan plan = plan_of(dial);
  Runner runner(plan);
  schedule(runner, "set", 7.0, 2.1);
  for (int tick = 0; tick < 3; ++tick) runner.step(time_at(0.7 * tick));
  EXPECT_EQ(value_of(runner, "dial"), 0);
  ASSERT_LT(0.7 * 3, 2.1);
  runner.step(time_at(0.7 * 3));
  EXPECT_EQ(value_of(runner, "dial"), 7);
}

TEST(Commander, GivesCommandsByTimeThenInTheOrderGiven) {
  const Plan plan = plan_of(dial);
  Runner runner(plan);
  schedule(runner, "add", 1.0, 0.2);
  schedule(runner, "set", 10.0, 0.2);
  schedule(runner, "add", 2.0, 0.2);
  schedule(runner, "set", 50.0, 0.1);
  runner.step(time_at(0.3));
  EXPECT_EQ(value_of(runner, "dial"), 12);
  std::vector<CommandValue> values;
  for (const GivenCommand& given : runner.commander().given()) values.push_back(given.value);
  EXPECT_EQ(values, (std::vector<CommandValue>{50.0, 1.0, 10.0, 2.0}));
}

TEST(Commander, TellsTheModuleATimeBetweenTheLastTickAndTheNext) {
  const Plan plan = plan_of(dial);
  Runner runner(plan);
  schedule(runner, "time", 0.0, 0.25);
  for (const double time : {0.1, 0.2, 0.3}) runner.step(time_at(time));
  EXPECT_EQ(value_of(runner, "dial"), 0.25);
  runner.step(time_at(0.4));  // nothing waits any more
  schedule(runner, "time", 0.0, 0.05);
  runner.step(time_at(0.5));
  EXPECT_EQ(value_of(runner, "dial"), 0.4);
  schedule(runner, "time", 0.0, 0.6 * (1 + 1e-15));
  runner.step(time_at(0.6));
  EXPECT_EQ(value_of(runner, "dial"), 0.6);
}

TEST(Commander, TellsADrivenModuleTheTimeOfTheTickThatDrivesIt) {
  const Plan plan = plan_of(R"(
modules: {dial: {type: dial}, counter: {type: counter}}
network: {combine: [dial, counter]}
commands: {turn: {to: dial.time, from: counter}}
)");
  Runner runner(plan);
  for (const double time : {0.0, 0.1, 0.3, 0.7}) runner.step(time_at(time));
  EXPECT_EQ(value_of(runner, "dial"), 0.3);
}

TEST(Commander, TakesCommandsWhileTheSystemRuns) {
  const Plan plan = plan_of(dial);
  Runner runner(plan);
  schedule(runner, "set", 1.0, 0);
  runner.step(time_at(0.0));
  schedule(runner, "set", 3.0, 0.2);
  schedule(runner, "set", 2.0, 0.0);  // as soon as possible
  EXPECT_EQ(runner.commander().waiting(), 2U);
  runner.step(time_at(0.1));
  EXPECT_EQ(value_of(runner, "dial"), 2);
  runner.step(time_at(0.2));
  EXPECT_EQ(value_of(runner, "dial"), 3);
  EXPECT_EQ(runner.commander().waiting(), 0U);
}

TEST(Commander, TellsWhatCameOfTheCommandsBeforeTheLastTickOnly) {
  const Plan plan = plan_of(dial);
  Runner runner(plan);
  schedule(runner, "text", std::string("hello"), 0);
  runner.step(time_at(0));
  ASSERT_EQ(runner.commander().given().size(), 1U);
  const GivenCommand& given = runner.commander().given()[0];
  EXPECT_EQ(plan.commands[given.command].name, "text");
  EXPECT_EQ(given.value, CommandValue(std::string("hello")));
  EXPECT_TRUE(given.outcome.has_output());
  runner.step(time_at(0.1));
  EXPECT_TRUE(runner.commander().given().empty());
}

TEST(Commander, ARefusedCommandHasItsReasonAndTheRunGoesOn) {
  const Plan plan = plan_of(dial);
  Runner runner(plan);
  schedule(runner, "set", -1.0, 0);
  schedule(runner, "add", 5.0, 0);
  runner.step(time_at(0));
  ASSERT_EQ(runner.commander().given().size(), 2U);
  const Outcome<>& refused = runner.commander().given()[0].outcome;
  ASSERT_TRUE(refused.is_fault());
  EXPECT_EQ(refused.fault().kind, FaultKind::refused);
  EXPECT_EQ(refused.fault().message, "below zero");
  EXPECT_TRUE(runner.commander().given()[1].outcome.has_output());
  EXPECT_EQ(runner.commander().refused(), 1U);
  EXPECT_EQ(value_of(runner, "dial"), 5);
}

TEST(Commander, AModuleThatThrowsAtACommandIsAtFaultWithinAndTheRunGoesOn) {
  const Plan plan = plan_of(dial);
  Runner runner(plan);
  schedule(runner, "set", 1000.0, 0);  // throws
  schedule(runner, "add", false, 0);   // not as declared: the module throws, too
  runner.step(time_at(0));
  for (const GivenCommand& given : runner.commander().given()) {
    ASSERT_TRUE(given.outcome.is_fault());
    EXPECT_EQ(given.outcome.fault().kind, FaultKind::internal);
  }
  EXPECT_EQ(runner.commander().given()[0].outcome.fault().message, "the module threw: stuck");
  EXPECT_EQ(runner.commander().refused(), 2U);
  EXPECT_EQ(value_of(runner, "dial"), 0);
}

TEST(Commander, AModuleThatCouldNotBeMadeSaysWhyItFollowsNoCommand) {
  const Plan plan = plan_of(
      "modules: {dial: {type: dial, broken: true}}\nnetwork: dial\ncommands: {set: dial.set}\n");
  Runner runner(plan);
  schedule(runner, "set", 1.0, 0);
  runner.step(time_at(0));
  EXPECT_EQ(runner.commander().given()[0].outcome.fault().message,
            "cannot be created: no such dial");
}

/// The next number drives the dial: a loop that is closed from tick to tick.
const std::string loop = R"(
modules: {dial: {type: dial}, next: {type: increment}}
network: {serial: [dial, next]}
commands:
  set: {to: dial.set, from: next.value}
  add: dial.add
)";

TEST(Commander, ADrivenCommandClosesALoopAcrossTicks) {
  const Plan plan = plan_of(loop);
  Runner runner(plan);
  EXPECT_EQ(values_over(runner, 4), (std::vector<double>{0, 1, 2, 3}));
  ASSERT_EQ(runner.commander().given().size(), 1U);
  EXPECT_EQ(plan.commands[runner.commander().given()[0].command].name, "set");
  EXPECT_EQ(runner.commander().given()[0].value, CommandValue(3.0));
}

TEST(Commander, CommandsFromOutsideComeAfterDrivenOnes) {
  const Plan plan = plan_of(loop);
  Runner runner(plan);
  schedule(runner, "set", 100.0, 0.2);
  EXPECT_EQ(values_over(runner, 4), (std::vector<double>{0, 1, 100, 101}));
}

TEST(Commander, DrivesOnlyAfterTicksThatGaveSomethingFresh) {
  const Plan plan = plan_of(R"(
modules: {dial: {type: dial}, counter: {type: counter, period: 2, fault_at: 4}}
network: {combine: [dial, counter]}
commands: {add: {to: dial.add, from: counter}}
)");
  Runner runner(plan);
  // The counter gives 1 and 2 in ticks 0 and 2, a fault in tick 4, and 3 in tick 6.
  EXPECT_EQ(values_over(runner, 9), (std::vector<double>{0, 1, 1, 3, 3, 3, 3, 6, 6}));
}

TEST(Commander, ARefusedDrivenCommandIsTriedAgainWithTheNextValue) {
  const Plan plan = plan_of(R"(
modules: {dial: {type: dial}, next: {type: increment, step: -1}}
network: {serial: [dial, next]}
commands: {set: {to: dial.set, from: next.value}}
)");
  Runner runner(plan);
  EXPECT_EQ(values_over(runner, 4), (std::vector<double>{0, 0, 0, 0}));
  EXPECT_EQ(runner.commander().refused(), 3U);
}

TEST(Commander, TheSameCommandsAndSeedGiveTheSameRun) {
  const Plan plan = plan_of(R"(
modules: {dial: {type: dial}, noise: {type: counter, std: 1}, sum: {type: sum}}
network: {serial: [combine: [dial, noise], sum]}
commands: {set: {to: dial.set, from: sum}, add: dial.add}
)");
  const auto values = [&](std::uint64_t seed) {
    Runner runner(plan, seed);
    schedule(runner, "add", 0.25, 0.7);
    std::vector<double> result;
    for (int tick = 0; tick < 50; ++tick) {
      runner.step(time_at(0.1 * tick));
      result.push_back(value_of(runner, "sum"));
    }
    return result;
  };
  EXPECT_EQ(values(3), values(3));
  EXPECT_NE(values(3), values(4));
}

TEST(Commander, ADrivenCommandOfANestedSystemStaysDriven) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "ilss_Commander_Nested";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "inner.yaml") << loop;
  Diagnostics diagnostics;
  const Node graph = parse_document(
      "modules: {inner: {type: {ilss: inner.yaml}}}\n"
      "network: inner\ncommands: {more: inner.add}\n",
      "outer.yaml", diagnostics);
  const auto plan = build_plan(graph, folder, runtime_test::registry(), {}, diagnostics);
  std::filesystem::remove_all(folder);
  ASSERT_TRUE(plan && diagnostics.empty());
  Runner runner(*plan);
  schedule(runner, "more", 10.0, 0.1);
  schedule(runner, "inner.add", 100.0, 0.2);
  std::vector<double> values;
  for (int tick = 0; tick < 4; ++tick) {
    runner.step(time_at(0.1 * tick));
    values.push_back(value_of(runner, "inner.dial"));
  }
  EXPECT_EQ(values, (std::vector<double>{0, 11, 112, 113}));
}

}  // namespace
}  // namespace ilss
