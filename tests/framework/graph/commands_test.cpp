// A system's commands in its plan: which module follows them, and what drives them.
#include "framework/graph/commands.h"

#include <gtest/gtest.h>

#include "framework/graph/dot.h"
#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

constexpr const char* modules = R"(
modules:
  turn: {type: turn_reading, angle: 3 deg}
  x: {type: reading}
  head: {type: head}
network: {combine: [head, turn, x]}
)";

/// The plan of the modules above with these commands.
Plan plan_with(const std::string& commands) {
  return test::plan_of(modules + ("commands: " + commands));
}

/// What is wrong with commands of the modules above; they stand in line 7.
std::string errors_of(const std::string& commands) {
  return test::read_text(modules + ("commands: " + commands)).errors;
}

TEST(Commands, AreNoneWhereAGraphDeclaresNone) {
  EXPECT_TRUE(test::plan_of(modules).commands.empty());
  EXPECT_TRUE(plan_with("{}").commands.empty());
}

TEST(Commands, MapANameToAModulesCommand) {
  for (const char* form : {"{look: head.rotate_to}", "{look: {to: head.rotate_to}}"}) {
    const Plan plan = plan_with(form);
    ASSERT_EQ(plan.commands.size(), 1U) << form;
    EXPECT_EQ(plan.commands[0].name, "look");
    EXPECT_EQ(plan.nodes[plan.commands[0].node].name, "head");
    EXPECT_EQ(plan.commands[0].declaration->name, "rotate_to");
    EXPECT_EQ(plan.commands[0].declaration->value.unit, "rad");
    EXPECT_FALSE(plan.commands[0].driver);
  }
}

TEST(Commands, AreDrivenByAComponent) {
  const Plan plan = plan_with("{look: {to: head.rotate_to, from: turn.angle}}");
  ASSERT_TRUE(plan.commands.at(0).driver);
  EXPECT_EQ(plan.nodes[plan.commands[0].driver->node].name, "turn");
  EXPECT_EQ(plan.commands[0].driver->component, 0U);
}

TEST(Commands, ANumberIsDrivenByAPureNumber) {
  const Plan plan = plan_with("{zoom: {to: head.zoom, from: turn.ratio}}");
  ASSERT_TRUE(plan.commands.at(0).driver);
  EXPECT_EQ(plan.commands[0].driver->component, 1U);
}

TEST(Commands, AModuleMayDriveItself) {
  const Plan plan = plan_with("{look: {to: head.rotate_to, from: head.angle}}");
  EXPECT_EQ(plan.commands.at(0).driver->node, plan.commands[0].node);
}

TEST(Commands, OfOneModulesCommandMayHaveSeveralNames) {
  EXPECT_EQ(plan_with("{look: head.rotate_to, turn: head.rotate_to}").commands.size(), 2U);
}

TEST(Commands, AComponentThatIsTheOnlyOneNeedsNoName) {
  EXPECT_EQ(errors_of("{zoom: {to: head.zoom, from: x}}"),
            "graph.yaml:7:40: 'x' of 'x' is a length (m), but 'zoom' takes a pure number\n");
}

TEST(Commands, AreAMap) {
  EXPECT_EQ(errors_of("[head.rotate_to]"),
            "graph.yaml:7:11: expected a map of names to modules' commands, got a list\n");
  EXPECT_EQ(errors_of(""),
            "graph.yaml:7:1: expected a map of names to modules' commands, got nothing\n");
}

TEST(Commands, AreDrivenByOneThingAlone) {
  EXPECT_EQ(errors_of("{a: {to: head.rotate_to, from: turn.angle}, "
                      "b: {to: head.rotate_to, from: head.angle}}"),
            "graph.yaml:7:85: 'head.rotate_to' is driven already, by the command 'a'\n");
}

TEST(Commands, AreDrawnAsDashedArrowsWhereTheyAreDriven) {
  const std::string dot =
      to_dot(plan_with("{look: {to: head.rotate_to, from: turn.angle}, zoom: head.zoom}"));
  EXPECT_NE(dot.find("  n0 -> n2 [label=<look<br/><font color=\"#777777\">from angle</font>>, "
                     "style=dashed, constraint=false];\n"),
            std::string::npos)
      << dot;
  EXPECT_EQ(dot.find("zoom"), std::string::npos) << dot;
}

