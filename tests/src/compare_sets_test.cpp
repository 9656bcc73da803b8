// `ilss compare` on a study of sets: tables, JSON, seeds, and what it says of bad studies.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "command.h"

namespace ilss {
namespace {

/// A small study of simulated scans, of which `judge` can be given.
std::string study_text(const std::string& judge) {
  const auto graph = [](const std::string& modules, const std::string& network) {
    return "{graph: {constants: {sigma: 5 mm}, modules: {" + modules + "}, network: " + network +
           "}}\n";
  };
  return "study: scans\npayload: range_features\njudge: " + judge +
         "\ntruth: " + graph("room: {type: laser_scene_features}", "room") +
         "alternatives:\n  exact: " + graph("room: {type: laser_scene_features}", "room") +
         "  segments: " +
         graph(
             "room: {type: laser_scene, range_std: $sigma}, b: {type: breakpoints}, s: {type: "
             "split_and_merge}, f: {type: laser_features}",
             "{serial: [room, b, s, f]}") +
         "cases: [{name: near, sigma: 5 mm}]\nruns: 5\n";
}

class CompareSets : public testing::Test {
 protected:
  void write(const std::string& judge) const { std::ofstream(file_) << study_text(judge); }
  Heard compare(const std::string& arguments = "") const {
    return call_command("compare '" + file_.string() + "' " + arguments);
  }
  nlohmann::json compare_json(const std::string& arguments = "") const {
    const Heard heard = compare("--json " + arguments);
    EXPECT_EQ(heard.status, 0) << heard.errors;
    return nlohmann::json::parse(heard.output);
  }
  void TearDown() override { std::filesystem::remove(file_); }

  std::filesystem::path file_ = test_file("study.yaml");
};

const std::string judge =
    "{line_segment: [rho, phi], corner: {components: [x, z], only: {kind: "
    "real}}}";

TEST_F(CompareSets, PrintsATableForEachPayloadOfElementsWithARowForEachAlternative) {
  write(judge);
  const Heard heard = compare();
  EXPECT_EQ(heard.status, 0) << heard.errors;
  const auto holds = [&](const std::string& text) {
    return heard.output.find(text) != std::string::npos;
  };
  EXPECT_TRUE(holds("measured: 5 ticks a case, seed 1")) << heard.output;
  EXPECT_TRUE(holds("true line_segment (matched where readings overlap by 0.7)"));
  EXPECT_TRUE(holds("true corner, kind real (matched within 100 mm)"));
  EXPECT_TRUE(holds("rho in mm"));
  EXPECT_TRUE(holds("phi in deg"));
  EXPECT_FALSE(holds("tolerated")) << "nothing is";
}

TEST_F(CompareSets, TruthFindsAllOfItselfWithoutAnyError) {
  write(judge);
  const nlohmann::json lines = compare_json()["cases"][0]["alternatives"][0]["elements"][0];
  EXPECT_EQ(lines["type"], "line_segment");
  EXPECT_GT(lines["true"], 10);
  EXPECT_EQ(lines["matched"], lines["true"]);
  EXPECT_EQ(lines["true_positive"], 1);
  EXPECT_EQ(lines["false_positive"], 0);
  for (const auto& component : lines["components"]) EXPECT_EQ(component["std"], 0);
  EXPECT_TRUE(lines["consistency"].is_null()) << "no error is stated";
}

TEST_F(CompareSets, JsonGivesErrorsAndConsistencyInSi) {
  write(judge);
  const nlohmann::json json = compare_json("--runs 20");
  EXPECT_EQ(json["kind"], "sets");
  EXPECT_EQ(json["runs"], 20);
  const nlohmann::json& alternative = json["cases"][0]["alternatives"][1];
  EXPECT_GT(alternative["time"]["median_s"], 0);
  const nlohmann::json& lines = alternative["elements"][0];
  EXPECT_GT(lines["true_positive"], 0.8);
  EXPECT_EQ(lines["components"][0]["name"], "rho");
  EXPECT_LT(lines["components"][0]["median_error"], 0.01);
  EXPECT_GT(lines["consistency"]["coverage_95"], 0.8);
  EXPECT_LT(lines["consistency"]["nees_bounds_99"][0], 2);
}

TEST_F(CompareSets, SeedChoosesTheRoomsAndTheSameSeedGivesTheSameScores) {
  write(judge);
  const auto scores = [&](const std::string& arguments) {
    const nlohmann::json json = compare_json(arguments);
    return std::pair(json["seed"], json["cases"][0]["alternatives"][1]["elements"]);
  };
  const auto first = scores("--seed 7");
  EXPECT_EQ(first.first, 7);
  EXPECT_EQ(first.second, scores("--seed 7").second);
  EXPECT_NE(first.second, scores("--seed 8").second);
}

TEST_F(CompareSets, UnknownComponentIsBadInputWithItsPlaceAndTheNearestName) {
  write("{line_segment: [rho, fi], corner: [x, y]}");
  const Heard heard = compare();
  EXPECT_EQ(heard.status, 2);
  EXPECT_EQ(heard.output, "");
  EXPECT_EQ(heard.errors, file_.string() + ":3:29: line_segment has no component 'fi'\n" +
                              file_.string() + ":3:46: corner has no component 'y'\n");
}

TEST_F(CompareSets, EnforceNeedsARequirementWhichSetsHaveNone) {
  write(judge);
  const Heard heard = compare("--enforce");
  EXPECT_EQ(heard.status, 2);
  EXPECT_NE(heard.errors.find("states no requirement"), std::string::npos) << heard.errors;
}

TEST(CompareLaserSegmenters, StudyThatShipsFindsMostWithTheTrueSegments) {
  const Heard heard =
      call_command("compare graphs/laser_segmenters.study.yaml --runs 10 --seed 3 --json");
  ASSERT_EQ(heard.status, 0) << heard.errors;
  const auto json = nlohmann::json::parse(heard.output);
  ASSERT_EQ(json["cases"].size(), 2u);
  const auto& best = json["cases"][0]["alternatives"][0];
  EXPECT_EQ(best["name"], "true_segments");
  EXPECT_GT(best["elements"][0]["true_positive"], 0.95);
  EXPECT_GT(best["elements"][1]["true_positive"], 0.9);
  EXPECT_EQ(best["elements"][0]["components"][0]["std_over_reference"], 1);
}

}  // namespace
}  // namespace ilss
