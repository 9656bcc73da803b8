// `ilss calibrate`: what it finds, what it writes, and what it refuses.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <iomanip>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "command.h"

namespace ilss {
namespace {

using Json = nlohmann::json;

constexpr const char* shipped_data =
    "calibrate lep graphs/data/lep_calibration.csv --noise-current '36.2 pA' "
    "--stripes graphs/data/lep_stripes.csv ";
constexpr const char* heading =
    "scan_angle [deg],depth [m],image_position [um],image_position_std [um]\n";

/// A CSV file of this test alone.
std::string csv(const std::string& text, const std::string& name = "data.csv") {
  const auto path = test_file(name);
  std::ofstream(path) << text;
  return path.string();
}

/// Exact readings of the shipped sensor at scan angle 0 (equation 10) and 12 depths.
std::string one_angle() {
  const double tangent = std::tan(7.07 * M_PI / 180);
  const double a = -0.086 * tangent - 0.06 * std::hypot(1, tangent);
  std::ostringstream text;
  text << heading << std::setprecision(12);
  for (int i = 0; i < 12; ++i) {
    const double z = 0.5 + 0.15 * i;
    text << "0," << z << "," << 1e6 * 0.05 * (z * tangent - 0.086) / (a - z) << ",5\n";
  }
  return text.str();
}

TEST(CalibrateLep, RecoversTheShippedExamplesTruthWithinItsErrors) {
  const Heard heard = call_command(std::string(shipped_data) + "--json");
  ASSERT_EQ(heard.status, 0) << heard.errors;
  const Json json = Json::parse(heard.output);
  // The first lines of the two files say what they were simulated with.
  const std::map<std::string, double> truth = {{"focal_length", 0.05},
                                               {"baseline", 0.086},
                                               {"vergence", 0.12339478},
                                               {"lens_distance", 0.06},
                                               {"origin_x", -0.043},
                                               {"origin_z", 0.06},
                                               {"projected_vergence", 0.0087266463}};
  ASSERT_EQ(json["parameters"].size(), truth.size());
  for (const Json& parameter : json["parameters"])
    EXPECT_LT(std::abs(parameter["value"].get<double>() - truth.at(parameter["name"])),
              3.5 * parameter["std"].get<double>())
        << parameter;
  EXPECT_EQ(json["readings"], 384);
  EXPECT_NEAR(json["chi_squared"].get<double>() / json["degrees_of_freedom"].get<double>(), 1, 0.2);
  EXPECT_EQ(json["table"]["interpolation"]["cells"], 31 * 11);
}

TEST(CalibrateLep, WritesAConstantThatAGraphTakesWithItsCovariance) {
  const auto constants = test_file("lep.yaml");
  const Heard heard =
      call_command(std::string(shipped_data) + "--json --output '" + constants.string() + "'");
  ASSERT_EQ(heard.status, 0) << heard.errors;
  const Json fit = Json::parse(heard.output);
  const auto graph = test_file("graph.yaml");
  std::ofstream(graph) << "constants: {lep: {file: " << constants.filename().string() << "}}\n"
                       << R"(
modules:
  parameters:
    type: expression
    quantities: {f: $lep.focal_length, g: $lep.vergence, z: $lep.origin_z}
    output:
      f: {unit: m, formula: f}
      g: {unit: rad, formula: g}
      z: {unit: m, formula: z}
network: parameters
)";
  const Heard prediction = call_command("predict '" + graph.string() + "' --json");
  ASSERT_EQ(prediction.status, 0) << prediction.errors;
  const Json output = Json::parse(prediction.output)["output"];
  const std::array<std::size_t, 3> which = {0, 2, 5};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(output["components"][i]["value"].get<double>(),
                fit["parameters"][which[i]]["value"].get<double>(), 1e-11);
    for (std::size_t j = 0; j < 3; ++j) {
      const double stated = fit["covariance"][which[i]][which[j]];
      EXPECT_NEAR(output["covariance"][i][j].get<double>(), stated, 1e-9 * std::abs(stated));
    }
  }
  ASSERT_EQ(output["budget"].size(), 1u);
  EXPECT_EQ(output["budget"][0]["source"], "lep");
  EXPECT_EQ(output["budget"][0]["kind"], "systematic");
}

TEST(CalibrateLep, ScanOriginMayBeGivenWithItsErrors) {
  const Heard heard = call_command(
      "calibrate lep graphs/data/lep_calibration.csv --noise-current '36.2 pA' --json "
      "--origin-x=-43mm --origin-z '{value: 60 mm, std: 0.2 mm}' --projected-vergence '0.5 deg'");
  ASSERT_EQ(heard.status, 0) << heard.errors;
  const Json parameters = Json::parse(heard.output)["parameters"];
  EXPECT_EQ(parameters[4]["std"], 0);
  EXPECT_NEAR(parameters[5]["std"].get<double>(), 2e-4, 1e-15);
  EXPECT_NEAR(parameters[6]["value"].get<double>(), 0.5 * M_PI / 180, 1e-12);
}

