// Output that cannot be written is never lost in silence.
#include <gtest/gtest.h>

#include "command.h"

namespace ilss {
namespace {

TEST(Output, FullDiskFailsEveryVerb) {
  // Short output fails when it is flushed at the end, long output on the way.
  for (const std::string arguments : {"--help", "check graphs/wall_pose_sonar.yaml",
                                      "modules --json", "run graphs/sonar_ring.yaml --json"}) {
    const Heard heard = call_command(arguments + " > /dev/full");
    EXPECT_EQ(heard.status, 1) << arguments;
    EXPECT_EQ(heard.errors, "ilss: cannot write the output: No space left on device\n")
        << arguments;
  }
}

TEST(Output, ReaderWhoLeavesIsNoError) {
  // With SIGPIPE ignored, the command itself sees that the pipe is closed.
  for (const std::string trap : {"", "trap '' PIPE; "}) {
    const std::filesystem::path errors = test_file("errors");
    const std::string line = "(" + trap + "'" ILSS_COMMAND "' schema 2> '" + errors.string() +
                             "') | head -c 1 > /dev/null";
    ASSERT_EQ(std::system(line.c_str()), 0);
    EXPECT_EQ(text_of(errors), "") << line;
    std::filesystem::remove(errors);
  }
}

TEST(Output, NamesThatAreNoTextStillGiveJson) {
  const std::filesystem::path file = test_file("graph.yaml");
  std::ofstream(file) << "ilss: \"\xff\"\nmodules: {f: {type: expression, quantities: {x: 1}, "
                         "output: {y: {unit: 1, formula: x}}}}\nnetwork: f\n";
  const Heard heard = call_command("check --json " + file.string());
  EXPECT_EQ(heard.status, 0) << heard.errors;
  EXPECT_NE(heard.output.find("\xef\xbf\xbd"), std::string::npos) << heard.output;
  std::filesystem::remove(file);
}

TEST(OutputFile, IsNeverTheGraphThatTheCommandReads) {
  const std::filesystem::path graph = test_file("graph.yaml");
  const std::string text =
      "{ilss: one, modules: {sonar: {type: sonar, range_std: 2 mm, input: {values: [{range: 1 "
      "m}]}}},"
      " network: sonar}\n";
  std::ofstream(graph) << text;
  const std::string path = "'" + graph.string() + "'";
  for (const std::string& call :
       {"graph " + path + " --output " + path, "run " + path + " --picture " + path,
        "run " + path + " --profile " + path}) {
    const Heard heard = call_command(call);
    EXPECT_EQ(heard.status, 2) << call;
    EXPECT_NE(heard.errors.find("is read by this command"), std::string::npos) << heard.errors;
    EXPECT_EQ(text_of(graph), text) << call;
  }
  std::filesystem::remove(graph);
}

}  // namespace
}  // namespace ilss
