// Outputs that break their contract are faults of their module, and unknown correlation goes on
// through any module.
#include <gtest/gtest.h>

#include <cmath>

#include "framework/graph/system.h"
#include "framework/module/carried_correlation.h"
#include "framework/module/sample_rows.h"

namespace ilss {
namespace {

template <typename T>
struct HeldPlace {
  T x, z;
  static constexpr std::string_view name = "contract_place";
  static constexpr auto fields = Fields{{"x", "m"}, {"z", "m"}};
};
struct Beam {
  double range = 0;
  static constexpr auto columns = Columns{column(&Beam::range, "range", "m")};
};
template <typename T>
struct HeldScan {
  T noise;
  static constexpr std::string_view name = "contract_scan";
  static constexpr auto fields = Fields{{"noise", "m"}};
  static SamplesDescriptor samples() { return samples_of_rows<Beam>("beam"); }
};
template <typename T>
struct HeldPlaces {
  T count;
  static constexpr std::string_view name = "contract_places";
  static constexpr auto fields = Fields{{"count", "1"}};
  static constexpr std::string_view element = "contract_place";
  static std::vector<const PayloadDescriptor*> elements() { return {&descriptor<HeldPlace>()}; }
};

Output scan() {
  Output output;
  output.estimate = Estimate(descriptor<HeldScan>());
  make_rows<Beam>(output, 20);
  return output;
}
Output places() {
  Output output;
  output.estimate = Estimate(descriptor<HeldPlaces>());
  for (int i = 0; i < 3; ++i) output.elements.push_back(Estimate(descriptor<HeldPlace>()));
  return output;
}

/// Gives the scan or set that the test wants.
template <template <typename> class Payload>
class Giver final : public Module {
 public:
  static constexpr std::string_view name = Payload<double>::name, description = "for tests";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static Interface interface() { return {{}, &descriptor<Payload>(), {}, {}}; }
  Outcome<> evaluate(const Evaluation&, Output& output) override {
    output.samples = given.samples;
    output.elements = given.elements;
    assign<Payload>(output.estimate, {1});
    output.estimate.correlation_unknown = given.estimate.correlation_unknown;
    return {};
  }
  static inline Output given;
};

/// Copies a set, and says nothing of correlation.
class Copier final : public Module {
 public:
  static constexpr std::string_view name = "copier", description = "for tests";
  static constexpr ModuleKind kind = ModuleKind::function;
  static Interface interface() {
    return {{{"in", &descriptor<HeldPlaces>()}}, &descriptor<HeldPlaces>()};
  }
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    output.elements.resize(evaluation.inputs[0]->elements.size());
    for (Estimate& element : output.elements) element = Estimate(descriptor<HeldPlace>());
    output.estimate.value = evaluation.input(0).value;
    output.estimate.lineage.reset(1);
    return {};
  }
};

/// A statement about a set that has no error of its own.
class Statement final : public Module {
 public:
  static constexpr std::string_view name = "statement", description = "for tests";
  static constexpr ModuleKind kind = ModuleKind::function;
  static constexpr bool states_no_error = true;
  static Interface interface() {
    return {{{"in", &descriptor<HeldPlaces>()}}, &descriptor<HeldPlaces>()};
  }
  Outcome<> evaluate(const Evaluation&, Output& output) override {
    assign<HeldPlaces>(output.estimate, {1});
    return {};
  }
};

Plan plan_of(const std::string& text) {
  static const Registry& registry = *[] {
    auto* r = new Registry;
    r->add<Giver<HeldScan>>();
    r->add<Giver<HeldPlaces>>();
    r->add<Copier>();
    r->add<Statement>();
    return r;
  }();
  Diagnostics diagnostics;
  auto plan =
      build_plan(parse_document(text, "test.yaml", diagnostics), ".", registry, {}, diagnostics);
  for (const Diagnostic& d : diagnostics.sorted()) ADD_FAILURE() << format_diagnostic(d);
  return plan.value_or(Plan{});
}

TEST(System, ARangeOrACornerThatIsNotFiniteIsTheFaultNotFinite) {
  Giver<HeldScan>::given = scan();
  make_rows<Beam>(Giver<HeldScan>::given, 20)[7].range = std::nan("");
  Giver<HeldPlaces>::given = places();
  Giver<HeldPlaces>::given.elements[0].value[0] = std::nan("");
  for (const std::string module : {"contract_scan", "contract_places"}) {
    const Plan plan = plan_of("modules: {m: {type: " + module + "}}\nnetwork: m\n");
    System system(plan, 1);
    system.evaluate({});
    ASSERT_TRUE(system.node(0).outcome.is_fault()) << module;
    EXPECT_EQ(system.node(0).outcome.fault().kind, FaultKind::not_finite);
  }
}

TEST(CarriedCorrelation, GoesOnThroughAModuleThatSaysNothingAndEndsWithItsCause) {
  const Plan plan = plan_of(
      "modules: {a: {type: contract_places}, b: {type: copier}}\nnetwork: {serial: [a, b]}\n");
  System system(plan, 1);
  for (const bool unknown : {false, true, false}) {
    Giver<HeldPlaces>::given = places();
    Giver<HeldPlaces>::given.estimate.correlation_unknown = unknown;
    system.evaluate(time_at(static_cast<double>(system.ticks())));
    for (const std::size_t node : {0, 1}) {
      const Output& output = system.node(node).output();
      EXPECT_EQ(output.estimate.correlation_unknown, unknown) << node;
      for (const Estimate& element : output.elements)
        EXPECT_EQ(element.correlation_unknown, unknown) << node;
    }
  }
}

TEST(CarriedCorrelation, OfOneElementIsTheSets) {
  const Plan plan = plan_of("modules: {a: {type: contract_places}}\nnetwork: a\n");
  System system(plan, 1);
  Giver<HeldPlaces>::given = places();
  Giver<HeldPlaces>::given.elements[1].correlation_unknown = true;
  system.evaluate({});
  EXPECT_TRUE(system.node(0).output().estimate.correlation_unknown);
  EXPECT_TRUE(system.node(0).output().elements[0].correlation_unknown);
}

TEST(CarriedCorrelation, OfAHeldOutputStays) {
  Giver<HeldPlaces> giver;
  Giver<HeldPlaces>::given = places();
  Giver<HeldPlaces>::given.estimate.correlation_unknown = true;
  Output output = places();
  const Estimate none(no_parameters());
  const Evaluation evaluation{.parameters = none, .inputs = {}};
  const ModuleType type = module_type<Giver<HeldPlaces>>();
  const auto evaluate = [&] { return giver.evaluate(evaluation, output); };
  ASSERT_TRUE(carry_correlation(type, evaluation, output, evaluate));
  ASSERT_TRUE(output.estimate.correlation_unknown);
  EXPECT_TRUE(carry_correlation(type, evaluation, output, [] {
                return Outcome<>(Pending{});
              }).is_pending());
  EXPECT_TRUE(output.estimate.correlation_unknown);
  EXPECT_TRUE(output.elements[2].correlation_unknown);
}

TEST(CarriedCorrelation, EndsAtAStatementWithoutAnError) {
  const Plan plan = plan_of(
      "modules: {a: {type: contract_places}, b: {type: statement}}\nnetwork: {serial: [a, b]}\n");
  System system(plan, 1);
  Giver<HeldPlaces>::given = places();
  Giver<HeldPlaces>::given.estimate.correlation_unknown = true;
  system.evaluate({});
  EXPECT_TRUE(system.node(0).output().estimate.correlation_unknown);
  EXPECT_FALSE(system.node(1).output().estimate.correlation_unknown);
}

}  // namespace
}  // namespace ilss