/// A system in which an angle drives a head, inside another.
class NestedCommands : public testing::Test {
 protected:
  NestedCommands() {
    folder_.write("inner.yaml",
                  "modules: {turn: {type: turn_reading, angle: 3 deg}, head: {type: head}}\n"
                  "network: {combine: [head, turn]}\n"
                  "commands:\n"
                  "  look_at: {to: head.rotate_to, from: turn.angle}\n"
                  "  zoom: head.zoom\n");
    folder_.write(
        "one.yaml",
        "modules: {head: {type: head}}\nnetwork: head\ncommands: {look: head.rotate_to}\n");
    folder_.write("silent.yaml", "modules: {head: {type: head}}\nnetwork: head\n");
  }
  std::string errors_of(const std::string& commands) const {
    return test::read_text(text(commands), {}, folder_.path()).errors;
  }
  Plan plan_with(const std::string& commands) const {
    return test::plan_of(text(commands), {}, folder_.path());
  }
  static std::string text(const std::string& commands) {
    return "modules:\n"
           "  inner: {type: {ilss: inner.yaml}}\n"
           "  one: {type: {ilss: one.yaml}}\n"
           "  silent: {type: {ilss: silent.yaml}}\n"
           "network: {combine: [inner, one, silent]}\n"
           "commands: " +
           commands;
  }
  test::Folder folder_;
};

TEST_F(NestedCommands, AreOfferedUnderTheNameOfTheirSystem) {
  const Plan plan = plan_with("{}");
  std::vector<std::string> names;
  for (const PlanCommand& command : plan.commands) names.push_back(command.name);
  EXPECT_EQ(names, (std::vector<std::string>{"inner.look_at", "inner.zoom", "one.look"}));
}

TEST_F(NestedCommands, GetANameFromTheOuterSystemAndStayDrivenInside) {
  const Plan plan = plan_with("{look: inner.look_at}");
  ASSERT_EQ(plan.commands.size(), 4U);
  EXPECT_EQ(plan.commands[3].name, "look");
  EXPECT_EQ(plan.nodes[plan.commands[3].node].name, "inner.head");
  EXPECT_FALSE(plan.commands[3].driver);
  ASSERT_TRUE(plan.commands[0].driver);
  EXPECT_EQ(plan.nodes[plan.commands[0].driver->node].name, "inner.turn");
}

TEST_F(NestedCommands, AreDrivenFromAnotherSystemsModuleOrOnlyOutput) {
  for (const char* from : {"one.head.angle", "one.angle"}) {
    const Plan plan = plan_with(std::string("{look: {to: one.look, from: ") + from + "}}");
    ASSERT_TRUE(plan.commands.at(3).driver) << from;
    EXPECT_EQ(plan.nodes[plan.commands[3].driver->node].name, "one.head");
  }
}

TEST_F(NestedCommands, AreNotDrivenInsideAndOutside) {
  EXPECT_EQ(errors_of("{look: {to: inner.look_at, from: one.angle}}"),
            "graph.yaml:6:44: 'inner.head.rotate_to' is driven already, by the command "
            "'inner.look_at'\n");
}

TEST_F(NestedCommands, AreOnlyThoseThatTheSystemDeclares) {
  EXPECT_EQ(errors_of("{a: inner.look_to, b: silent.look, c: inner.head.rotate_to, d: inner}"),
            "graph.yaml:6:15: the system 'inner' has no command 'look_to'; it has look_at, zoom; "
            "did you mean 'look_at'?\n"
            "graph.yaml:6:33: the system 'silent' has no commands\n"
            "graph.yaml:6:49: the system 'inner' has no command 'head.rotate_to'; it has look_at, "
            "zoom\n"
            "graph.yaml:6:74: the system 'inner' has no command ''; it has look_at, zoom\n");
}

TEST_F(NestedCommands, NeedAModuleWhereADrivingSystemHasSeveralOutputs) {
  EXPECT_EQ(errors_of("{a: {to: one.look, from: inner.angle}}"),
            "graph.yaml:6:36: the system 'inner' has 2 outputs; expected inner.MODULE.COMPONENT\n");
}

TEST_F(NestedCommands, SayNothingMoreOfWhatCouldNotBeRead) {
  folder_.write("inner.yaml",
                "modules: {head: {type: head}}\nnetwork: head\ncommands: {look: head.look}\n");
  folder_.write("one.yaml", "modules: {head: {type: head}}\n");
  const std::string errors = errors_of("{a: inner.look, b: {to: one.look, from: one.angle}}");
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 2) << errors;
  EXPECT_NE(errors.find("'head' (head) has no command 'look'; it has rotate_to"),
            std::string::npos);
  EXPECT_NE(errors.find("a graph needs a network"), std::string::npos);
}

}  // namespace
}  // namespace ilss
