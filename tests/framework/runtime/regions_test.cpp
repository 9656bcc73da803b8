// What is evaluated when: branches of selectors on demand, nothing behind outputs that are given.
#include "framework/graph/regions.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "framework/graph/system.h"
#include "tests/framework/runtime/test_modules.h"

namespace ilss {
namespace {

using runtime_test::plan_of;

std::vector<std::string> names(const Plan& plan, std::span<const std::size_t> nodes) {
  std::vector<std::string> result;
  for (const std::size_t node : nodes) result.push_back(plan.nodes[node].name);
  return result;
}
using Names = std::vector<std::string>;

double value(const System& system, std::string_view name) {
  return system.node(system.plan().find(name).value()).output().estimate.value.at(0);
}

/// Two branches with a counter of their own each, and one that both need and nobody else.
constexpr const char* two_branches = R"(
ilss: selected
modules:
  shared: {type: counter}
  a: {type: counter}
  b: {type: counter}
  left: {type: subtract}
  right: {type: subtract}
  use: {type: switch}
  next: {type: increment}
network:
  serial:
    - combine: [{serial: [{combine: [a, shared]}, left]}, {serial: [{combine: [b, shared]}, right]}]
    - use
    - next
)";

TEST(Regions, BranchesOfASelectorAreOnDemandAndTheRestIsNot) {
  const Plan plan = plan_of(two_branches);
  const Regions regions(plan, std::vector<bool>(plan.nodes.size(), false));
  const std::size_t use = plan.find("use").value();
  EXPECT_EQ(names(plan, regions.always()), (Names{"use", "next"}));
  EXPECT_EQ(names(plan, regions.on_demand(use)).size(), 5u);
  const Names left = names(plan, regions.branch(use, 0));
  EXPECT_EQ(std::set<std::string>(left.begin(), left.end()),
            (std::set<std::string>{"a", "shared", "left"}));
  EXPECT_EQ(left.back(), "left");
}

TEST(Regions, WhatIsNeededElsewhereIsEvaluatedAtEveryTick) {
  const Plan plan = plan_of(R"(
ilss: also_an_output
modules: {a: {type: counter}, b: {type: counter}, use: {type: switch}}
network: {combine: [{serial: [{combine: [a, b]}, use]}, a]}
)");
  const Regions regions(plan, std::vector<bool>(plan.nodes.size(), false));
  EXPECT_EQ(names(plan, regions.always()), (Names{"a", "use"}));
  EXPECT_TRUE(regions.branch(plan.find("use").value(), 0).empty());
}

TEST(Regions, SelectorInABranchKeepsItsOwnBranches) {
  const Plan plan = plan_of(R"(
ilss: nested
modules:
  a: {type: counter}
  b: {type: counter}
  c: {type: counter}
  inner: {type: switch}
  outer: {type: switch}
network: {serial: [{combine: [{serial: [{combine: [a, b]}, inner]}, c]}, outer]}
)");
  const Regions regions(plan, std::vector<bool>(plan.nodes.size(), false));
  EXPECT_EQ(names(plan, regions.always()), (Names{"outer"}));
  EXPECT_EQ(names(plan, regions.branch(plan.find("outer").value(), 0)), (Names{"inner"}));
  EXPECT_EQ(names(plan, regions.branch(plan.find("inner").value(), 1)), (Names{"b"}));
  System system(plan, 1);
  for (int tick = 0; tick < 4; ++tick) system.evaluate(time_at(tick));
  EXPECT_EQ(value(system, "a"), 2) << "outer looks at inner in ticks 0 and 2, both even";
  EXPECT_FALSE(system.node(plan.find("b").value()).has_value);
  EXPECT_EQ(value(system, "c"), 2);
}

TEST(Regions, WhatAnInnerSelectorHasIsOfThisTickOrPending) {
  const Plan plan = plan_of(R"(
ilss: nested
modules:
  a: {type: counter}
  b: {type: counter}
  c: {type: counter}
  inner: {type: switch, stuck_at: 0}
  outer: {type: switch}
network: {serial: [{combine: [{serial: [{combine: [a, b]}, inner]}, c]}, outer]}
)");
  System system(plan, 1);
  const NodeState& a = system.node(plan.find("a").value());
  system.evaluate(time_at(0));
  EXPECT_TRUE(a.outcome.has_output());
  system.evaluate(time_at(1));
  EXPECT_TRUE(a.outcome.is_pending()) << "outer has c evaluated in this tick";
  EXPECT_FALSE(a.fresh);
}

TEST(Selector, ThatIsNotMadeOrIsNoneIsAtFault) {
  const Plan plan = plan_of(two_branches);
  for (const bool throws : {true, false}) {
    System system(plan, 1, {.stand_ins = [&](std::size_t, const PlanNode& node) -> StandIn {
                    if (node.name != "use") return {};
                    if (throws) throw std::runtime_error("no");
                    return {plan.nodes[plan.find("a").value()].type->create(
                        plan.nodes[plan.find("a").value()].settings)};
                  }});
    system.evaluate(time_at(0));
    const Outcome<>& outcome = system.node(plan.find("use").value()).outcome;
    ASSERT_TRUE(outcome.is_fault());
    EXPECT_EQ(outcome.fault().message,
              throws ? "cannot be created: no"
                     : "what stands in for a selector must be one, or be given");
  }
}

TEST(Regions, WhatOnlyFeedsAGivenOutputIsLeftOut) {
  const Plan plan = plan_of(two_branches);
  std::vector<bool> given(plan.nodes.size(), false);
  given[plan.find("left").value()] = true;
  const Regions regions(plan, given);
  EXPECT_FALSE(regions.is_needed(plan.find("a").value()));
  EXPECT_TRUE(regions.is_needed(plan.find("shared").value()));
  EXPECT_EQ(names(plan, regions.branch(plan.find("use").value(), 0)), (Names{"left"}));
}

TEST(Selector, OnlyTheBranchThatIsAskedForIsEvaluated) {
  const Plan plan = plan_of(two_branches);
  System system(plan, 1);
  for (int tick = 0; tick < 5; ++tick) system.evaluate(time_at(tick));
  EXPECT_EQ(value(system, "a"), 3) << "ticks 0, 2, 4";
  EXPECT_EQ(value(system, "b"), 2) << "ticks 1, 3";
  EXPECT_EQ(value(system, "shared"), 5);
  EXPECT_EQ(value(system, "next"), 1 + 3 - 5);
}

TEST(Selector, ForwardsTheBranchesOutputWithoutACopy) {
  const Plan plan = plan_of(two_branches);
  System system(plan, 1);
  system.evaluate(time_at(0));
  EXPECT_EQ(&system.node(plan.find("use").value()).output(),
            &system.node(plan.find("left").value()).output());
  system.evaluate(time_at(1));
  EXPECT_EQ(&system.node(plan.find("use").value()).output(),
            &system.node(plan.find("right").value()).output());
}

TEST(Selector, WhatTwoBranchesShareIsEvaluatedOnceATick) {
  const Plan plan = plan_of(std::string(two_branches)
                                .replace(std::string(two_branches).find("{type: switch}"), 14,
                                         "{type: switch, cautious: true}"));
  System system(plan, 1);
  for (int tick = 0; tick < 4; ++tick) system.evaluate(time_at(tick));
  EXPECT_EQ(value(system, "shared"), 4);
  EXPECT_EQ(value(system, "a"), 4);
}

TEST(Selector, FaultOfTheSelectedBranchIsItsOwnWithTheBranchsOrigin) {
  const Plan plan = plan_of(R"(
ilss: faulty
modules:
  a: {type: counter, fault_at: 1}
  b: {type: counter}
  up: {type: increment}
  use: {type: switch, stuck_at: 0}
network: {serial: [{combine: [{serial: [a, up]}, b]}, use]}
)");
  System system(plan, 1);
  system.evaluate(time_at(0));
  system.evaluate(time_at(1));
  const NodeState& use = system.node(plan.find("use").value());
  ASSERT_TRUE(use.outcome.is_fault());
  EXPECT_EQ(use.outcome.fault().kind, FaultKind::no_detection);
  EXPECT_EQ(use.origin, plan.find("a"));
  system.evaluate(time_at(2));
  EXPECT_TRUE(use.outcome.has_output());
}

TEST(Selector, BranchThatIsNotThereIsAFault) {
  const Plan plan = plan_of(R"(
ilss: beyond
modules: {a: {type: counter}, b: {type: counter}, use: {type: switch, stuck_at: 7}}
network: {serial: [{combine: [a, b]}, use]}
)");
  System system(plan, 1);
  system.evaluate(time_at(0));
  const Outcome<>& outcome = system.node(plan.find("use").value()).outcome;
  ASSERT_TRUE(outcome.is_fault());
  EXPECT_EQ(outcome.fault().message, "it selected branch 8 of 2");
}

}  // namespace
}  // namespace ilss
