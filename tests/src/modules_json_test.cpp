// `ilss modules TYPE --json` tells what a program needs to make an input of the module.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "command.h"

namespace ilss {
namespace {

nlohmann::json declared(const std::string& type) {
  const Heard heard = call_command("modules " + type + " --json");
  EXPECT_EQ(heard.status, 0) << heard.errors;
  return nlohmann::json::parse(heard.output);
}

TEST(ModulesJson, GivesDefaultsOfComponentsInSi) {
  const auto components = declared("wedge_sonar_line")["inputs"][0]["payload"]["components"];
  EXPECT_EQ(components[0]["name"], "range");
  EXPECT_FALSE(components[0].contains("default"));
  EXPECT_EQ(components[1]["name"], "beam_half_angle");
  EXPECT_NEAR(components[1]["default"].get<double>(), 11 * std::acos(-1.0) / 180, 1e-15);
}

TEST(ModulesJson, GivesLabelsWithTheirValues) {
  const auto output = declared("wedge_sonar_line")["output"];
  EXPECT_EQ(output["labels"]["contact"][5], "(0,0)");
  EXPECT_FALSE(declared("wall_pose")["output"].contains("labels"));
}

TEST(ModulesJson, GivesFramesOrTheInputWhoseFrameItIs) {
  const auto wedge = declared("wedge_sonar_line");
  EXPECT_EQ(wedge["inputs"][1]["frame"], "robot");
  EXPECT_EQ(wedge["output"]["frame_of_input"], "left");
  const auto pose = declared("wall_pose");
  EXPECT_EQ(pose["output"]["frame"], "robot");
  EXPECT_FALSE(pose["output"].contains("frame_of_input"));
}

}  // namespace
}  // namespace ilss
