// Plans as DOT.
#include "framework/graph/dot.h"

#include <gtest/gtest.h>

#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

constexpr const char* graph = R"(
ilss: two "arms"
modules: {a: {type: reading, frame: here}, c: {type: carry}, s: {type: total}}
network: {serial: [a, combine: {of: [c], max_age: 20 ms}, s]}
)";

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Dot, NamesModulesTypesPayloadsFramesAndOutputs) {
  const std::string dot = to_dot(test::plan_of(graph));
  EXPECT_TRUE(dot.starts_with("digraph \"two \\\"arms\\\"\" {")) << dot;
  EXPECT_TRUE(contains(dot, "n0 [label=<<b>a</b><br/><font point-size=\"10\">reading</font>>"));
  EXPECT_TRUE(contains(dot, "n0 -> n1 [label=<scalar<br/><font color=\"#777777\">in here</font>>"));
  EXPECT_TRUE(contains(dot, "at most 0.02 s old")) << dot;
  EXPECT_TRUE(contains(dot, "n2 -> output0")) << dot;
}

TEST(Dot, IsTheSameForTheSamePlan) {
  EXPECT_EQ(to_dot(test::plan_of(graph)), to_dot(test::plan_of(graph)));
}

TEST(Dot, PutsNestedSystemsInFrames) {
  const test::Folder folder;
  folder.write("arm.yaml",
               "modules: {r: {type: reading}, f: {type: sine}}\n"
               "network: {serial: [r, f]}\n");
  const std::string dot = to_dot(test::plan_of(
      "modules: {left: {type: {ilss: arm.yaml}}, g: {type: sine}}\nnetwork: {serial: [left, g]}\n",
      {}, folder.path()));
  EXPECT_TRUE(contains(dot, "subgraph \"cluster.left\" {\n    label=\"left\";")) << dot;
  EXPECT_TRUE(contains(dot, "<b>r</b>"));
  EXPECT_FALSE(contains(dot, "left.r"));
}

}  // namespace
}  // namespace ilss
