// `ilss predict`: Monte Carlo, budgets and degrees of freedom as the command prints them.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "command.h"

namespace ilss {
namespace {

using Json = nlohmann::json;

Json predicted(const std::string& arguments) {
  const Heard heard = call_command("predict " + arguments + " --json");
  EXPECT_EQ(heard.status, 0) << heard.errors;
  return Json::parse(heard.output).at("output");
}

TEST(Predict, MonteCarloStandsBesideTheFirstOrder) {
  const Json output = predicted("graphs/wall_pose_sonar.yaml --monte-carlo 20000 --seed 3");
  const Json& drawn = output.at("monte_carlo");
  EXPECT_EQ(drawn.at("trials"), 20000);
  EXPECT_EQ(drawn.at("faults"), 0);
  for (std::size_t i = 0; i < 4; ++i) {
    const double first = output["components"][i]["std"];
    EXPECT_NEAR(std::sqrt(drawn["covariance"][i][i].get<double>()), first, 0.03 * first);
    EXPECT_LT(drawn["interval_95"][i][0], output["components"][i]["value"]);
    EXPECT_NEAR(drawn["coverage"][i], 0.95, 0.01);
  }
}

TEST(Predict, MonteCarloRepeatsWithItsSeed) {
  const std::string call = "graphs/wall_pose_sonar.yaml --monte-carlo 1000 --seed ";
  EXPECT_EQ(predicted(call + "3"), predicted(call + "3"));
  EXPECT_NE(predicted(call + "3")["monte_carlo"], predicted(call + "4")["monte_carlo"]);
}

// The camera's images are rendered and searched anew in every trial.
TEST(Predict, MonteCarloDrawsTheReadingsOfSimulatedSensors) {
  const Json output = predicted("graphs/wall_pose_vision.yaml --monte-carlo 1500");
  for (const std::size_t i : {1, 3}) {
    const double first = output["components"][i]["std"];
    const double drawn = std::sqrt(output["monte_carlo"]["covariance"][i][i].get<double>());
    EXPECT_NEAR(drawn, first, 0.08 * first);
  }
}

TEST(Predict, TrialsOutOfRangeAreRefused) {
  for (const char* number : {"0", "-1", "10000001", "many"}) {
    const Heard heard =
        call_command(std::string("predict graphs/wall_pose_sonar.yaml --monte-carlo ") + number);
    EXPECT_EQ(heard.status, 2);
    EXPECT_EQ(heard.errors.substr(0, heard.errors.find('\n')),
              std::string("ilss: --monte-carlo: '") + number +
                  "' is not a whole number from 1 to 10000000");
    EXPECT_EQ(heard.output, "");
  }
}

TEST(Predict, BudgetNamesTheLargestBlameFirstAndWhatHalvingItBrings) {
  const Heard heard = call_command("predict tests/data/gum/gauge_block.yaml --budget");
  EXPECT_EQ(heard.status, 0);
  const std::size_t standard = heard.output.find("standard ");
  const std::size_t reading = heard.output.find("reading ");
  ASSERT_NE(standard, std::string::npos) << heard.output;
  EXPECT_LT(standard, reading);
  EXPECT_NE(heard.output.find("62.3 %"), std::string::npos) << heard.output;  // (25 / 31.66)²
  EXPECT_NE(heard.output.find("-27.0 %"), std::string::npos) << heard.output;
}

TEST(Predict, DegreesOfFreedomAreTold) {
  const Json gauge = predicted("tests/data/gum/gauge_block.yaml");
  EXPECT_NEAR(gauge["components"][0]["degrees_of_freedom"], 16.7, 0.1);
  EXPECT_FALSE(
      predicted("graphs/wall_pose_sonar.yaml")["components"][0].contains("degrees_of_freedom"));
}

TEST(Predict, SecondOrderIsInTheJson) {
  const Json gauge = predicted("tests/data/gum/gauge_block.yaml");
  EXPECT_NEAR(gauge["second_order"]["std"][0], 33.8e-9, 0.05e-9);
}

TEST(Predict, ErrorOfZeroIsNeverAllThatIsSaid) {
  const Heard heard = call_command("predict tests/data/gum/comparison_loss.yaml");
  EXPECT_EQ(heard.status, 0);
  EXPECT_NE(heard.output.find("monte_carlo_required: second order 0.000050 ± 0.000050"),
            std::string::npos)
      << heard.output;
}

/// A graph of one formula with this quantity, and the first line that the command says of it.
std::string refused(const std::string& quantity) {
  const std::filesystem::path file = test_file("graph.yaml");
  std::ofstream(file) << "modules: {f: {type: expression, quantities: {x: " << quantity
                      << "}, output: {y: {unit: 1, formula: x}}}}\nnetwork: f\n";
  const Heard heard = call_command("predict " + file.string());
  EXPECT_EQ(heard.status, 2) << quantity << heard.output;
  EXPECT_EQ(heard.output, "") << quantity;
  std::filesystem::remove(file);
  const std::string line = heard.errors.substr(0, heard.errors.find('\n'));
  const std::string place = file.string() + ":1:";
  EXPECT_TRUE(line.starts_with(place)) << line;
  return line.substr(line.find(' ') + 1);
}

TEST(Predict, BadErrorsAreRefusedWhereTheyStand) {
  EXPECT_EQ(refused("{value: 1, std: -1}"), "a std cannot be negative, got '-1'");
  EXPECT_EQ(refused("{value: 1, std: .nan}").substr(0, 6), "'.nan'");
  EXPECT_EQ(refused("{value: nan, std: 1}").substr(0, 5), "'nan'");
  EXPECT_EQ(refused("{value: 1, half_width: 1}"),
            "a half_width needs a distribution that has one: uniform, triangular or arcsine");
  EXPECT_EQ(refused("{value: 1, std: 1, half_width: 1, distribution: uniform}"),
            "give either a std or a half_width, not both");
  EXPECT_EQ(refused("{value: 1, std: 1, distribution: t}"),
            "a t distribution needs degrees_of_freedom above 2, or it has no std");
  EXPECT_EQ(refused("{value: 1, std: 1, distribution: unifrm}"),
            "expected one of normal, uniform, triangular, arcsine, t, or {samples: FILE}, got "
            "'unifrm'; did you mean 'uniform'?");
  EXPECT_EQ(refused("{value: 1, std: 1, degrees_of_freedom: 0}"),
            "expected degrees of freedom, a number from 1 up, got '0'");
  EXPECT_EQ(refused("{value: 1, distribution: uniform}"),
            "a distribution is that of an error; give its std, too");
}

TEST(Predict, DivisionByZeroIsAFaultNotANumber) {
  const std::filesystem::path file = test_file("graph.yaml");
  std::ofstream(file) << "modules: {f: {type: expression, quantities: {x: {value: 0, std: 1}}, "
                         "output: {y: {unit: 1, formula: 1 / x}}}}\nnetwork: f\n";
  const Heard heard = call_command("predict " + file.string() + " --monte-carlo 100");
  EXPECT_EQ(heard.status, 1);
  EXPECT_EQ(heard.output, "");
  EXPECT_NE(heard.errors.find("not_finite"), std::string::npos) << heard.errors;
  std::filesystem::remove(file);
}

TEST(Predict, TutorialsModelIsWhatTheTutorialSays) {
  const Heard heard = call_command("predict docs/examples/speed.yaml --budget");
  EXPECT_EQ(heard.status, 0) << heard.errors;
  EXPECT_NE(text_of(ILSS_SOURCE_DIR "/docs/tutorial.md").find(heard.output), std::string::npos)
      << heard.output;
}

}  // namespace
}  // namespace ilss
