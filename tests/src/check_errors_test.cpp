// `ilss check` on a graph full of mistakes: every one on stderr with its place, exit status 2.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/src/command.h"

namespace ilss {
namespace {

TEST(CheckCommand, ReportsEveryMistakeInOneGoAndExitsWith2) {
  const std::filesystem::path folder = std::filesystem::path(ILSS_TEST_DATA) / "graph_errors";
  const std::filesystem::path heard =
      std::filesystem::path(testing::TempDir()) / "ilss_check_errors";
  const std::string command = "cd '" + folder.string() +
                              "' && '" ILSS_COMMAND "' check command/wall_pose_mistakes.yaml 2> '" +
                              heard.string() + "'";
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 2);
  EXPECT_EQ(text_of(heard), text_of(folder / "command/wall_pose_mistakes.yaml.expected"));
  std::filesystem::remove(heard);
}

// A graph from before scans carried their mount.
TEST(CheckCommand, SaysWhereALasersMountStands) {
  const auto graph = test_file("graph.yaml");
  std::ofstream(graph) << R"(modules:
  laser: {type: laser_scene}
  breaks: {type: breakpoints}
  features: {type: laser_features, mount: {x: 1 m}}
network: {serial: [laser, breaks, features]}
)";
  const Heard heard = call_command("check '" + graph.string() + "'");
  std::filesystem::remove(graph);
  EXPECT_EQ(heard.status, 2);
  EXPECT_EQ(heard.errors, graph.string() +
                              ":4:36: laser_features has no parameter 'mount': a scan carries it: "
                              "give it where the scan comes from (laser_log, laser_scene, "
                              "laser_scene_segments)\n");
}

}  // namespace
}  // namespace ilss
