// Graphs become plans: operators, instances, nesting, constants, overrides.
#include <gtest/gtest.h>

#include "framework/graph/plan.h"
#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

using test::blamed;
using test::estimate_of;
using test::Folder;
using test::output_of;
using test::plan_of;
using test::read_text;

std::vector<std::string> names(const Plan& plan, const std::vector<std::size_t>& nodes) {
  std::vector<std::string> result;
  for (const std::size_t node : nodes) result.push_back(plan.nodes[node].name);
  return result;
}

std::vector<std::string> inputs_of(const Plan& plan, const std::string& node) {
  std::vector<std::size_t> nodes;
  for (const PlanInput& input : plan.nodes[plan.find(node).value()].inputs)
    nodes.push_back(input.node);
  return names(plan, nodes);
}

using Names = std::vector<std::string>;

constexpr const char* diamond = R"(
ilss: diamond
modules:
  last: {type: subtract}
  source: {type: reading, value: 3 m, value_std: 1 mm}
  up: {type: gain, gain: 2}
  down: {type: gain, gain: 2}
network:
  serial: [source, combine: [up, down], last]
)";

TEST(PlanBuilder, SerialFeedsEachOutputToTheNext) {
  const Plan plan = plan_of(R"(
modules: {c: {type: sine}, b: {type: sine}, a: {type: reading}}
network: {serial: [a, b, c]}
)");
  EXPECT_EQ(inputs_of(plan, "b"), Names{"a"});
  EXPECT_EQ(inputs_of(plan, "c"), Names{"b"});
  EXPECT_EQ(names(plan, plan.outputs), Names{"c"});
}

TEST(PlanBuilder, CombinePutsOutputsSideBySideInOrder) {
  const Plan plan = plan_of(R"(
modules: {s: {type: subtract}, a: {type: reading}, b: {type: reading}}
network: {serial: [combine: [b, a], s]}
)");
  EXPECT_EQ(inputs_of(plan, "s"), (Names{"b", "a"}));
}

TEST(PlanBuilder, CombineInsideSerialFeedsEveryBranch) {
  const Plan plan = plan_of(diamond);
  EXPECT_EQ(inputs_of(plan, "up"), Names{"source"});
  EXPECT_EQ(inputs_of(plan, "down"), Names{"source"});
  EXPECT_EQ(inputs_of(plan, "last"), (Names{"up", "down"}));
  EXPECT_EQ(plan.name, "diamond");
}

TEST(PlanBuilder, InputsComeBeforeTheirConsumersInEvaluationOrder) {
  const Plan plan = plan_of(diamond);
  for (std::size_t i = 0; i < plan.nodes.size(); ++i)
    for (const PlanInput& input : plan.nodes[i].inputs) EXPECT_LT(input.node, i);
}

TEST(PlanBuilder, ANameUsedTwiceIsOneInstance) {
  const Plan plan = plan_of(R"(
modules: {a: {type: reading}, f: {type: sine}, g: {type: gain, gain: 1}, s: {type: add}}
network: {serial: [combine: [{serial: [a, f]}, {serial: [a, g]}], s]}
)");
  EXPECT_EQ(plan.nodes.size(), 4u);
  EXPECT_EQ(inputs_of(plan, "f"), Names{"a"});
  EXPECT_EQ(inputs_of(plan, "g"), Names{"a"});
}

TEST(PlanBuilder, AnInstanceConnectedOnceCanBeNamedAgain) {
  const Plan plan = plan_of(R"(
modules: {a: {type: reading}, f: {type: sine}, s: {type: add}}
network: {combine: [{serial: [a, f]}, {serial: [combine: [f, a], s]}]}
)");
  EXPECT_EQ(inputs_of(plan, "s"), (Names{"f", "a"}));
  EXPECT_EQ(names(plan, plan.outputs), (Names{"f", "s"}));
}

TEST(PlanBuilder, OtherInputsForAConnectedInstanceAreAnError) {
  const auto read = read_text(R"(
modules: {a: {type: reading}, b: {type: reading}, f: {type: sine}}
network: {combine: [{serial: [a, f]}, {serial: [b, f]}]}
)");
  EXPECT_EQ(read.errors,
            "graph.yaml:3:52: 'f' has its inputs already from line 3; an instance is evaluated "
            "once a tick\n");
}

