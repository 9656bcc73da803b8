// `ilss run --features`: what stands in the file, whether it comes back, and when there is none;
// and what a run says of lines that it left out.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "command.h"

namespace ilss {
namespace {

using Json = nlohmann::json;

const std::string laser_graph = R"(ilss: laser_lines
modules:
  laser:
    type: laser_log
    file: )" ILSS_SOURCE_DIR R"(/graphs/data/intel_excerpt.log.gz
    range_std: 10 mm
    quantum: 10 mm
    no_return: 40 m
    mount: {x: {value: 0.1 m, std: 5 mm}}
  breaks: {type: breakpoints}
  pieces: {type: maximum_likelihood}
  features: {type: laser_features, virtual_reach: 1 m}
network: {serial: [laser, breaks, pieces, features]}
)";

std::filesystem::path graph_file(const std::string& name, const std::string& text) {
  const auto path = test_file(name);
  std::ofstream(path) << text;
  return path;
}

std::string log_graph(const std::filesystem::path& file, const std::string& frame) {
  return "ilss: replay\nmodules:\n  features: {type: feature_log, file: " + file.string() +
         ", frame: " + frame + "}\nnetwork: {serial: [features]}\n";
}

/// The sets that a run prints.
std::vector<Json> sets_of(const std::string& output) {
  std::vector<Json> sets;
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    const Json tick = Json::parse(line);
    if (!tick["output"].is_null()) sets.push_back(tick["output"]);
  }
  return sets;
}

/// Elements of equal place in two sets have equal types, labels, values and covariances.
void expect_same(const Json& before, const Json& after, std::map<std::string, int>& seen) {
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t e = 0; e < before.size(); ++e) {
    const Json& a = before[e];
    const Json& b = after[e];
    ++seen[a["type"]];
    EXPECT_EQ(a["type"], b["type"]);
    EXPECT_EQ(a["frame"], b["frame"]);
    EXPECT_EQ(a.contains("labels") ? a["labels"] : Json(),
              b.contains("labels") ? b["labels"] : Json());
    EXPECT_EQ(b["correlation"], "unknown");
    const std::size_t n = a["components"].size();
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_EQ(a["components"][i]["value"], b["components"][i]["value"]);
      for (std::size_t j = 0; j < n; ++j) {
        const double deviations =
            a["components"][i]["std"].get<double>() * a["components"][j]["std"].get<double>();
        EXPECT_NEAR(b["covariance"][i][j].get<double>(), a["covariance"][i][j].get<double>(),
                    1e-9 * deviations);
      }
    }
  }
}

/// Writes the features of a run in a format, reads them back and holds them against each other;
/// how many there were of each type.
std::map<std::string, int> round_trip(const std::string& graph, const std::string& frame,
                                      const std::string& format, int ticks) {
  const auto file = test_file("features" + format);
  const std::string options = " --seed 5 --ticks " + std::to_string(ticks) + " --json";
  const Heard written =
      call_command("run '" + graph + "'" + options + " --features '" + file.string() + "'");
  EXPECT_EQ(written.status, 0) << written.errors;
  const auto replay = graph_file("replay.yaml", log_graph(file, frame));
  const Heard read = call_command("run '" + replay.string() + "'" + options);
  EXPECT_EQ(read.status, 0) << read.errors;
  std::filesystem::remove(file);
  std::filesystem::remove(replay);
  const std::vector<Json> before = sets_of(written.output);
  const std::vector<Json> after = sets_of(read.output);
  EXPECT_EQ(before.size(), after.size());
  std::map<std::string, int> seen;
  for (std::size_t i = 0; i < std::min(before.size(), after.size()); ++i) {
    EXPECT_EQ(before[i]["components"][0]["value"], after[i]["components"][0]["value"]);
    expect_same(before[i]["features"], after[i]["features"], seen);
  }
  return seen;
}

TEST(FeatureFile, OfALaserComesBackWithValuesAndCovariances) {
  const auto graph = graph_file("graph.yaml", laser_graph);
  for (const std::string format : {".csv", ".json"}) {
    SCOPED_TRACE(format);
    const auto seen = round_trip(graph.string(), "robot", format, 20);
    for (const char* type : {"line_segment", "corner", "edge"}) EXPECT_GT(seen.at(type), 5) << type;
  }
  std::filesystem::remove(graph);
}

