// The generated module reference says what the modules of this build declare.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

namespace {

std::string read_file(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The standard output of a shell command; fails the test where its exit status is not 0.
std::string output_of(const std::string& command) {
  std::string output;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) {
    ADD_FAILURE() << "cannot start " << command;
    return output;
  }
  std::array<char, 4096> buffer{};
  while (const std::size_t read = std::fread(buffer.data(), 1, buffer.size(), pipe))
    output.append(buffer.data(), read);
  const int status = pclose(pipe);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << command;
  return output;
}

TEST(ModuleReference, IsWhatTheModulesDeclare) {
  const std::string page = read_file(ILSS_SOURCE_DIR "/docs/modules.md");
  std::string declared = output_of("'" ILSS_COMMAND "' modules --markdown");
  ASSERT_FALSE(declared.empty());
  // The shell takes the blank lines off the end.
  declared.erase(declared.find_last_not_of('\n') + 1);
  const std::size_t heading_end = page.find("\n\n");
  ASSERT_NE(heading_end, std::string::npos) << "docs/modules.md has no heading";
  EXPECT_EQ(page.substr(heading_end + 2), declared + "\n")
      << "docs/modules.md is out of date: run\n  scripts/generate_module_reference " ILSS_COMMAND;
}

}  // namespace
