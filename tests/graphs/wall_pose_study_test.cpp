// The wall-pose studies that ship, end to end: through the library and through the command.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>

#include "framework/study/comparison.h"
#include "sensors/register.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;
const std::string graphs = std::string(ILSS_SOURCE_DIR) + "/graphs/";

Study shipped_study(const std::string& name) {
  static const Registry* const registry = [] {
    auto* made = new Registry;
    register_sensors(*made);
    return made;
  }();
  Diagnostics diagnostics;
  auto study = read_study(graphs + name, *registry, diagnostics);
  for (const Diagnostic& diagnostic : diagnostics.sorted())
    ADD_FAILURE() << format_diagnostic(diagnostic);
  return std::move(study.value());
}

struct CommandResult {
  int status;
  std::string output;  ///< of stdout, and of stderr where asked for
};

CommandResult run_command(const std::string& arguments) {
  FILE* pipe = popen((std::string(ILSS_COMMAND) + " " + arguments).c_str(), "r");
  CommandResult result{-1, {}};
  std::array<char, 4096> buffer;
  while (const std::size_t n = fread(buffer.data(), 1, buffer.size(), pipe))
    result.output.append(buffer.data(), n);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) result.status = WEXITSTATUS(status);
  return result;
}

const std::string study_1997 = graphs + "wall_pose_1997.study.yaml";

TEST(WallPose1997, ReproducesTheErrorsOfTable1ToThePapersDigits) {
  // Henderson & Dekhil 1997, table 1: technique - measured, mm and degrees.
  struct Row {
    double range, angle;
  };
  constexpr Row sonar[] = {{-3.4, 0.4},  {9.4, 4.3},  {-6.0, 3.2},  {-15.7, 4.6},
                           {14.5, 14.1}, {0.9, -2.7}, {-5.6, -2.3}, {-18.2, 0.2}};
  constexpr Row vision[] = {{-31, -8.66},  {-39, -8.51}, {-147, 3.99},   {-114, 10.27},
                            {-171, 11.62}, {-80, -2.33}, {-304, -12.53}, {-235, -3.33}};
  const Comparison comparison = compare(shipped_study("wall_pose_1997.study.yaml"));
  ASSERT_EQ(comparison.cases.size(), 8u);
  for (std::size_t pose = 0; pose < 8; ++pose) {
    SCOPED_TRACE("pose " + comparison.cases[pose].name);
    const auto& alternatives = comparison.cases[pose].alternatives;
    EXPECT_NEAR(alternatives[0].measurement.errors[0].bias, sonar[pose].range * 1e-3, 1e-12);
    EXPECT_NEAR(alternatives[0].measurement.errors[1].bias, sonar[pose].angle * degree, 1e-12);
    EXPECT_NEAR(alternatives[1].measurement.errors[0].bias, vision[pose].range * 1e-3, 1e-12);
    EXPECT_NEAR(alternatives[1].measurement.errors[1].bias, vision[pose].angle * degree, 1e-12);
  }
}

TEST(WallPose1997, RmsRangeErrorsAreThoseOfThePapersTable) {
  const Comparison comparison = compare(shipped_study("wall_pose_1997.study.yaml"));
  EXPECT_NEAR(comparison.summary[0].rms[0], 10.9e-3, 0.05e-3);
  EXPECT_NEAR(comparison.summary[1].rms[0], 166e-3, 0.5e-3);
}

TEST(WallPose1997, OnlyVisionsPoseSevenMissesTheRequirementAndByFourMillimetres) {
  const Comparison comparison = compare(shipped_study("wall_pose_1997.study.yaml"));
  for (const ComparedCase& compared : comparison.cases)
    for (std::size_t a = 0; a < 2; ++a)
      EXPECT_EQ(compared.alternatives[a].meets_requirement, compared.name != "7" || a == 0)
          << "pose " << compared.name;
  const CaseAlternative& seven = comparison.cases[6].alternatives[1];
  ASSERT_EQ(seven.misses.size(), 1u);
  EXPECT_EQ(seven.misses[0].component, 0u);
  EXPECT_NEAR(seven.misses[0].error, -0.304, 1e-12);
  EXPECT_NEAR(seven.misses[0].excess(), 0.004, 1e-12);
}

