// A judge over many ticks: what it costs, and that nothing it keeps changes what it says.
#include <gtest/gtest.h>

#include "framework/semantics/perturbation.h"
#include "framework/semantics/verdict.h"
#include "tests/allocation_count.h"
#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

using test::Scalar;

/// x + x³, which counts its instances and, beside those with derivatives, its evaluations.
struct Tracked {
  static inline std::size_t created = 0;
  static inline std::size_t evaluated = 0;

  static constexpr std::string_view name = "tracked", description = "x + x³";
  static constexpr std::array<std::string_view, 1> inputs = {"x"};
  Tracked() { ++created; }
  template <typename T>
  Outcome<Scalar<T>> operator()(const Scalar<T>& x) const {
    if constexpr (std::is_same_v<T, double>) ++evaluated;
    return Scalar<T>{x.x + x.x * x.x * x.x};
  }
};

/// Passes on one input after the other.
class Alternate final : public Selector {
 public:
  static constexpr std::string_view name = "alternate";
  static constexpr std::string_view description = "One input after the other";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  struct Options {
    void declare(OptionVisitor&) {}
  };
  static Interface interface() {
    return {{{"alternates", &descriptor<Scalar>(), {}, true}}, &descriptor<Scalar>(), {}, 0};
  }
  explicit Alternate(const Options&) {}
  Outcome<std::size_t> select(const Evaluation& evaluation, Branches& branches) override {
    const std::size_t wanted = static_cast<std::size_t>(evaluation.tick) % branches.size();
    branches.evaluate(wanted);
    return wanted;
  }
};

const Registry& registry_with_tracked() {
  static const Registry result = [] {
    Registry modules;
    for (const std::string& name : test::registry().names())
      modules.add(*test::registry().find(name));
    modules.add<Tracked>();
    modules.add<Alternate>();
    return modules;
  }();
  return result;
}

Plan plan_with_tracked(const std::string& text) {
  Diagnostics diagnostics;
  const Node graph = parse_document(text, "graph.yaml", diagnostics);
  auto plan = build_plan(graph, ".", registry_with_tracked(), {}, diagnostics);
  EXPECT_EQ(test::messages(diagnostics), "");
  if (!plan) throw std::runtime_error("no plan");
  return std::move(*plan);
}

/// `width` branches side by side: a reading, and a function of it.
Plan wide_plan(std::size_t width, const std::string& reading) {
  std::string modules = "modules: {";
  std::string network = "}\nnetwork: {combine: [";
  for (std::size_t i = 0; i < width; ++i) {
    const std::string n = std::to_string(i);
    modules += (i > 0 ? ", x" : "x") + n + ": {type: reading, " + reading + "}, f" + n +
               ": {type: tracked}";
    network += (i > 0 ? ", {serial: [x" : "{serial: [x") + n + ", f" + n + "]}";
  }
  return plan_with_tracked(modules + network + "]}\n");
}

void expect_equal(const VerdictReport& a, const VerdictReport& b) {
  EXPECT_EQ(a.verdict, b.verdict);
  EXPECT_EQ(a.reason, b.reason);
  EXPECT_EQ(a.components, b.components);
  EXPECT_EQ(a.bias, b.bias);
  EXPECT_EQ(a.extra_variance, b.extra_variance);
  EXPECT_EQ(a.piloted, b.piloted);
}

/// Evaluations that the functions of so many branches take to be judged.
std::size_t evaluations_of(std::size_t width) {
  const Plan plan = wide_plan(width, "value: 1 m, value_std: 1 cm");
  System system(plan, 1);
  system.expect();
  Tracked::evaluated = 0;
  judge(system);
  return Tracked::evaluated;
}

TEST(Judge, CostsInProportionToTheNumberOfBranches) {
  for (const std::size_t width : {10U, 100U, 1000U}) {
    // Now and then trials scatter more than a glance allows, and a pilot decides.
    const std::size_t piloted = 2 + width / 20;
    EXPECT_GE(evaluations_of(width), width * glance_trials);
    EXPECT_LE(evaluations_of(width), width * (glance_trials + 10) + piloted * pilot_trials);
  }
}

