// Modules that open and close, and what stands in for them.
#include <gtest/gtest.h>

#include <limits>

#include "framework/graph/given_outputs.h"
#include "framework/graph/system.h"
#include "tests/framework/runtime/test_modules.h"

namespace ilss {
namespace {

using runtime_test::Archive;
using runtime_test::plan_of;

double value(const System& system, std::string_view name) {
  return system.node(system.plan().find(name).value()).output().estimate.value.at(0);
}

TEST(Open, HappensOnceBeforeTheFirstTickAndEndsWithTheSystem) {
  const Plan plan = plan_of("ilss: one\nmodules: {a: {type: archive}}\nnetwork: a\n");
  {
    System system(plan, 1);
    EXPECT_EQ(Archive::open_now, 0);
    EXPECT_TRUE(system.open().empty());
    EXPECT_TRUE(system.open().empty());
    EXPECT_EQ(Archive::open_now, 1);
    system.evaluate(time_at(0));
    EXPECT_EQ(value(system, "a"), 1);
  }
  EXPECT_EQ(Archive::open_now, 0);
}

TEST(Open, FirstTickOpensWhatNobodyHasOpened) {
  const Plan plan = plan_of("ilss: one\nmodules: {a: {type: archive}}\nnetwork: a\n");
  System system(plan, 1);
  system.evaluate(time_at(0));
  EXPECT_EQ(value(system, "a"), 1);
}

TEST(Open, WhatCannotBeOpenedIsToldAndIsAFaultAtEveryTick) {
  const Plan plan = plan_of(R"(
ilss: two
modules: {a: {type: archive, lost: true}, b: {type: archive, throws: true}}
network: {combine: [a, b]}
)");
  System system(plan, 1);
  const std::vector<OpenFault> faults = system.open();
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_EQ(faults[0].fault.kind, FaultKind::device_lost);
  EXPECT_EQ(faults[1].fault.kind, FaultKind::internal);
  EXPECT_EQ(faults[1].fault.message, "the module threw: the shelf is empty");
  for (int tick = 0; tick < 2; ++tick) {
    system.evaluate(time_at(tick));
    for (const OpenFault& fault : faults) {
      ASSERT_TRUE(system.node(fault.node).outcome.is_fault());
      EXPECT_EQ(system.node(fault.node).outcome.fault().message, fault.fault.message);
    }
  }
}

TEST(Open, PredictionOpensNothingThatIsGiven) {
  const Plan plan = plan_of(R"(
ilss: given
modules: {a: {type: archive, lost: true}, next: {type: increment}}
network: {serial: [a, next]}
)");
  OperatingPoint point{Output{Estimate(descriptor<runtime_test::Number>())}, true};
  point.value.estimate.value = {41};
  System system(plan, 1, {.stand_ins = given_outputs({{plan.find("a").value(), point}})});
  EXPECT_TRUE(system.open().empty());
  system.expect();
  EXPECT_EQ(value(system, "next"), 42);
}

TEST(StandIn, GivenOutputStandsAtEveryTickAndNothingFeedsIt) {
  const Plan plan = plan_of(R"(
ilss: given
modules: {a: {type: counter}, up: {type: increment}, next: {type: increment}}
network: {serial: [a, up, next]}
)");
  OperatingPoint point{Output{Estimate(descriptor<runtime_test::Number>())}, true};
  point.value.estimate.value = {7};
  System system(plan, 1, {.stand_ins = given_outputs({{plan.find("up").value(), point}})});
  for (int tick = 0; tick < 3; ++tick) system.evaluate(time_at(tick));
  EXPECT_EQ(value(system, "next"), 8);
  EXPECT_FALSE(system.node(plan.find("a").value()).has_value) << "it only feeds what is given";
}

/// Doubles what the module in it gives.
class Doubled final : public Module {
 public:
  explicit Doubled(std::unique_ptr<Module> inner) : inner_(std::move(inner)) {}
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    Outcome<> outcome = inner_->evaluate(evaluation, output);
    if (outcome) output.estimate.value[0] *= 2;
    return outcome;
  }

 private:
  std::unique_ptr<Module> inner_;
};

TEST(StandIn, WrapperIsFedLikeTheModuleInIt) {
  const Plan plan = plan_of(R"(
ilss: wrapped
modules: {a: {type: counter}, up: {type: increment}}
network: {serial: [a, up]}
)");
  const StandIns doubled = [](std::size_t, const PlanNode& node) -> StandIn {
    if (node.name != "up") return {};
    return {std::make_unique<Doubled>(node.type->create(node.settings))};
  };
  System system(plan, 1, {.stand_ins = doubled});
  system.evaluate(time_at(0));
  EXPECT_EQ(value(system, "up"), 4);
}

/// Gives a number that is none.
class Spoiled final : public Module {
 public:
  Outcome<> evaluate(const Evaluation&, Output& output) override {
    output.estimate.value[0] = std::numeric_limits<double>::quiet_NaN();
    return {};
  }
};

TEST(StandIn, IsCheckedAlsoWhereTheModuleInItNeedNotBe) {
  const Plan plan = plan_of(R"(
ilss: spoiled
modules: {a: {type: counter}, up: {type: increment}}
network: {serial: [a, up]}
)");
  ASSERT_TRUE(plan.nodes[plan.find("up").value()].type->checked);
  System system(plan, 1, {.stand_ins = [](std::size_t, const PlanNode& node) -> StandIn {
                  if (node.name != "up") return {};
                  return {std::make_unique<Spoiled>()};
                }});
  system.evaluate(time_at(0));
  const Outcome<>& outcome = system.node(plan.find("up").value()).outcome;
  ASSERT_TRUE(outcome.is_fault());
  EXPECT_EQ(outcome.fault().kind, FaultKind::not_finite);
}

TEST(FollowData, TicksComeAtTheSourcesTimesAndWhatIsNotDueIsPending) {
  const Plan plan = plan_of(R"(
ilss: two_logs
modules:
  fast: {type: archive, from: 10 s, step: 1 s, count: 4}
  slow: {type: archive, from: 10.5 s, step: 2 s, count: 2}
network: {combine: [fast, slow]}
)");
  System system(plan, 1, {.follow_data = true});
  std::vector<double> times;
  std::vector<std::string> which;
  while (const auto next = system.next_data_time()) {
    system.evaluate(*next);
    times.push_back(seconds(*next));
    which.emplace_back(std::string(system.node(0).fresh ? "fast" : "") +
                       (system.node(1).fresh ? "slow" : ""));
    for (std::size_t node = 0; node < 2; ++node) {
      if (!system.node(node).fresh) continue;
      EXPECT_EQ(system.node(node).output().acquired, Acquisition::at(*next));
    }
  }
  EXPECT_EQ(times, (std::vector<double>{10, 10.5, 11, 12, 12.5, 13}));
  EXPECT_EQ(which, (std::vector<std::string>{"fast", "slow", "fast", "fast", "slow", "fast"}));
}

}  // namespace
}  // namespace ilss
