// Constants that stand in files of their own, as calibrations do.
#include <gtest/gtest.h>

#include "framework/graph/plan.h"
#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

using test::blamed;
using test::Folder;
using test::output_of;
using test::plan_of;
using test::read_text;

constexpr const char* graph = R"(
constants: {fit: {file: fit.yaml}}
modules:
  a: {type: reading, bias: $fit.offset, mount: {x: $fit.shift}}
  b: {type: reading, bias: $fit.offset}
  s: {type: subtract}
network: {serial: [combine: [a, b], s]}
)";

TEST(ConstantsFile, VectorWithACovarianceIsOneBlockOfPersistentSources) {
  const Folder folder;
  folder.write("fit.yaml", "value: {offset: 1 mm, shift: 2 m}\ncovariance: [[4, 0.5], [0.5, 1]]\n");
  const Plan plan = plan_of(graph, {}, folder.path());
  System system(plan, 1);
  system.evaluate(time_at(0));
  // What the readings share, the offset, is gone; the shift's variance is in m².
  EXPECT_DOUBLE_EQ(output_of(system).value[0], 2);
  EXPECT_NEAR(output_of(system).lineage.variance(0), 1, 1e-12);
  EXPECT_EQ(blamed(plan, output_of(system).lineage), std::vector<std::string>{"fit"});
  for (const Source& source : output_of(system).lineage.sources()) EXPECT_TRUE(source.persistent());
}

TEST(ConstantsFile, ErrorsAreReportedWhereTheyStandInTheFile) {
  const Folder folder;
  const auto errors = [&](const std::string& text) {
    folder.write("fit.yaml", text);
    std::string found = read_text(graph, {}, folder.path()).errors;
    const std::string file = (folder.path() / "fit.yaml").string();
    for (auto at = found.find(file); at != std::string::npos; at = found.find(file))
      found.replace(at, file.size(), "fit.yaml");
    return found;
  };
  EXPECT_EQ(errors("value: {offset: 1 mm, shift: 2 m}\ncovariance: [[4, 3], [3, 1]]\n"),
            "fit.yaml:2:13: a covariance must be positive semidefinite\n");
  EXPECT_TRUE(errors("value:\n  offset: 1 mmm\n  shift: 2 m\n")
                  .starts_with("fit.yaml:2:11: unknown unit 'mmm'\n"));
  EXPECT_EQ(errors("value: {offset: 1 mm, shift: 2 m}\ncovariances: [[4, 3], [3, 1]]\n"),
            "fit.yaml:2:1: a vector constant has value and covariance, not 'covariances'\n");
}

TEST(ConstantsFile, WrongDimensionIsReportedWhereTheConstantIsUsed) {
  const Folder folder;
  folder.write("fit.yaml", "value: {offset: 1 rad, shift: 2 m}\n");
  EXPECT_EQ(read_text(graph, {}, folder.path()).errors,
            "graph.yaml:4:28: 'rad' is not a length (m)\n"
            "graph.yaml:5:28: 'rad' is not a length (m)\n");
}

TEST(ConstantsFile, NameThatNoFileCanHaveIsAnError) {
  const std::string name(5000, 'x');
  const std::string errors = read_text("constants: {fit: {file: " + name + "}}").errors;
  EXPECT_NE(errors.find("graph.yaml:1:25: there is no file '"), std::string::npos) << errors;
}

TEST(ConstantsFile, EmptyFileIsAnError) {
  const Folder folder;
  folder.write("fit.yaml", "");
  EXPECT_NE(read_text(graph, {}, folder.path()).errors, "");
}

}  // namespace
}  // namespace ilss