TEST(PlanBuilder, RepeatedInputTakesAnyNumberButNone) {
  const Plan plan = plan_of(R"(
modules: {a: {type: reading}, b: {type: reading}, c: {type: reading}, t: {type: total}}
network: {serial: [combine: [a, b, c], t]}
)");
  EXPECT_EQ(inputs_of(plan, "t"), (Names{"a", "b", "c"}));
  EXPECT_EQ(read_text("modules: {t: {type: total}}\nnetwork: t\n").errors,
            "graph.yaml:1:11: 't' has unconnected inputs: terms (scalar)\n");
}

TEST(PlanBuilder, NestedCombinesKeepTheSmallestMaxAge) {
  const Plan plan = plan_of(R"(
modules: {a: {type: reading}, b: {type: reading}, s: {type: add}}
network:
  serial:
    - combine: {of: [combine: {of: [a], max_age: 5 ms}, b], max_age: 20 ms}
    - s
)");
  const std::vector<PlanInput>& inputs = plan.nodes[plan.find("s").value()].inputs;
  EXPECT_EQ(inputs[0].max_age.value(), duration_of(0.005));
  EXPECT_EQ(inputs[1].max_age.value(), duration_of(0.020));
}

TEST(PlanBuilder, FrameComesFromTheFirstInputUnlessDeclared) {
  const Plan plan = plan_of(R"(
modules: {a: {type: reading, frame: here}, f: {type: sine}, c: {type: carry}, g: {type: sine}}
network: {serial: [a, f, c, g]}
)");
  EXPECT_EQ(plan.nodes[plan.find("f").value()].frame, "here");
  EXPECT_EQ(plan.nodes[plan.find("g").value()].frame, "there");
}

TEST(PlanBuilder, InputsWithoutAPlaceInSpaceGoWithAnyFrame) {
  const Plan plan = plan_of(R"(
modules: {a: {type: reading, frame: here}, b: {type: reading}, s: {type: add}}
network: {serial: [combine: [a, b], s]}
)");
  EXPECT_EQ(plan.nodes[plan.find("s").value()].frame, "here");
}

TEST(PlanBuilder, TimeIsOneNumberOrTypicalAndWorst) {
  const Plan plan = plan_of(R"(
modules: {a: {type: reading, time: 2 ms}, f: {type: sine, time: {typical: 1 us, worst: 1 ms}}}
network: {serial: [a, f]}
)");
  EXPECT_DOUBLE_EQ(plan.nodes[0].time->worst, 0.002);
  EXPECT_DOUBLE_EQ(plan.nodes[1].time->typical, 1e-6);
  EXPECT_DOUBLE_EQ(plan.nodes[1].time->worst, 1e-3);
}

// --- nested systems

class NestedSystems : public testing::Test {
 protected:
  NestedSystems() {
    folder_.write("arm.yaml", R"(
ilss: arm
constants: {length: {value: 1 m, std: 1 mm}, play: {value: 0 mm, std: 2 mm}}
modules:
  reading: {type: reading, value: 1 m, bias: $length, mount: {x: $play}}
  gain: {type: gain, gain: 3}
network: {serial: [reading, gain]}
)");
  }
  Plan plan(const std::string& text, const std::vector<std::string>& sets = {}) const {
    return plan_of(text, sets, folder_.path());
  }
  Folder folder_;
};

TEST_F(NestedSystems, StandWhereAModuleStands) {
  const Plan p = plan(R"(
modules: {left: {type: {ilss: arm.yaml}}, right: {type: {ilss: arm.yaml}}, s: {type: subtract}}
network: {serial: [combine: [left, right], s]}
)");
  EXPECT_EQ(p.nodes.size(), 5u);
  EXPECT_EQ(inputs_of(p, "s"), (Names{"left.gain", "right.gain"}));
}

TEST_F(NestedSystems, HaveConstantsOfTheirOwn) {
  const Plan p = plan(R"(
modules: {left: {type: {ilss: arm.yaml}}, right: {type: {ilss: arm.yaml}}, s: {type: subtract}}
network: {serial: [combine: [left, right], s]}
)");
  System system(p, 1);
  system.evaluate(time_at(0));
  // 3 (1 mm, 2 mm) on each side: variance 2 x 9 x 5 mm².
  EXPECT_NEAR(output_of(system).lineage.variance(0), 90e-6, 1e-12);
  EXPECT_EQ(blamed(p, output_of(system).lineage),
            (Names{"left.length", "left.play", "right.length", "right.play"}));
}

