// `ilss run --command`, and how the verbs show commands: with a plug-in whose modules follow some.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "command.h"

namespace ilss {
namespace {

using nlohmann::json;

/// A system with a table that commands turn, in a file of the test's.
class RunCommand : public testing::Test {
 protected:
  RunCommand() {
    std::ofstream(graph_) << "ilss: table\n"
                             "modules: {table: {type: turntable}, next: {type: next_angle, step: 1 "
                             "deg}}\n"
                             "network: {serial: [table, next]}\n"
                             "commands:\n"
                             "  look_at: table.rotate_to\n"
                             "  mode: table.mode\n"
                             "  jam: table.jam\n";
  }
  ~RunCommand() override { std::filesystem::remove(graph_); }

  /// The verb on the graph.
  Heard call(const std::string& verb, const std::string& arguments = "") const {
    return call_command("--plugin '" ILSS_TEST_PLUGIN "' " + verb + " '" + graph_.string() + "' " +
                        arguments);
  }
  static std::vector<json> lines_of(const std::string& output) {
    std::vector<json> lines;
    std::istringstream stream(output);
    for (std::string line; std::getline(stream, line);) lines.push_back(json::parse(line));
    return lines;
  }
  void expect_refusal(const std::string& arguments, const std::string& errors) const {
    const Heard heard = call("run", arguments);
    EXPECT_EQ(heard.status, 2) << arguments;
    EXPECT_EQ(heard.output, "") << arguments;
    EXPECT_EQ(heard.errors, errors) << arguments;
  }

