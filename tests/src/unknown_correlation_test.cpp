// Estimates of unknown correlation, as users hear of them.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "command.h"

namespace ilss {
namespace {

const std::string graph = "tests/data/unknown_correlation.yaml";
const std::string of_again =
    "'again' takes its ticks for independent, but 'all' holds earlier errors of 'sonar' in each";
const std::string of_fused =
    "inputs of 'fused' are of unknown correlation: 'all' and 'latest' both hold errors of "
    "'sonar'";

TEST(UnknownCorrelation, CheckNotesWhereSuchEstimatesMeet) {
  const Heard heard = call_command("check " + graph);
  EXPECT_EQ(heard.status, 0);
  EXPECT_NE(heard.output.find("note: " + of_again + "\nnote: " + of_fused + "\n"),
            std::string::npos)
      << heard.output;
}

TEST(UnknownCorrelation, CheckListsThemInJson) {
  const Heard heard = call_command("check --json " + graph);
  ASSERT_EQ(heard.status, 0);
  EXPECT_EQ(nlohmann::json::parse(heard.output)["unknown_correlations"],
            nlohmann::json({of_again, of_fused}));
}

TEST(UnknownCorrelation, CheckHasNoneToNoteOfAGraphWithoutMemory) {
  const Heard text = call_command("check graphs/wall_pose_fused.yaml");
  EXPECT_EQ(text.output.find("note:"), std::string::npos);
  const Heard json = call_command("check --json graphs/wall_pose_fused.yaml");
  EXPECT_EQ(nlohmann::json::parse(json.output)["unknown_correlations"], nlohmann::json::array());
}

TEST(UnknownCorrelation, EstimatesSaySo) {
  const Heard text = call_command("predict " + graph);
  EXPECT_NE(text.output.find("  correlation  with other estimates unknown\n"), std::string::npos)
      << text.output;
  const Heard json = call_command("predict --json " + graph);
  ASSERT_EQ(json.status, 0);
  EXPECT_EQ(nlohmann::json::parse(json.output)["output"]["correlation"], "unknown");
}

TEST(UnknownCorrelation, EstimatesOfKnownCorrelationSayNothing) {
  const Heard text = call_command("predict graphs/wall_pose_fused.yaml");
  EXPECT_EQ(text.output.find("unknown"), std::string::npos) << text.output;
  const Heard json = call_command("predict --json graphs/wall_pose_fused.yaml");
  EXPECT_FALSE(nlohmann::json::parse(json.output)["output"].contains("correlation"));
}

}  // namespace
}  // namespace ilss
