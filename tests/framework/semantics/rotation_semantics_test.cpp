// Verdicts and Monte Carlo of rotations in space, near no turn and across half a turn.
#include <gtest/gtest.h>

#include <numbers>

#include "framework/estimate/rotation.h"
#include "framework/module/function_module.h"
#include "framework/semantics/monte_carlo.h"
#include "framework/semantics/verdict.h"
#include "tests/framework/graph/read_graph.h"
#include "tests/orientation.h"

namespace ilss {
namespace {

using test::Orientation;

/// An orientation of given components with independent local errors.
class OrientationReading final : public Module {
 public:
  static constexpr std::string_view name = "orientation", description = "for tests";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  struct Options {
    double x = 0;
    double y = 0;
    double z = 0;
    double deviation = 0;
    void declare(OptionVisitor& visit) {
      for (const auto& [key, value] :
           {std::pair("x", &x), {"y", &y}, {"z", &z}, {"deviation", &deviation}})
        visit(key, *value, "", {.unit = "rad"});
    }
  };
  static Interface interface() { return {{}, &descriptor<Orientation>(), {}, {}}; }
  explicit OrientationReading(const Options& options) : options_(options) {}
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    output.estimate.value = {options_.x, options_.y, options_.z};
    output.estimate.lineage.reset(3);
    for (std::uint32_t c = 0; c < 3; ++c)
      output.estimate.lineage.add(evaluation.fresh(c), c, options_.deviation);
    return {};
  }

 private:
  Options options_;
};

struct Turned {
  static constexpr std::string_view name = "turned", description = "one rotation after another";
  static constexpr std::array<std::string_view, 2> inputs = {"first", "second"};
  template <typename T>
  Outcome<Orientation<T>> operator()(const Orientation<T>& a, const Orientation<T>& b) const {
    const auto r = rotation_product<T>({a.rx, a.ry, a.rz}, {b.rx, b.ry, b.rz});
    return Orientation<T>{r[0], r[1], r[2]};
  }
};

Plan plan_of(const std::string& first, const std::string& second) {
  static const Registry* const registry = [] {
    auto* made = new Registry;
    made->add<OrientationReading>();
    made->add<Turned>();
    return made;
  }();
  Diagnostics diagnostics;
  const Node graph = parse_document("modules:\n  a: {type: orientation, " + first +
                                        "}\n  b: {type: orientation, " + second +
                                        "}\n  t: {type: turned}\nnetwork:\n  serial: [combine: "
                                        "[a, b], t]\n",
                                    "graph.yaml", diagnostics);
  auto plan = build_plan(graph, ".", *registry, {}, diagnostics);
  EXPECT_EQ(test::messages(diagnostics), "");
  return std::move(plan.value());
}

const char* const rotations[][2] = {
    {"x: 1 deg, deviation: 2 deg", "y: 2 deg, deviation: 1 deg"},
    {"x: 100 deg, deviation: 2 deg", "x: 80 deg, deviation: 1 deg"},  // half a turn
    {"z: 179.9 deg, deviation: 2 deg", "y: 179.9 deg, deviation: 1 deg"},
};

TEST(RotationVerdict, OfSmallErrorsIsLinearEverywhere) {
  for (const auto& [first, second] : rotations) {
    const Plan plan = plan_of(first, second);
    System system(plan, 1);
    system.expect();
    const VerdictReport report = judge(system).at(0);
    EXPECT_EQ(report.verdict, Verdict::linear_ok) << first << " " << report.reason;
    for (const double bias : report.bias) EXPECT_NEAR(bias, 0, 1e-3);
  }
}

TEST(RotationVerdict, OfErrorsAsLargeAsATurnIsNotLinear) {
  const Plan plan = plan_of("x: 10 deg, deviation: 60 deg", "y: 20 deg, deviation: 60 deg");
  System system(plan, 1);
  system.expect();
  EXPECT_NE(judge(system).at(0).verdict, Verdict::linear_ok);
}

TEST(RotationMonteCarlo, IsAsFirstOrderSaysAcrossHalfATurn) {
  for (const auto& [first, second] : rotations) {
    SCOPED_TRACE(first);
    const Plan plan = plan_of(first, second);
    System system(plan, 1);
    system.expect();
    const Estimate& estimate = test::output_of(system);
    const MonteCarloOutput result = run_monte_carlo(system, {}, {.trials = 100'000}).at(0);
    const Eigen::VectorXd bias =
        difference(*estimate.type, std::span<const double>(result.mean.data(), 3), estimate.value);
    EXPECT_LT(bias.norm(), 1e-3);
    const Eigen::MatrixXd stated = estimate.lineage.covariance();
    EXPECT_LT((result.covariance - stated).norm(), 0.02 * stated.norm());
    for (const double coverage : result.coverage) EXPECT_NEAR(coverage, 0.95, 0.004);
    EXPECT_NEAR(result.joint_coverage, 0.95, 0.004);
  }
}

}  // namespace
}  // namespace ilss