TEST(FeatureFile, OfALepSensorComesBackWithValuesAndCovariances) {
  for (const std::string format : {".csv", ".json"}) {
    SCOPED_TRACE(format);
    EXPECT_GT(round_trip("graphs/lep_lines.yaml", "lep", format, 10).at("line_segment"), 10);
  }
}

/// Scans of a generated room, in the world by a pose that is measured at every tick.
const std::string world_graph = R"(ilss: laser_world
modules:
  laser: {type: laser_scene}
  breaks: {type: breakpoints}
  pieces: {type: iterative_end_point_fit}
  features: {type: laser_features}
  beacon:
    type: sonar
    range_std: 20 mm
    no_echo: 5 m
    input: {values: [{range: 1.01 m}, {range: 1.02 m}, {range: 0.99 m}]}
  pose:
    type: expression
    payload: planar_pose
    frame: world
    inputs: [beacon]
    quantities: {compass: {value: 5 deg, std: 1 deg}, track: {value: 0 m, std: 10 mm}}
    output:
      x: {unit: m, formula: beacon.range}
      z: {unit: m, formula: track}
      heading: {unit: rad, formula: compass, circular: true}
  world: {type: features_transform, mount: {x: {value: 0.1 m, std: 5 mm}}, pose: input}
network:
  serial:
    - combine: [{serial: [laser, breaks, pieces, features]}, {serial: [beacon, pose]}]
    - world
)";

TEST(FeatureFile, OfFeaturesInTheWorldHoldsThePosesErrors) {
  const auto graph = graph_file("graph.yaml", world_graph);
  for (const std::string format : {".csv", ".json"}) {
    SCOPED_TRACE(format);
    EXPECT_GT(round_trip(graph.string(), "world", format, 3).at("line_segment"), 5);
  }
  const Heard heard = call_command("run '" + graph.string() + "' --ticks 1 --json");
  std::filesystem::remove(graph);
  const Json line = sets_of(heard.output).at(0)["features"][0];
  std::map<std::string, std::string> kinds;
  for (const Json& share : line["budget"]) kinds[share["source"]] = share["kind"];
  EXPECT_EQ(kinds["beacon"], "random");
  EXPECT_EQ(kinds["features"], "random");
  EXPECT_EQ(kinds["pose.quantities.compass"], "systematic");
  EXPECT_EQ(kinds["world.mount.x"], "systematic");
}

TEST(FeatureFile, WhatJsonPrintsIsReadToo) {
  const auto graph = graph_file("graph.yaml", laser_graph);
  const auto file = test_file("printed.json");
  const Heard written = call_command("run '" + graph.string() + "' --ticks 3 --json");
  std::ofstream(file) << written.output;
  const auto replay = graph_file("replay.yaml", log_graph(file, "robot"));
  const Heard read = call_command("run '" + replay.string() + "' --json");
  std::map<std::string, int> seen;
  const auto before = sets_of(written.output);
  const auto after = sets_of(read.output);
  ASSERT_EQ(after.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i)
    expect_same(before[i]["features"], after[i]["features"], seen);
  EXPECT_GT(seen.at("line_segment"), 5);
  for (const auto& path : {graph, file, replay}) std::filesystem::remove(path);
}

TEST(FeatureFile, CsvHasARowAnElementUnderOneHeaderForAllTypes) {
  const auto graph = graph_file("graph.yaml", laser_graph);
  const auto file = test_file("features.csv");
  const Heard heard = call_command("run '" + graph.string() + "' --ticks 3 --json --features '" +
                                   file.string() + "'");
  ASSERT_EQ(heard.status, 0) << heard.errors;
  std::istringstream text(text_of(file));
  std::string header;
  std::getline(text, header);
  EXPECT_TRUE(
      header.starts_with("tick,time,acquired,frame,type,state,kind,rho,phi,start_x,start_z,"
                         "end_x,end_z,readings,first_reading,last_reading,centre_x,"
                         "centre_z,radius,x,z,covariance.rho.rho,covariance.rho.phi,"))
      << header;
  const auto commas = std::count(header.begin(), header.end(), ',');
  std::size_t elements = 0;
  for (const Json& set : sets_of(heard.output)) elements += set["features"].size();
  std::size_t rows = 0;
  for (std::string row; std::getline(text, row); ++rows)
    EXPECT_EQ(std::count(row.begin(), row.end(), ','), commas);
  EXPECT_EQ(rows, elements);
  for (const auto& path : {graph, file}) std::filesystem::remove(path);
}