TEST(CalibrateLep, SaysWhenTheStatedNoiseDoesNotFit) {
  const std::string call = shipped_data;
  EXPECT_NE(call_command(call).output.find("agree with the readings"), std::string::npos);
  const Heard heard = call_command(std::string(shipped_data).replace(call.find("36.2"), 4, "18.1"));
  EXPECT_EQ(heard.status, 0);
  EXPECT_NE(heard.output.find("do NOT agree with the readings"), std::string::npos) << heard.output;
}

TEST(CalibrateLep, WritesNoCalibrationOfAModelThatDoesNotFit) {
  const auto output = test_file("lep.yaml");
  const std::string call =
      std::string(shipped_data).replace(std::string(shipped_data).find("36.2"), 4, "9.05") +
      " --output '" + output.string() + "'";
  const Heard heard = call_command(call);
  EXPECT_EQ(heard.status, 1);
  EXPECT_NE(heard.errors.find("the model does not fit: chi-squared is 17"), std::string::npos)
      << heard.errors;
  EXPECT_FALSE(std::filesystem::exists(output));
  EXPECT_EQ(call_command(call + " --force").status, 0);
  EXPECT_TRUE(std::filesystem::exists(output));
  std::filesystem::remove(output);
}

TEST(CalibrateLep, LeavesItsInputAndWhatIsNoFileAlone) {
  const Heard itself =
      call_command(std::string(shipped_data) + " --output graphs/data/lep_calibration.csv");
  EXPECT_EQ(itself.status, 2);
  EXPECT_NE(itself.errors.find("'graphs/data/lep_calibration.csv' is read by this command"),
            std::string::npos)
      << itself.errors;
  const Heard device = call_command(std::string(shipped_data) + " --output /dev/null");
  EXPECT_EQ(device.status, 2);
  EXPECT_NE(device.errors.find("'/dev/null' is not a regular file"), std::string::npos);
}

TEST(CalibrateLep, NamesTheCombinationThatSingularDataLeaveOpen) {
  const auto output = test_file("lep.yaml");
  const Heard heard =
      call_command("calibrate lep '" + csv(one_angle()) + "' --output '" + output.string() + "'");
  EXPECT_EQ(heard.status, 2);
  EXPECT_NE(
      heard.errors.find("data.csv: degenerate: the data leave 1 of 4 parameters undetermined: "
                        "a change such as "),
      std::string::npos)
      << heard.errors;
  EXPECT_TRUE(heard.output.empty());
  EXPECT_FALSE(std::filesystem::exists(output));
}

/// What is said of a data file, without the folder.
std::string complaint(const std::string& text, const std::string& options = {}) {
  const std::string file = csv(text);
  const Heard heard = call_command("calibrate lep '" + file + "' " + options);
  EXPECT_EQ(heard.status, 2) << heard.output;
  std::string errors = heard.errors;
  for (auto at = errors.find(file); at != std::string::npos; at = errors.find(file))
    errors.replace(at, file.size(), "data.csv");
  return errors;
}

TEST(CalibrateLep, BadCellsAreReportedWithTheirPlaces) {
  EXPECT_EQ(complaint(std::string("# a remark\n") + heading + "0,0.5,nan,2\n1,0.5,3,0\n2,,3,1\n"),
            "data.csv:3:7: expected a number for 'image_position', got 'nan'\n"
            "data.csv:4:9: 'image_position_std' must be positive, got 0\n"
            "data.csv:5:3: expected a number for 'depth', got ''\n");
  EXPECT_EQ(complaint(std::string(heading) + "0,0.5,1\n"),
            "data.csv:2:1: a row of 3 cells in a table of 4 columns\n");
  EXPECT_EQ(complaint(std::string(heading) + "0,0.5,1,2\n0,-0.5,1,2\n"),
            "data.csv:3:1: the depth, -0.5 m, is not in front of the scan origin, at 0 m\n");
}

TEST(CalibrateLep, WrongColumnsAreReported) {
  EXPECT_EQ(complaint("scan_angle [m],depth,position [um],image_position_std [um]\n1,1,1,1\n"),
            "data.csv: column 'depth' needs its unit in brackets, as in 'depth [m]'\n"
            "data.csv: column 'scan_angle': 'm' is not an angle (rad)\n"
            "data.csv: there is no column 'image_position'; expected a length (m) under "
            "'image_position [m]' (the columns are: scan_angle, depth, position, "
            "image_position_std)\n");
  EXPECT_NE(complaint("scan_angle [deg],depth [m],image_position [um]\n1,1,1\n")
                .find("there is no column 'image_position_std'; expected a length (m) under "
                      "'image_position_std [m]', or a column detector_current with "
                      "--noise-current"),
            std::string::npos);
}

