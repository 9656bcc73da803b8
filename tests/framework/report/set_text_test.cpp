// What the command shows of sets of features, and of samples.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "tests/src/command.h"

namespace ilss {
namespace {

using Json = nlohmann::json;

const std::string lines = "graphs/lep_lines.yaml ";

/// A graph of a whole scan that is its own output.
std::filesystem::path scan_graph() {
  std::filesystem::path graph = test_file("graph.yaml");
  std::ofstream(graph) << R"(ilss: scan
modules:
  lep: {type: lep_sensor, scene: )" ILSS_SOURCE_DIR R"(/graphs/scenes/convex_edge.yaml}
  ranging: {type: lep_ranging}
network: {serial: [lep, ranging]}
)";
  return graph;
}

TEST(SetText, ElementsStandBelowTheirTick) {
  const Heard heard = call_command("run " + lines + "--ticks 1");
  ASSERT_EQ(heard.status, 0) << heard.errors;
  EXPECT_TRUE(std::regex_search(
      heard.output,
      std::regex("^     0     0.000 s  segments 2\n"
                 " +line_segment  rho 10[0-9.]+ ± [0-9.]+ mm  phi [0-9.]+ ± [0-9.]+ deg  .*"
                 "  readings [0-9]+  first_reading [0-9]+  last_reading [0-9]+  state ended\n"
                 " +line_segment  .*\n"
                 " +corner        x .* ± .* mm  z .* ± .* mm  kind real\n")))
      << heard.output;
}

TEST(SetText, SummaryCountsElementsAndStatesTheirErrorsByType) {
  const Heard heard = call_command("run " + lines + "--ticks 3 --quiet");
  ASSERT_EQ(heard.status, 0) << heard.errors;
  EXPECT_TRUE(std::regex_search(
      heard.output,
      std::regex("\nlines                       3  - +-\n"
                 "  line_segment              6 +2 a tick: rho [0-9.]+ mm, phi [0-9.]+ deg, "
                 "start_x [0-9.]+ mm, start_z [0-9.]+ mm, end_x [0-9.]+ mm, end_z [0-9.]+ mm\n"
                 "  corner                    3 +1 a tick: x [0-9.]+ mm, z [0-9.]+ mm\n")))
      << heard.output;
}

// A narrow gate breaks the edge to about twenty pieces.
TEST(SetText, MoreThanTwelveElementsAreCounted) {
  const Heard heard = call_command("run graphs/lep_lines_ekf.yaml --ticks 1 --set lines.gate=2");
  const auto begin = heard.output.find('\n') + 1;
  const std::string elements = heard.output.substr(begin, heard.output.find("\n\n") - begin + 1);
  const std::string head = "     0     0.000 s  segments ";
  ASSERT_TRUE(heard.output.starts_with(head)) << heard.output;
  const int count = std::stoi(heard.output.substr(head.size()));
  ASSERT_GT(count, 12);
  EXPECT_EQ(std::count(elements.begin(), elements.end(), '\n'), 13) << elements;
  const std::string more = std::to_string(count - 12);
  EXPECT_TRUE(elements.ends_with("... and " + more + " more: " + more + " line_segment\n"))
      << elements;
}

// A gate of no width breaks the scan to pieces of two or three readings.
TEST(SetText, OfALargeSetOnlyTheNumberOfEachTypeIsShown) {
  const Heard heard = call_command(
      "run graphs/lep_lines_ekf.yaml --ticks 1 --set lines.gate=0.01 --set lines.batch_readings=3");
  ASSERT_EQ(heard.status, 0) << heard.errors;
  EXPECT_TRUE(std::regex_search(
      heard.output, std::regex("^     0     0.000 s  segments ([0-9]+)\n +\\1 line_segment\n\n")))
      << heard.output;
}

TEST(SetText, SamplesAreCountedAndExactComponentsHaveNoError) {
  const std::filesystem::path graph = scan_graph();
  const Heard heard = call_command("run '" + graph.string() + "' --ticks 1");
  const Heard predicted = call_command("predict '" + graph.string() + "'");
  std::filesystem::remove(graph);
  EXPECT_TRUE(heard.output.starts_with("     0     0.000 s  256 readings  mount_x 0 mm  "))
      << heard.output;
  EXPECT_NE(predicted.output.find("\n  samples      256 readings\n"), std::string::npos)
      << predicted.output;
}

TEST(SetText, PredictionShowsEachElementWithItsBudget) {
  const Heard heard = call_command("predict " + lines);
  ASSERT_EQ(heard.status, 0) << heard.errors;
  EXPECT_TRUE(std::regex_search(
      heard.output, std::regex("^lines: range_features in frame lep, linear_ok\n"
                               "  segments     2\n"
                               "  elements     2 line_segment, 1 corner\n"
                               "\n"
                               "lines 1: line_segment in frame lep\n"
                               "  rho          [^]*"
                               "\n  readings     [0-9]+\n[^]*\n  state        ended\n[^]*"
                               "\nlines 3: corner in frame lep\n[^]*"
                               "share of the variance\n  source  kind                x          z\n"
                               "  lines   random [^]*\n  lep     systematic ")))
      << heard.output;
}

TEST(SetJson, ACountWithoutErrorHasNoSecondOrder) {
  const Heard heard = call_command("run " + lines + "--ticks 1 --json");
  const Json output = Json::parse(heard.output).at("output");
  EXPECT_EQ(output.at("verdict"), "linear_ok");
  EXPECT_FALSE(output.contains("second_order"));
  EXPECT_EQ(output.at("features").size(), 3);
}

}  // namespace
}  // namespace ilss
