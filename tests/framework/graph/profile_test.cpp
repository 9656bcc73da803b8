// Profiles: written, read again, and applied to a plan.
#include "framework/graph/profile.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace ilss {
namespace {

/// A file of this test alone that holds `text`.
std::filesystem::path file_of(const std::string& name, const std::string& text) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path path = std::filesystem::path(::testing::TempDir()) /
                                     (std::string("ilss_") + test->name() + "_" + name);
  std::ofstream(path) << text;
  return path;
}

std::vector<std::string> problems_of(const std::string& text) {
  const std::filesystem::path path = file_of("problem.yaml", text);
  Diagnostics diagnostics;
  (void)read_profile(path, diagnostics);
  std::vector<std::string> problems;
  for (const Diagnostic& d : diagnostics.sorted())
    problems.push_back(std::to_string(d.position.line) + ":" + std::to_string(d.position.column) +
                       ": " + d.message);
  return problems;
}

TEST(Profile, IsReadAgainAsWrittenWhateverTheNamesAre) {
  Profile profile{.plan = "wall \"pose\""};
  profile.modules = {{"left", {1.234e-6, 3.5e-5}},
                     {"vision.camera", {0.1 + 0.2, 1}},
                     {"null", {0, 0}},
                     {"1e5: {\\", {1.0 / 3, 2.0 / 3}}};
  const std::filesystem::path path =
      std::filesystem::path(::testing::TempDir()) / "ilss_profile.yaml";
  {
    std::ofstream out(path);
    write_profile(profile, out);
  }
  Diagnostics diagnostics;
  const Profile again = read_profile(path, diagnostics);
  for (const Diagnostic& d : diagnostics.sorted()) ADD_FAILURE() << format_diagnostic(d);
  EXPECT_EQ(again.plan, profile.plan);
  ASSERT_EQ(again.modules.size(), profile.modules.size());
  for (std::size_t i = 0; i < profile.modules.size(); ++i) {
    EXPECT_EQ(again.modules[i].module, profile.modules[i].module);
    EXPECT_EQ(again.modules[i].time.typical, profile.modules[i].time.typical);
    EXPECT_EQ(again.modules[i].time.worst, profile.modules[i].time.worst);
  }
}

TEST(Profile, OfNoModulesIsReadAgain) {
  std::ostringstream out;
  write_profile({}, out);
  EXPECT_TRUE(problems_of(out.str()).empty());
}

TEST(Profile, SaysWhatIsWrongWithItsFileAndWhere) {
  EXPECT_EQ(problems_of("[1, 2]"),
            std::vector<std::string>{"1:1: expected a profile: a map with the keys profile and "
                                     "modules, as `ilss run --profile` writes it"});
  EXPECT_EQ(
      problems_of("modules: {a: {typical: 2 s, worst: 1 s}, b: 1 m, c: -1 s}\nprofil: x\n"),
      (std::vector<std::string>{"1:36: the worst time is shorter than the typical one",
                                "1:45: 'm' is not a time (s)", "1:53: a time cannot be negative",
                                "2:1: a profile has no key 'profil'; did you mean 'profile'?"}));
  EXPECT_EQ(problems_of("modules: {a: {typical: 2 s}}"),
            std::vector<std::string>{"1:14: expected a time, or {typical: TIME, worst: TIME}"});
}

TEST(Profile, ReplacesDeclaredTimesAndReportsModulesThatThePlanHasNot) {
  Plan plan;
  plan.name = "pose";
  plan.nodes.resize(2);
  plan.nodes[0].name = "left";
  plan.nodes[0].time = ModuleTime{1, 2};
  plan.nodes[1].name = "right";
  plan.nodes[1].time = ModuleTime{3, 4};
  const Profile profile{.plan = "pose",
                        .modules = {{"left", {5, 6}}, {"rigt", {7, 8}, {nullptr, 4, 3}}}};
  Diagnostics diagnostics;
  apply_profile(profile, plan, diagnostics);
  EXPECT_EQ(plan.nodes[0].time->typical, 5);
  EXPECT_EQ(plan.nodes[0].time->worst, 6);
  EXPECT_EQ(plan.nodes[1].time->typical, 3);
  ASSERT_EQ(diagnostics.size(), 1U);
  EXPECT_EQ(diagnostics.sorted()[0].message, "'pose' has no module 'rigt'; did you mean 'right'?");
  EXPECT_EQ(diagnostics.sorted()[0].position.line, 4);
}

}  // namespace
}  // namespace ilss