TEST(CalibrateLep, FilesWithoutReadingsAreReported) {
  EXPECT_EQ(complaint(""), "data.csv: the table is empty\n");
  EXPECT_EQ(complaint(heading), "data.csv: there is a header, but no rows\n");
  EXPECT_EQ(complaint(std::string(heading) + "0,0.5,1,2\n"),
            "data.csv: degenerate: a calibration needs 6 points or more, got 1\n");
  EXPECT_EQ(call_command("calibrate lep graphs").errors, "graphs: the table cannot be read\n");
}

TEST(CalibrateLep, BadOptionsAreReported) {
  EXPECT_EQ(complaint(one_angle(), "--origin-z '3 deg'"),
            "--origin-z '3 deg':1:1: 'deg' is not a length (m)\n");
  EXPECT_EQ(complaint(one_angle(), "--noise-current '-1 pA'"),
            "ilss: --noise-current: a noise current is positive\n");
  EXPECT_EQ(complaint(one_angle(), "--detector-length 0"),
            "ilss: --detector-length: a length is positive\n");
}

TEST(CalibrateLep, OutputThatCannotBeWrittenEndsIt) {
  const Heard heard = call_command(std::string(shipped_data) + "--output /nonexistent/lep.yaml");
  EXPECT_EQ(heard.status, 1);
  EXPECT_NE(heard.errors.find("cannot write '/nonexistent/lep.yaml'"), std::string::npos);
  EXPECT_TRUE(heard.output.empty());
}

TEST(CalibrateLepNoise, FindsTheNoiseCurrentOfThePapersTable) {
  const auto output = test_file("noise.yaml");
  const Heard heard = call_command(
      "calibrate lep_noise tests/data/lep/pears_table2.csv --detector-length '10 mm' --output '" +
      output.string() + "'");
  EXPECT_EQ(heard.status, 0) << heard.errors;
  EXPECT_NE(heard.output.find("noise current  (36.218 +- 0.515) pA"), std::string::npos)
      << heard.output;
  EXPECT_NE(heard.output.find("181.1 um nA"), std::string::npos);
  EXPECT_NE(text_of(output).find("value: 3.62180274e-11 A\nstd: 5.15154e-13 A\n"),
            std::string::npos);
}

/// Ranges of a laser that tells them 1 % too long, every fifth of a metre.
std::string ranges_csv(const std::string& measured_unit = "m") {
  std::ostringstream text;
  text << "true [m],measured [" << measured_unit << "],range_std [mm]\n";
  for (int i = 2; i < 40; ++i)
    text << 0.2 * i << "," << 0.202 * i + (i % 2 == 0 ? 0.003 : -0.003) << ",5\n";
  return csv(text.str());
}

TEST(CalibrateLaser, WritesConstantsThatLaserCorrectionTakes) {
  const std::string constants = test_file("laser.yaml").string();
  const Heard heard =
      call_command("calibrate laser " + ranges_csv() + " --order 1 --json --output " + constants);
  ASSERT_EQ(heard.status, 0) << heard.errors;
  const Json json = Json::parse(heard.output);
  EXPECT_NEAR(json["parameters"][1]["value"].get<double>() / json["bias_range"].get<double>(),
              0.01 / 1.01, 1e-3);
  const auto graph = test_file("graph.yaml");
  std::ofstream(graph) << "ilss: corrected\nconstants: {laser: {file: " << constants
                       << "}}\nmodules:\n  room: {type: laser_scene}\n"
                          "  correction: {type: laser_correction, bias_0: $laser.bias_0, bias_1: "
                          "$laser.bias_1, bias_range: $laser.bias_range}\n"
                          "network: {serial: [room, correction]}\n";
  const Heard run = call_command("run " + graph.string() + " --ticks 1 --json");
  ASSERT_EQ(run.status, 0) << run.errors;
  const Json scan = Json::parse(run.output)["output"];
  EXPECT_EQ(scan["components"][4]["name"], "bias_0");
  EXPECT_NEAR(scan["components"][4]["std"].get<double>(),
              json["parameters"][0]["std"].get<double>(), 1e-9);
}

TEST(CalibrateLaser, APolynomialThatDoesNotFitIsNotWritten) {
  const std::string constants = test_file("laser.yaml").string();
  const Heard heard =
      call_command("calibrate laser " + ranges_csv() + " --order 0 --output " + constants);
  EXPECT_EQ(heard.status, 1);
  EXPECT_NE(heard.errors.find("does not fit"), std::string::npos) << heard.errors;
  EXPECT_FALSE(std::filesystem::exists(constants));
}

TEST(CalibrateLaser, BadInputIsTwo) {
  EXPECT_EQ(call_command("calibrate laser /no/such/file.csv").status, 2);
  const Heard unit = call_command("calibrate laser " + ranges_csv("deg"));
  EXPECT_EQ(unit.status, 2);
  EXPECT_NE(unit.errors.find("measured"), std::string::npos) << unit.errors;
  EXPECT_EQ(call_command("calibrate laser " + csv("true [m],measured [m]\n1,1\n2,2\n")).status, 2);
}

}  // namespace
}  // namespace ilss
