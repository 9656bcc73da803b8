// UDUNITS-2's database takes longer to read than a graph: it is read where it is needed.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "command.h"

namespace ilss {
namespace {

/// The command where there is no database.
Heard call_without_database(const std::string& arguments) {
  setenv("UDUNITS2_XML_PATH", "/no/such/file.xml", 1);
  return call_command(arguments);
}

TEST(UnitDatabase, IsNotReadForTheUnitsOfAnyShippedGraph) {
  int graphs = 0;
  for (const auto& file : std::filesystem::directory_iterator(ILSS_SOURCE_DIR "/graphs")) {
    const std::string name = file.path().filename().string();
    if (!name.ends_with(".yaml") || name.ends_with(".study.yaml")) continue;
    const Heard heard = call_without_database("check graphs/" + name);
    EXPECT_EQ(heard.status, 0) << heard.errors;
    ++graphs;
  }
  EXPECT_GT(graphs, 8);
}

TEST(UnitDatabase, IsReadForOtherUnits) {
  const std::string call = "check graphs/wall_pose_sonar.yaml --set 'constants.robot_x=-4 feet'";
  EXPECT_EQ(call_command(call).status, 0);
  const Heard heard = call_without_database(call);
  EXPECT_EQ(heard.status, 2);
  EXPECT_NE(heard.errors.find("the UDUNITS-2 unit database cannot be read"), std::string::npos)
      << heard.errors;
}

}  // namespace
}  // namespace ilss