TEST(WallPose1997, CommandPrintsTheTableAndNamesTheMiss) {
  const CommandResult result = run_command("compare " + study_1997);
  EXPECT_EQ(result.status, 0);
  for (const char* text : {"915.6", "-29.66", "10.9", "166", "misses range by 4 mm",
                           "sonar: 8 of 8 poses meet the requirement.",
                           "pose 7 misses it: range is off by 304 mm, 4 mm too much"})
    EXPECT_NE(result.output.find(text), std::string::npos) << text << "\n" << result.output;
}

TEST(WallPose1997, EnforceEndsWithStatusOne) {
  EXPECT_EQ(run_command("compare --enforce " + study_1997 + " >/dev/null").status, 1);
}

TEST(WallPose1997, JsonHoldsTheSameFigures) {
  const CommandResult result = run_command("compare --json " + study_1997);
  ASSERT_EQ(result.status, 0);
  const auto json = nlohmann::json::parse(result.output);
  const auto& seven = json["cases"][6]["alternatives"][1];
  EXPECT_EQ(seven["name"], "vision");
  EXPECT_NEAR(seven["measured"]["components"][0]["error"].get<double>(), -0.304, 1e-12);
  EXPECT_EQ(seven["requirement"]["met"], false);
  EXPECT_NEAR(seven["requirement"]["misses"][0]["excess"].get<double>(), 0.004, 1e-12);
  EXPECT_NEAR(json["summary"][0]["components"][0]["rms_error"].get<double>(), 10.9e-3, 0.05e-3);
  EXPECT_EQ(json["requirement_met"], false);
}

TEST(Compare, StudyFileThatIsWrongEndsWithStatusTwoAndPositions) {
  const std::string path = testing::TempDir() + "ilss_wrong.study.yaml";
  FILE* file = fopen(path.c_str(), "w");
  ASSERT_NE(file, nullptr);
  fputs("study: wrong\npayload: wall_poze\nruns: many\n", file);
  fclose(file);
  const CommandResult result = run_command("compare " + path + " 2>&1");
  EXPECT_EQ(result.status, 2);
  EXPECT_EQ(result.output,
            path + ":2:10: no module gives a payload 'wall_poze'; did you mean 'wall_pose'?\n" +
                path + ":3:7: expected an integer, got 'many'\n");
}

TEST(WallPoseScene, MeasuredErrorsAreThePredictedOnesWhereTheVerdictIsLinear) {
  Study study = shipped_study("wall_pose_scene.study.yaml");
  study.runs = 2000;
  SCOPED_TRACE(study.seed);
  const Comparison comparison = compare(study);
  ASSERT_EQ(comparison.cases.size(), 5u);
  int linear = 0;
  for (const ComparedCase& compared : comparison.cases) {
    ASSERT_FALSE(compared.truth_fault);
    for (std::size_t a = 0; a < study.alternatives.size(); ++a) {
      SCOPED_TRACE(study.alternatives[a] + " at " + compared.name);
      const CaseAlternative& alternative = compared.alternatives[a];
      ASSERT_FALSE(alternative.prediction->fault);
      if (alternative.prediction->verdict->verdict != Verdict::linear_ok) continue;
      ++linear;
      EXPECT_TRUE(alternative.measurement.consistency.consistent(consistency_probability))
          << alternative.measurement.consistency.mean();
      for (std::size_t c = 0; c < 2; ++c) {
        const ComponentErrors& errors = alternative.measurement.errors[c];
        const double predicted = alternative.prediction->standard_deviation[c];
        // The sd of 2,000 runs is known to 1.6 %; five times that.
        EXPECT_NEAR(errors.rms, predicted, 0.08 * predicted);
      }
    }
  }
  EXPECT_EQ(linear, 15) << "poses whose verdict is linear_ok, of all three systems";
}

}  // namespace
}  // namespace ilss