TEST_F(NestedSystems, SharedConstantIsOneSource) {
  const Plan p = plan(R"(
constants: {size: {value: 2 m, std: 1 mm}}
modules:
  left: {type: {ilss: arm.yaml}, set: {constants.length: $size}}
  right: {type: {ilss: arm.yaml}, set: {constants.length: $size}}
  s: {type: subtract}
network: {serial: [combine: [left, right], s]}
)");
  System system(p, 1);
  system.evaluate(time_at(0));
  EXPECT_DOUBLE_EQ(estimate_of(system, "left.gain").value[0], 9.0);
  // Of what differs between the arms, only the play is left: 2 x 9 x 4 mm².
  EXPECT_NEAR(output_of(system).lineage.variance(0), 72e-6, 1e-12);
  const Eigen::MatrixXd shared = cross_covariance(estimate_of(system, "left.gain").lineage,
                                                  estimate_of(system, "right.gain").lineage);
  EXPECT_NEAR(shared(0, 0), 9e-6, 1e-13);
}

TEST_F(NestedSystems, SharedVectorConstantIsOneSetOfSources) {
  folder_.write("calibrated.yaml", R"(
constants: {fit: {value: {gain: 1, offset: 0 mm}}}
modules: {r: {type: reading, value: 1 m}, g: {type: gain, gain: $fit.gain, offset: $fit.offset}}
network: {serial: [r, g]}
)");
  const Plan p = plan(R"(
constants: {fit: {value: {gain: 2, offset: 5 mm}, covariance: [[0.01, 0], [0, 4]]}}
modules:
  left: {type: {ilss: calibrated.yaml}, set: {constants.fit: $fit}}
  right: {type: {ilss: calibrated.yaml}, set: {constants.fit: $fit}}
  s: {type: subtract}
network: {serial: [combine: [left, right], s]}
)");
  System system(p, 1);
  system.evaluate(time_at(0));
  EXPECT_DOUBLE_EQ(estimate_of(system, "left.g").value[0], 2.005);
  EXPECT_GT(estimate_of(system, "left.g").lineage.variance(0), 0.01);
  EXPECT_EQ(output_of(system).lineage.variance(0), 0.0);
}

TEST_F(NestedSystems, SetReachesParametersWithConstantsOfTheOuterGraph) {
  const Plan p = plan(R"(
constants: {size: {value: 2 m, std: 1 mm}}
modules:
  arm: {type: {ilss: arm.yaml}, set: {reading.mount: {x: $size}, gain.gain: {value: 1, std: 0.1}}}
network: arm
)");
  System system(p, 1);
  system.evaluate(time_at(0));
  EXPECT_DOUBLE_EQ(output_of(system).value[0], 4.0);
  EXPECT_EQ(blamed(p, output_of(system).lineage), (Names{"size", "arm.length", "arm.gain.gain"}));
}

TEST_F(NestedSystems, CommandLineReachesDeepAndWinsOverSet) {
  folder_.write("robot.yaml", R"(
modules: {arm: {type: {ilss: arm.yaml}, set: {gain.gain: 5}}}
network: arm
)");
  const std::string text = "modules: {robot: {type: {ilss: robot.yaml}}}\nnetwork: robot\n";
  EXPECT_EQ(plan(text).nodes[1].parameters.value[0], 5);
  EXPECT_EQ(plan(text, {"robot.arm.gain.gain=7"}).nodes[1].parameters.value[0], 7);
  const Plan p = plan(text, {"robot.arm.constants.length={value: 4 m, std: 3 mm}"});
  EXPECT_EQ(p.nodes[0].parameters.value[0], 4);
  EXPECT_NEAR(p.nodes[0].parameters.lineage.variance(0), 9e-6, 1e-15);
}

TEST_F(NestedSystems, AFileThatContainsItselfIsAnError) {
  folder_.write("self.yaml", "modules: {me: {type: {ilss: self.yaml}}}\nnetwork: me\n");
  Diagnostics diagnostics;
  EXPECT_FALSE(read_plan(folder_.path() / "self.yaml", test::registry(), {}, diagnostics));
  EXPECT_EQ(test::messages(diagnostics),
            (folder_.path() / "self.yaml").string() + ":1:29: 'self.yaml' contains itself\n");
}

