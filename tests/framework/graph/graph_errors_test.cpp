// Golden files of what `check` says: each graph in tests/data/graph_errors has its messages beside
// it in a file .expected, a line each, without the folder.
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

const std::filesystem::path folder = std::filesystem::path(ILSS_TEST_DATA) / "graph_errors";

std::string without_folder(std::string text) {
  const std::string prefix = folder.string() + "/";
  for (std::size_t at = text.find(prefix); at != std::string::npos; at = text.find(prefix, at))
    text.erase(at, prefix.size());
  return text;
}

std::string messages_of(const std::string& graph) {
  Diagnostics diagnostics;
  EXPECT_FALSE(read_plan(folder / graph, test::registry(), {}, diagnostics));
  return without_folder(test::messages(diagnostics));
}

std::string expected_of(const std::string& graph) {
  std::ifstream stream(folder / (graph + ".expected"));
  EXPECT_TRUE(stream.good()) << graph;
  return {std::istreambuf_iterator<char>(stream), {}};
}

class GraphErrors : public testing::TestWithParam<const char*> {};

TEST_P(GraphErrors, AreAllReportedWithTheirPlaces) {
  EXPECT_EQ(messages_of(GetParam()), expected_of(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Files, GraphErrors,
                         testing::Values("many.yaml", "unsound_parts.yaml", "operators.yaml",
                                         "constants.yaml", "structure.yaml", "commands.yaml"));

TEST(GraphErrors, OfManyKindsStandInOneReport) {
  std::istringstream lines(messages_of("many.yaml"));
  std::set<std::string> places;
  for (std::string line; std::getline(lines, line);) places.insert(line.substr(0, line.find(": ")));
  EXPECT_GE(places.size(), 19u);
}

}  // namespace
}  // namespace ilss
