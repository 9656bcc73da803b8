// The command as a shell user has it: what it prints, and how it ends.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace ilss {

/// What came of one call.
struct Heard {
  int status = -1;  ///< exit status; -1 where a signal ended it
  std::string output;
  std::string errors;
};

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// A file of this test in this process alone, so that two builds can be tested at once.
inline std::filesystem::path test_file(const std::string& name) {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  return std::filesystem::path(testing::TempDir()) /
         ("ilss_" + std::to_string(getpid()) + "_" + test->test_suite_name() + "_" + test->name() +
          "_" + name);
}

/// `ilss ARGUMENTS` in the project's root; the arguments may redirect standard output.
inline Heard call_command(const std::string& arguments) {
  const std::filesystem::path output = test_file("output");
  const std::filesystem::path errors = test_file("errors");
  const std::string line = "cd '" ILSS_SOURCE_DIR "' && '" ILSS_COMMAND "' 2> '" + errors.string() +
                           "' > '" + output.string() + "' " + arguments;
  const int status = std::system(line.c_str());
  Heard heard{WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(output), text_of(errors)};
  std::filesystem::remove(output);
  std::filesystem::remove(errors);
  return heard;
}

}  // namespace ilss
