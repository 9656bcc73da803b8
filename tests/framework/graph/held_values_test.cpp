// What a held value brings along, and what a system does with modules that break their contract.
#include <gtest/gtest.h>

#include <cmath>

#include "framework/graph/system.h"

namespace ilss {
namespace {

template <typename T>
struct Triple {
  T a, b, c;
  static constexpr std::string_view name = "held_triple";
  static constexpr auto fields = Fields{{"a", "m"}, {"b", "m"}, {"c", "m"}};
};
template <typename T>
struct Length {
  T x;
  static constexpr std::string_view name = "held_length";
  static constexpr auto fields = Fields{{"x", "m"}};
};

/// Three independent errors at the first tick, then nothing new.
class Once final : public Module {
 public:
  static constexpr std::string_view name = "once", description = "for tests";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static Interface interface() { return {{}, &descriptor<Triple>(), {}, {}}; }
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    if (evaluation.tick > 0) return Pending{};
    assign<Triple>(output.estimate, {0, 0, 0});
    output.estimate.lineage.add_noise(evaluation.fresh(0), Eigen::Matrix3d::Identity());
    return {};
  }
};

/// The tick's number, without error.
class Counter final : public Module {
 public:
  static constexpr std::string_view name = "tick_number", description = "for tests";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static Interface interface() { return {{}, &descriptor<Length>(), {}, {}}; }
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    assign<Length>(output.estimate, {static_cast<double>(evaluation.tick)});
    return {};
  }
};

/// The component of `triple` that `which` says.
struct Pick {
  static constexpr std::string_view name = "pick", description = "for tests";
  static constexpr std::array<std::string_view, 2> inputs = {"triple", "which"};
  template <typename T>
  Outcome<Length<T>> operator()(const Triple<T>& triple, const Length<T>& which) const {
    const int component = static_cast<int>(scalar_value(which.x)) % 3;
    return Length<T>{component == 0 ? triple.a : component == 1 ? triple.b : triple.c};
  }
};

/// Gives NaN, and throws something that is no std::exception at a command.
class Rogue final : public Module {
 public:
  static constexpr std::string_view name = "rogue", description = "for tests";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static Interface interface() { return {{}, &descriptor<Length>(), {}, {}}; }
  Outcome<> evaluate(const Evaluation&, Output& output) override {
    assign<Length>(output.estimate, {std::nan("")});
    return {};
  }
  Outcome<> command(const Command&) override { throw 42; }
};

Plan plan_of(const std::string& text) {
  static const Registry& registry = *[] {
    auto* r = new Registry;
    r->add<Once>();
    r->add<Counter>();
    r->add<Pick>();
    r->add<Rogue>();
    return r;
  }();
  Diagnostics diagnostics;
  auto plan =
      build_plan(parse_document(text, "test.yaml", diagnostics), ".", registry, {}, diagnostics);
  for (const Diagnostic& d : diagnostics.sorted()) ADD_FAILURE() << format_diagnostic(d);
  return plan.value_or(Plan{});
}

TEST(HeldValue, ErrorsStayApartFromTickToTickWhateverIsFolded) {
  const Plan plan = plan_of(R"(
modules: {once: {type: once}, which: {type: tick_number}, pick: {type: pick}}
network: {serial: [combine: [once, which], pick]}
)");
  for (const Folding folding : {Folding::none, Folding::per_owner, Folding::all}) {
    System system(plan, 1, folding);
    std::vector<Estimate> picked;
    for (int tick = 0; tick < 3; ++tick) {
      system.evaluate(time_at(tick));
      picked.push_back(system.node(plan.outputs[0]).output().estimate);
    }
    const std::vector<double> weights(3, 1.0 / 3);
    EXPECT_NEAR(linear_combination(picked, weights).lineage.variance(0), 1.0 / 3, 1e-12)
        << static_cast<int>(folding);
  }
}

TEST(System, OutputThatIsNotFiniteIsAFaultOfItsSensor) {
  const Plan plan = plan_of("modules: {rogue: {type: rogue}}\nnetwork: rogue\n");
  System system(plan, 1);
  system.evaluate(time_at(0));
  ASSERT_TRUE(system.node(0).outcome.is_fault());
  EXPECT_EQ(system.node(0).outcome.fault().kind, FaultKind::not_finite);
  EXPECT_FALSE(system.node(0).has_value);
}

TEST(System, WhatACommandThrowsBecomesAFault) {
  const Plan plan = plan_of("modules: {rogue: {type: rogue}}\nnetwork: rogue\n");
  System system(plan, 1);
  const Outcome<> outcome = system.command(0, {"turn", 1.0});
  ASSERT_TRUE(outcome.is_fault());
  EXPECT_EQ(outcome.fault().kind, FaultKind::internal);
}

}  // namespace
}  // namespace ilss