TEST_F(NestedSystems, FilesThatContainEachOtherAreAnError) {
  folder_.write("one.yaml", "modules: {x: {type: {ilss: ./two.yaml}}}\nnetwork: x\n");
  folder_.write("two.yaml", "modules: {y: {type: {ilss: one.yaml}}}\nnetwork: y\n");
  Diagnostics diagnostics;
  EXPECT_FALSE(read_plan(folder_.path() / "one.yaml", test::registry(), {}, diagnostics));
  EXPECT_NE(test::messages(diagnostics).find("two.yaml:1:28: 'one.yaml' contains itself"),
            std::string::npos)
      << test::messages(diagnostics);
}

TEST_F(NestedSystems, AMissingFileIsReportedAtBothPlaces) {
  const auto read = read_text(
      "modules: {a: {type: {ilss: none.yaml}}, f: {type: sine}}\n"
      "network: {serial: [a, f]}\n",
      {}, folder_.path());
  EXPECT_EQ(read.errors, (folder_.path() / "none.yaml").string() +
                             ": the file cannot be read\n"
                             "graph.yaml:1:28: the nested system 'none.yaml' cannot be read\n");
}

// --- overrides

constexpr const char* simple = R"(
constants: {k: {value: 2, std: 0.1}, v: {value: {g: 4}, covariance: [[1]]}}
modules:
  a: {type: reading, value: 1 m, mount: {x: 5 mm}, bias: 1 mm}
  g: {type: gain, gain: $k}
network: {serial: [a, g]}
)";

TEST(Overrides, SetQuantitiesGroupsOptionsTimesAndConstants) {
  const Plan plan = plan_of(simple, {"a.value=2 m", "a.mount.x=7 mm", "a.time=3 ms",
                                     "constants.k={value: 3, std: 0.2}", "g.offset=1 cm"});
  EXPECT_DOUBLE_EQ(plan.nodes[0].parameters.value[1], 0.007);
  EXPECT_DOUBLE_EQ(plan.nodes[0].time->typical, 0.003);
  System system(plan, 1);
  system.evaluate(time_at(0));
  EXPECT_DOUBLE_EQ(output_of(system).value[0], 3 * (2 + 0.007 + 0.001) + 0.01);
  EXPECT_NEAR(plan.nodes[1].parameters.lineage.variance(0), 0.04, 1e-15);
}

TEST(Overrides, StdAloneKeepsTheValue) {
  const Plan plan = plan_of(simple, {"a.bias.std=2 mm", "constants.k.std=0.5"});
  EXPECT_DOUBLE_EQ(plan.nodes[0].parameters.value[0], 0.001);
  EXPECT_NEAR(plan.nodes[0].parameters.lineage.variance(0), 4e-6, 1e-15);
  EXPECT_NEAR(plan.nodes[1].parameters.lineage.variance(0), 0.25, 1e-15);
}

TEST(Overrides, MayReferToTheGraphsConstants) {
  const Plan plan = plan_of(simple, {"g.gain=$v.g"});
  EXPECT_DOUBLE_EQ(plan.nodes[1].parameters.value[0], 4);
  EXPECT_NEAR(plan.nodes[1].parameters.lineage.variance(0), 1, 1e-15);
}

TEST(Overrides, OfUnknownNamesAreReportedWithSuggestions) {
  EXPECT_EQ(read_text(simple, {"b.value=1 m", "a.bais=1 m", "constants.kk=1", "a=5", "a.type=sine",
                               "constants=1"})
                .errors,
            "--set:1:1: 'a' names a module; expected MODULE.PARAMETER\n"
            "--set:1:1: a module's type cannot be set\n"
            "--set:1:1: reading has no parameter 'bais'; did you mean 'bias'?\n"
            "--set:1:1: there is no constant ''\n"
            "--set:1:1: there is no constant 'kk'; did you mean 'k'?\n"
            "--set:1:1: there is no module 'b'\n");
}

TEST(Overrides, NeedAPathAndAValue) {
  for (const char* text : {"", "a.value", "=1", "a.value=", "a.value= ", "a.value={"})
    EXPECT_NE(read_text(simple, {text}).errors, "") << text;
}

TEST(Overrides, OfVeryDeepNamesAreRefused) {
  std::string path = "a";
  for (int i = 0; i < 100000; ++i) path += ".a";
  EXPECT_EQ(read_text(simple, {path + "=1"}).errors, "--set:1:1: the name has too many parts\n");
}

}  // namespace
}  // namespace ilss