  std::filesystem::path graph_ = test_file("graph.yaml");
};

TEST_F(RunCommand, IsFollowedFromItsTimeOnAndShownBeforeItsTick) {
  const Heard heard = call("run", "--ticks 3 --command 'look_at=30 deg@100 ms'");
  EXPECT_EQ(heard.status, 0) << heard.errors;
  EXPECT_EQ(heard.errors, "");
  EXPECT_TRUE(
      heard.output.starts_with("     0     0.000 s  angle 1.000 ± 0.000 deg\n"
                               "           0.100 s  command look_at = 30 deg\n"
                               "     1     0.100 s  angle 31.000 ± 0.000 deg\n"
                               "     2     0.200 s  angle 31.000 ± 0.000 deg\n"))
      << heard.output;
  EXPECT_EQ(heard.output.find("refused"), std::string::npos) << heard.output;
}

TEST_F(RunCommand, ThatIsRefusedIsShownAndCountedAndTheRunGoesOn) {
  const Heard heard = call("run", "--ticks 2 --command 'look_at=91 deg' --command jam=true@0.1s");
  EXPECT_EQ(heard.status, 0) << heard.errors;
  EXPECT_NE(heard.output.find("           0.000 s  command look_at = 91 deg: refused: the table "
                              "turns by at most 90 deg\n"
                              "     0     0.000 s  angle 1.000"),
            std::string::npos)
      << heard.output;
  EXPECT_NE(heard.output.find("0.100 s  command jam = true: internal: the module threw: jammed\n"),
            std::string::npos)
      << heard.output;
  EXPECT_NE(heard.output.find("\n2 ticks\ncommands refused: 2\n"), std::string::npos)
      << heard.output;
}

TEST_F(RunCommand, QuietLeavesTheCount) {
  const Heard heard = call("run", "--ticks 2 --quiet --command 'look_at=91 deg'");
  EXPECT_TRUE(heard.output.starts_with("\n2 ticks\ncommands refused: 1\n")) << heard.output;
}

TEST_F(RunCommand, IsInTheJsonOfItsTickAlone) {
  const Heard heard = call("run",
                           "--ticks 3 --json --command 'look_at=0.5 rad@0.1 s' --command "
                           "'look_at=2 rad@0.1 s' --command 'mode=smooth@0.1 s'");
  const std::vector<json> ticks = lines_of(heard.output);
  ASSERT_EQ(ticks.size(), 3U) << heard.errors;
  EXPECT_FALSE(ticks[0].contains("commands"));
  EXPECT_FALSE(ticks[2].contains("commands"));
  EXPECT_EQ(ticks[1]["commands"], json::parse(R"([
      {"name": "look_at", "value": 0.5, "unit": "rad", "outcome": "done"},
      {"name": "look_at", "value": 2.0, "unit": "rad", "outcome": "refused",
       "fault": {"kind": "refused", "message": "the table turns by at most 90 deg", "module": "table"}},
      {"name": "mode", "value": "smooth", "outcome": "done"}])"));
}

TEST_F(RunCommand, IsCheckedBeforeTheRun) {
  expect_refusal("--command 'look_at=30 mm'",
                 "--command look_at=30 mm: 'mm' is not an angle (rad)\n");
  expect_refusal("--command 'look_ta=30 deg' --command mode=slow",
                 "--command look_ta=30 deg: there is no command 'look_ta'; did you mean "
                 "'look_at'?; the system has look_at, an angle (rad); mode, one of fast, smooth; "
                 "jam, true or false\n"
                 "--command mode=slow: expected one of fast, smooth, got 'slow'\n");
  expect_refusal("--command look_at",
                 "--command look_at: expected NAME=VALUE or NAME=VALUE@TIME, got 'look_at'\n");
}

TEST_F(RunCommand, OfASystemWithoutCommandsIsRefused) {
  const Heard heard = call_command("run graphs/sonar_ring.yaml --command 'look_at=3 deg'");
  EXPECT_EQ(heard.status, 2);
  EXPECT_EQ(heard.errors,
            "--command look_at=3 deg: there is no command 'look_at': the system has no commands\n");
}

TEST_F(RunCommand, ThatTheRunDidNotReachIsSaid) {
  const Heard heard = call("run", "--ticks 2 --json --command mode=fast@0.2s");
  EXPECT_EQ(heard.status, 0);
  EXPECT_EQ(heard.errors, "ilss: the run ended before the time of 1 command\n");
}

TEST_F(RunCommand, DrivesTheTableFromTickToTick) {
  std::ofstream(graph_) << "modules: {table: {type: turntable}, next: {type: next_angle, step: 40 "
                           "deg}}\n"
                           "network: {serial: [table, next]}\n"
                           "commands: {look_at: {to: table.rotate_to, from: next.angle}}\n";
  const Heard heard = call("run", "--ticks 4");
  EXPECT_TRUE(heard.output.starts_with(
      "     0     0.000 s  angle 40.000 ± 0.000 deg\n"
      "           0.100 s  command look_at = 40 deg\n"
      "     1     0.100 s  angle 80.000 ± 0.000 deg\n"
      "           0.200 s  command look_at = 80 deg\n"
      "     2     0.200 s  angle 120.000 ± 0.000 deg\n"
      "           0.300 s  command look_at = 120 deg: refused: the table turns by at most 90 deg\n"
      "     3     0.300 s  angle 120.000 ± 0.000 deg\n"))
      << heard.output;
  const Heard checked = call("check");
  EXPECT_NE(checked.output.find("command: look_at -> table.rotate_to, an angle (rad), driven by "
                                "next.angle\n"),
            std::string::npos)
      << checked.output;
  const json plan = json::parse(call("check", "--json").output);
  EXPECT_EQ(plan["commands"][0]["from"],
            json::parse(R"({"module": "next", "component": "angle"})"));
}

TEST_F(RunCommand, IsListedByCheck) {
  const Heard text = call("check");
  EXPECT_NE(text.output.find("command: look_at -> table.rotate_to, an angle (rad)\n"
                             "command: mode -> table.mode, one of fast, smooth\n"),
            std::string::npos)
      << text.output;
  const json plan = json::parse(call("check", "--json").output);
  EXPECT_EQ(plan["commands"][0],
            json::parse(R"({"name": "look_at", "type": "quantity", "unit": "rad",
                            "documentation": "turns the table to this angle",
                            "module": "table", "command": "rotate_to"})"));
}

TEST_F(RunCommand, IsDeclaredByItsModule) {
  const std::string modules = "--plugin '" ILSS_TEST_PLUGIN "' modules ";
  const Heard text = call_command(modules + "turntable");
  EXPECT_NE(text.output.find("commands\n"
                             "  rotate_to: quantity in rad\n"
                             "      turns the table to this angle\n"
                             "  mode: fast | smooth\n"
                             "      how it moves\n"),
            std::string::npos)
      << text.output;
  const json declared = json::parse(call_command(modules + "turntable --json").output)["commands"];
  ASSERT_EQ(declared.size(), 3U);
  EXPECT_EQ(declared[0], json::parse(R"({"name": "rotate_to", "type": "quantity", "unit": "rad",
                                         "documentation": "turns the table to this angle"})"));
  EXPECT_EQ(declared[1]["choices"], json::parse(R"(["fast", "smooth"])"));
  const Heard page = call_command(modules + "--markdown");
  EXPECT_NE(page.output.find("- command `rotate_to` (quantity in rad): turns the table to this "
                             "angle\n"),
            std::string::npos);
}

}  // namespace
}  // namespace ilss
