// `ilss check` on a graph full of mistakes: every one on stderr with its place, exit status 2.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

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

}  // namespace