TEST(Judge, AnOutputThatNoErrorReachesCostsNothing) {
  const Plan plan = wide_plan(3, "value: 1 m");
  System system(plan, 1);
  system.expect();
  Tracked::created = Tracked::evaluated = 0;
  for (const VerdictReport& report : judge(system)) {
    EXPECT_EQ(report.verdict, Verdict::linear_ok);
    EXPECT_TRUE(report.components.empty());
    EXPECT_FALSE(report.piloted);
  }
  EXPECT_EQ(Tracked::created, 0U);
  EXPECT_EQ(Tracked::evaluated, 0U);
}

TEST(Judge, MakesItsModulesOnce) {
  const Plan plan = wide_plan(3, "value: 1 m, value_std: 1 cm");
  System system(plan, 1);
  Tracked::created = 0;
  Judge judge(system);
  for (int tick = 0; tick < 5; ++tick) {
    system.expect();
    judge.judge();
  }
  EXPECT_EQ(Tracked::created, 3U);
}

TEST(Judge, AllocatesNothingOnceWarm) {
  SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED();
  const Plan plan = wide_plan(3, "value: 1 m, value_std: 30 cm");
  System system(plan, 1);
  Judge judge(system);
  system.expect();
  judge.judge();
  system.expect();
  const std::size_t before = allocation_count;
  const std::vector<VerdictReport>& reports = judge.judge();
  EXPECT_EQ(allocation_count, before);
  EXPECT_TRUE(reports.front().piloted);
}

/// Outputs of all kinds: of one function, of several that share one, of more sources than are
/// moved in pairs, exact, and of readings that come and go.
const std::string many_kinds = R"(
modules:
  a: {type: reading, value: 1 m, value_std: 30 cm, noise: normal}
  b: {type: reading, value: 2 m, value_std: 10 cm, period: 2}
  c: {type: reading, value: 1 mm, value_std: 1 mm, skipped: [3, 4]}
  exact: {type: reading, value: 1 m}
  trunk: {type: product}
  squared: {type: product}
  waved: {type: sine}
  rooted: {type: root}
  bare: {type: sine}
  p0: {type: gain, gain: 3}
)";

/// The above with a sum of so many readings, squared.
Plan plan_of_many_kinds(int readings) {
  std::string text = many_kinds;
  std::string sum = "r0";
  text += "  r0: {type: reading, value: 1 m, value_std: 10 cm}\n";
  for (int i = 1; i < readings; ++i) {
    const std::string n = std::to_string(i);
    text +=
        "  r" + n + ": {type: reading, value: 1 m, value_std: 10 cm}\n  s" + n + ": {type: add}\n";
    sum = "{serial: [combine: [" + sum + ", r" + n + "], s" + n + "]}";
  }
  text += "  whole: {type: sine}\n";
  return plan_with_tracked(text + R"(
network:
  combine:
    - serial: [combine: [a, b], trunk, waved]
    - serial: [combine: [trunk, c], squared]
    - serial: [c, rooted]
    - serial: [exact, bare]
    - serial: [b, p0]
    - serial: [)" + sum + ", whole]\n    - trunk\n    - b\n");
}

TEST(Judge, OverManyTicksSaysWhatAFreshOneSays) {
  const Plan plan = plan_of_many_kinds(14);
  System system(plan, 1);
  Judge kept(system);
  for (int tick = 0; tick < 8; ++tick) {
    system.evaluate(time_at(0.1 * tick));
    const std::vector<VerdictReport> fresh = judge(system);
    const std::vector<VerdictReport>& reports = kept.judge();
    ASSERT_EQ(reports.size(), fresh.size());
    for (std::size_t o = 0; o < fresh.size(); ++o) {
      SCOPED_TRACE(testing::Message() << "tick " << tick << ", output " << o);
      expect_equal(reports[o], fresh[o]);
    }
  }
}