TEST(FeatureFile, JsonIsOneArrayOfTicks) {
  const auto file = test_file("features.json");
  ASSERT_EQ(
      call_command("run graphs/lep_lines.yaml --ticks 2 --quiet --features '" + file.string() + "'")
          .status,
      0);
  const Json ticks = Json::parse(text_of(file));
  std::filesystem::remove(file);
  ASSERT_EQ(ticks.size(), 2U);
  EXPECT_EQ(ticks[1]["tick"], 1);
  EXPECT_DOUBLE_EQ(ticks[1]["time"], 0.1);
  EXPECT_TRUE(ticks[1]["acquired"].is_number());
  EXPECT_EQ(ticks[1]["output"]["features"][0]["type"], "line_segment");
}

TEST(FeatureFile, IsLeftAsItIsWhereThereIsNothingToWrite) {
  const auto file = test_file("features.csv");
  std::ofstream(file) << "precious";
  const auto message = [&](const std::string& arguments) {
    const Heard heard = call_command("run " + arguments);
    EXPECT_EQ(heard.status, 2);
    EXPECT_EQ(text_of(file), "precious");
    return heard.errors;
  };
  const std::string option = " --ticks 1 --features '" + file.string() + "'";
  EXPECT_EQ(message("graphs/laser_wall.yaml" + option),
            "ilss: --features: the graph gives wall_pose, which is no set of features\n");
  EXPECT_EQ(message("graphs/sonar_ring.yaml" + option),
            "ilss: --features: the graph gives 24 outputs; expected one, a set of features\n");
  EXPECT_EQ(message("graphs/lep_lines.yaml --features /tmp/features.txt"),
            "ilss: --features: '/tmp/features.txt' ends neither in .csv nor in .json, so its "
            "format is unknown\n");
  EXPECT_NE(message("graphs/lep_lines.yaml --features /no/such/folder/x.csv").find("cannot write"),
            std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(file.string() + ".partial"));
  std::filesystem::remove(file);
}

TEST(FeatureFile, IsNotTheFileOfAnotherOption) {
  const auto file = test_file("one.csv");
  const Heard heard = call_command("run graphs/lep_lines.yaml --quiet --ticks 1 --features '" +
                                   file.string() + "' --profile '" + file.string() + "'");
  EXPECT_EQ(heard.status, 2);
  EXPECT_EQ(heard.errors,
            "ilss: --features: '" + file.string() + "' is the file of --profile, too\n");
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(FeatureFile, OfARunThatCannotGoOnIsNotWritten) {
  const auto graph = graph_file("graph.yaml", log_graph("/no/such/file.csv", "robot"));
  const auto file = test_file("features.csv");
  std::ofstream(file) << "precious";
  const Heard heard =
      call_command("run '" + graph.string() + "' --features '" + file.string() + "'");
  EXPECT_EQ(heard.status, 2);
  EXPECT_EQ(text_of(file), "precious");
  EXPECT_FALSE(std::filesystem::exists(file.string() + ".partial"));
  for (const auto& path : {graph, file}) std::filesystem::remove(path);
}

TEST(RunNotes, TellHowManyLinesWereLeftOut) {
  const auto log = graph_file("scans.log",
                              "FLASER 3 1 2 3 0 0 0 0 0 0 1 h 1\nFLASER 3 1 2\n"
                              "FLASER 3 1 x 3 0 0 0 0 0 0 1 h 1\n"
                              "FLASER 3 1 2 3 0 0 0 0 0 0 2 h 2\n");
  const auto graph = graph_file(
      "graph.yaml", "ilss: scans\nmodules:\n  laser: {type: laser_log, skip_bad: true, file: " +
                        log.string() + "}\nnetwork: {serial: [laser]}\n");
  for (const std::string options : {"", " --json", " --quiet"}) {
    const Heard heard = call_command("run '" + graph.string() + "'" + options);
    EXPECT_EQ(heard.status, 0);
    EXPECT_EQ(heard.errors, "ilss: 'laser': 2 bad lines left out, the first: " + log.string() +
                                ":2: the line ends at word 5; expected a range\n");
  }
  for (const auto& path : {graph, log}) std::filesystem::remove(path);
}

}  // namespace
}  // namespace ilss