TEST(Judge, AVerdictDoesNotDependOnWhatElseIsJudged) {
  const Plan plan = plan_of_many_kinds(14);
  System system(plan, 1);
  system.evaluate(time_at(0));
  const std::vector<VerdictReport> together = judge(system);
  for (std::size_t o = 0; o < plan.outputs.size(); ++o) {
    SCOPED_TRACE(testing::Message() << "output " << o);
    expect_equal(Judge(system, {plan.outputs[o]}).judge().front(), together[o]);
  }
}

TEST(Judge, JudgesNodesThatAreNoOutputs) {
  const Plan plan = plan_of_many_kinds(2);
  System system(plan, 1);
  system.evaluate(time_at(0));
  EXPECT_EQ(Judge(system, {plan.find("c").value()}).judge().front().verdict, Verdict::linear_ok);
}

TEST(Judge, AHeldValueIsJudgedAsItStands) {
  const Plan plan = plan_with_tracked(R"(
modules:
  slow: {type: reading, value: 1 m, value_std: 1 mm, period: 3}
  fast: {type: reading, value: 1 m, value_std: 1 mm}
  sum: {type: add}
network: {serial: [combine: [slow, fast], sum]}
)");
  System system(plan, 1);
  system.evaluate(time_at(0));
  system.evaluate(time_at(0.1));
  ASSERT_TRUE(system.node(plan.find("slow").value()).outcome.is_pending());
  ASSERT_TRUE(system.node(plan.outputs[0]).outcome.has_output());
  EXPECT_EQ(judge(system).front().verdict, Verdict::linear_ok);
}

TEST(Judge, WhatASelectorPassesOnIsJudgedAsItsBranchIs) {
  const Plan plan = plan_with_tracked(R"(
modules:
  plain: {type: reading, value: 1 m, value_std: 1 cm}
  zero: {type: reading, value: 0 m, value_std: 1 m}
  waved: {type: tracked}
  use: {type: alternate}
  behind: {type: gain, gain: 2}
network: {serial: [combine: [{serial: [zero, waved]}, plain], use, behind]}
)");
  System system(plan, 1);
  Judge kept(system);
  const auto verdict_of = [&](std::string_view name) {
    return Judge(system, {plan.find(name).value()}).judge().front();
  };
  for (int tick = 0; tick < 4; ++tick) {
    SCOPED_TRACE(tick);
    system.evaluate(time_at(0.1 * tick));
    const std::string branch = tick % 2 == 0 ? "waved" : "plain";
    EXPECT_EQ(verdict_of(branch).verdict == Verdict::linear_ok, tick % 2 != 0);
    expect_equal(verdict_of("use"), verdict_of(branch));
    EXPECT_EQ(kept.judge().front().verdict, verdict_of(branch).verdict);
    EXPECT_EQ(kept.judge().front().verdict, judge(system).front().verdict);
  }
}

TEST(Perturbation, RedoesOnlyWhatFollowsFromAChangedError) {
  const Plan plan = wide_plan(4, "value: 1 m, value_std: 1 cm");
  System system(plan, 1);
  system.expect();
  Perturbation perturbation(system, plan.outputs, {}, Redo::functions);
  ASSERT_EQ(perturbation.sources().size(), 4U);
  std::vector<double> errors(4, 0.0);
  errors[2] = 1;
  Tracked::evaluated = 0;
  perturbation.apply(errors);
  EXPECT_EQ(Tracked::evaluated, 1U);
  double changed = 0;
  for (std::size_t t = 0; t < 4; ++t) {
    double offset = 0;
    perturbation.offset(t, {&offset, 1});
    EXPECT_EQ(perturbation.changed(t), offset != 0);
    changed += offset;
  }
  EXPECT_NEAR(changed, 0.01 + 3 * 0.01 + 3 * 1e-4 + 1e-6, 1e-12);
}

}  // namespace
}  // namespace ilss
