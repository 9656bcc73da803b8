// `ilss run --picture`: what stands in the SVG, and where; when there is none.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <regex>
#include <sstream>

#include "command.h"
#include "xml_elements.h"

namespace ilss {
namespace {

using Json = nlohmann::json;
using Elements = std::vector<XmlElement>;

/// What a run drew.
struct Drawn {
  Heard heard;
  std::string svg;
  Elements elements = {};

  /// `graph` is a file, `options` are of the run.
  explicit Drawn(const std::string& graph, const std::string& options = "", int ticks = 1) {
    const std::filesystem::path file = test_file("picture.svg");
    heard = call_command("run '" + graph + "' --ticks " + std::to_string(ticks) + " " + options +
                         " --picture '" + file.string() + "'");
    EXPECT_EQ(heard.status, 0) << heard.errors;
    svg = text_of(file);
    std::filesystem::remove(file);
    elements = XmlReader(svg).read();
  }

  Elements named(const std::string& name, const std::string& of_class = "") const {
    Elements found;
    for (const XmlElement& element : elements)
      if (element.name == name &&
          (of_class.empty() ||
           (element.attributes.contains("class") && element.attributes.at("class") == of_class)))
        found.push_back(element);
    return found;
  }
  bool says(const std::string& text) const {
    const Elements texts = named("text");
    return std::any_of(texts.begin(), texts.end(), [&](const XmlElement& element) {
      return element.text.find(text) != std::string::npos;
    });
  }
};

double number(const XmlElement& element, const std::string& attribute) {
  return std::stod(element.attributes.at(attribute));
}

std::vector<double> numbers_in(const std::string& text) {
  std::vector<double> numbers;
  const std::regex number("-?[0-9]+(\\.[0-9]+)?");
  for (std::sregex_iterator i(text.begin(), text.end(), number), end; i != end; ++i)
    numbers.push_back(std::stod(i->str()));
  return numbers;
}

/// What a run of a graph with this text draws.
Drawn draw(const std::string& graph_text) {
  const std::filesystem::path graph = test_file("graph.yaml");
  std::ofstream(graph) << graph_text;
  Drawn drawn(graph.string());
  std::filesystem::remove(graph);
  return drawn;
}

/// Modules whose outputs are points: NAME has its components' formulas in frame FRAME.
std::string point_module(const std::string& name, const std::string& frame, const std::string& up,
                         const std::string& quantities, const std::string& x,
                         const std::string& y) {
  return "  " + name + ": {type: expression, frame: " + frame + ", quantities: {" + quantities +
         "}, output: {x: {unit: m, formula: \"" + x + "\"}, " + up + ": {unit: m, formula: \"" + y +
         "\"}}}\n";
}

TEST(Picture, ShowsReadingsSegmentsEdgesSensorAndScene) {
  const Drawn drawn("graphs/lep_lines.yaml");
  ASSERT_EQ(drawn.named("path", "readings").size(), 1);
  const std::string dots = drawn.named("path", "readings")[0].attributes.at("d");
  EXPECT_EQ(std::count(dots.begin(), dots.end(), 'M'), 256);
  using Kind = std::pair<const char*, const char*>;
  const std::vector<std::pair<Kind, std::size_t>> expected = {
      {{"path", "stroke"}, 2},   {{"circle", "place"}, 1}, {{"path", "jump"}, 0},
      {{"circle", "sensor"}, 1}, {{"path", "field"}, 1},   {{"g", "scene"}, 1},
      {{"line", ""}, 2}};
  for (const auto& [kind, count] : expected)
    EXPECT_EQ(drawn.named(kind.first, kind.second).size(), count) << kind.first << kind.second;
}

TEST(Picture, SaysWhatIsWhat) {
  const Drawn drawn("graphs/lep_lines.yaml");
  for (const char* text :
       {"ranging: 256 readings", "lines: 2 line_segment, 1 corner", "the scene that lep looks at",
        "ellipses hold 95 %", "x (m)", "z (m)", "lep_lines, tick 0 at 0.000 s, frame lep"})
    EXPECT_TRUE(drawn.says(text)) << text;
  EXPECT_FALSE(drawn.says("times as large"));
}

TEST(Picture, PillarsAreCirclesArcsAreArcsAndJumpsAreCrosses) {
  const std::filesystem::path scene = test_file("scene.yaml");
  std::ofstream(scene) << R"(scene: a pillar before a doorway
walls:
  - {from: {x: 1.6 m, z: -2 m}, to: {x: 1.6 m, z: -0.3 m}}
  - {from: {x: 1.6 m, z: 0.25 m}, to: {x: 1.6 m, z: 2 m}}
  - {from: {x: 2.1 m, z: -3 m}, to: {x: 2.1 m, z: 3 m}}
pillars: [{centre: {x: 1.1 m, z: 0 m}, radius: 0.1 m}]
)";
  const Drawn drawn("graphs/lep_lines.yaml",
                    "--set lep.field_of_view='60 deg' --set lep.scene='" + scene.string() + "'");
  std::filesystem::remove(scene);
  std::size_t arcs = 0;
  for (const XmlElement& stroke : drawn.named("path", "stroke"))
    arcs += stroke.attributes.at("d").find('A') != std::string::npos ? 1 : 0;
  EXPECT_EQ(arcs, 1);
  EXPECT_GE(drawn.named("path", "jump").size(), 1);
  EXPECT_TRUE(drawn.says(", 1 arc_segment"));
  EXPECT_EQ(drawn.named("line").size(), 3);
}

TEST(Picture, WallsStandWhereTheSensorSeesThemFromAMovingVehicle) {
  const Drawn drawn("graphs/lep_lines.yaml",
                    "--set lep.speed='0.2 m/s' --set lep.turn_rate='6 deg/s' "
                    "--set lep.robot.z='50 mm' --set lep.head_angle='10 deg'",
                    11);
  const Elements walls = drawn.named("line");
  const Elements strokes = drawn.named("path", "stroke");
  ASSERT_EQ(walls.size(), 2);
  ASSERT_EQ(strokes.size(), 2);
  // The scan runs from left to right; the scene has the right wall first.
  for (std::size_t s = 0; s < 2; ++s) {
    const XmlElement& wall = walls[1 - s];
    const Eigen::Vector2d from(number(wall, "x1"), number(wall, "y1"));
    const Eigen::Vector2d to(number(wall, "x2"), number(wall, "y2"));
    const Eigen::Vector2d along = (to - from).normalized();
    const std::vector<double> ends = numbers_in(strokes[s].attributes.at("d"));
    for (std::size_t e = 0; e < 2; ++e) {
      const Eigen::Vector2d offset = Eigen::Vector2d(ends[2 * e], ends[2 * e + 1]) - from;
      EXPECT_LT(std::abs(along.x() * offset.y() - along.y() * offset.x()), 4);  // px, 10 mm
      EXPECT_GE(along.dot(offset), -4);
    }
  }
}

TEST(Picture, FitsItsViewBox) {
  const Drawn drawn("graphs/lep_lines.yaml");
  const XmlElement& root = drawn.elements.front();
  const std::vector<double> view = numbers_in(root.attributes.at("viewBox"));
  ASSERT_EQ(view.size(), 4);
  EXPECT_EQ(view[2], number(root, "width"));
  EXPECT_EQ(view[3], number(root, "height"));
  const XmlElement plot = drawn.named("svg").at(1);
  EXPECT_LE(number(plot, "x") + number(plot, "width"), view[2]);
  EXPECT_LE(number(plot, "y") + number(plot, "height"), view[3]);
  for (const XmlElement& text : drawn.named("text")) EXPECT_LE(number(text, "y"), view[3]);
}

TEST(Picture, SegmentsLieInThePlot) {
  const Drawn drawn("graphs/lep_lines.yaml");
  const XmlElement plot = drawn.named("svg").at(1);
  const Eigen::Array2d size(number(plot, "width"), number(plot, "height"));
  for (const XmlElement& stroke : drawn.named("path", "stroke")) {
    const std::vector<double> ends = numbers_in(stroke.attributes.at("d"));
    ASSERT_EQ(ends.size(), 4);
    for (const Eigen::Array2d& end :
         {Eigen::Array2d(ends[0], ends[1]), Eigen::Array2d(ends[2], ends[3])})
      EXPECT_TRUE((end > 0).all() && (end < size).all()) << end;
  }
}

TEST(Picture, HoldsOnlyFiniteNumbers) {
  const Drawn drawn("graphs/lep_lines.yaml", "--picture-scale 1e6");
  for (const XmlElement& element : drawn.elements)
    for (const auto& [name, value] : element.attributes)
      EXPECT_FALSE(std::regex_search(value, std::regex("nan|inf|-0\\.00([^0-9]|$)")))
          << element.name << " " << name << "=" << value;
}

TEST(Picture, IsTheSameEachTime) {
  EXPECT_EQ(Drawn("graphs/lep_lines.yaml").svg, Drawn("graphs/lep_lines.yaml").svg);
}

/// The covariance of two of a feature's components.
Eigen::Matrix2d covariance_of(const Json& feature, const std::string& a, const std::string& b) {
  std::size_t i = 0;
  std::size_t j = 0;
  for (std::size_t c = 0; c < feature.at("components").size(); ++c) {
    if (feature["components"][c]["name"] == a) i = c;
    if (feature["components"][c]["name"] == b) j = c;
  }
  const Json& all = feature.at("covariance");
  Eigen::Matrix2d covariance;
  covariance << all[i][i], all[i][j], all[j][i], all[j][j];
  return covariance;
}

double component(const Json& feature, const std::string& name) {
  for (const Json& one : feature.at("components"))
    if (one.at("name") == name) return one.at("value");
  return NAN;
}

/// Holds an ellipse, in a picture to this scale, against the eigenvalues and -vectors.
void expect_ellipse(const XmlElement& ellipse, const Eigen::Matrix2d& covariance,
                    double pixels_per_metre) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance);
  // chi² of two degrees of freedom exceeds -2 ln(0.05) with probability 0.05.
  const double factor = std::sqrt(-2 * std::log(0.05)) * pixels_per_metre;
  const double major = factor * std::sqrt(eigen.eigenvalues()[1]);
  const double minor = factor * std::sqrt(std::max(0.0, eigen.eigenvalues()[0]));
  EXPECT_NEAR(number(ellipse, "rx"), major, 0.01 + 1e-3 * major);
  EXPECT_NEAR(number(ellipse, "ry"), std::max(minor, 0.1), 0.01 + 1e-3 * major);
  const double turned =
      -numbers_in(ellipse.attributes.at("transform")).at(0) * std::numbers::pi / 180;
  const Eigen::Vector2d along(std::cos(turned), std::sin(turned));
  EXPECT_NEAR(std::abs(along.dot(eigen.eigenvectors().col(1))), 1, 1e-6);
}

TEST(Picture, EllipsesAreThoseOfTheCovariances) {
  constexpr double scale = 100;
  const Drawn drawn("graphs/lep_lines.yaml", "--json --picture-scale 100");
  const Json features = Json::parse(drawn.heard.output)["output"]["features"];
  ASSERT_EQ(features.size(), 3);
  const std::vector<double> first =
      numbers_in(drawn.named("path", "stroke").at(0).attributes.at("d"));
  const double length =
      std::hypot(component(features[0], "end_x") - component(features[0], "start_x"),
                 component(features[0], "end_z") - component(features[0], "start_z"));
  const double pixels_per_metre = std::hypot(first[2] - first[0], first[3] - first[1]) / length;
  const Elements ellipses = drawn.named("ellipse");
  ASSERT_EQ(ellipses.size(), 5);  // four ends and the corner
  for (std::size_t s = 0; s < 2; ++s) {
    expect_ellipse(ellipses[2 * s], covariance_of(features[s], "start_x", "start_z"),
                   scale * pixels_per_metre);
    expect_ellipse(ellipses[2 * s + 1], covariance_of(features[s], "end_x", "end_z"),
                   scale * pixels_per_metre);
  }
  expect_ellipse(ellipses[4], covariance_of(features[2], "x", "z"), scale * pixels_per_metre);
  EXPECT_TRUE(drawn.says("errors drawn 100 times as large"));
}

TEST(Picture, PointsOfAnyModuleAreDrawnWithTheirEllipse) {
  // x = a + b and z = a - b have uncorrelated errors only where a's and b's are alike.
  const Drawn drawn =
      draw("ilss: points\nmodules:\n" +
           point_module("p", "lep", "z", "a: {value: 1 m, std: 3 mm}, b: {value: 1 m, std: 1 mm}",
                        "a + b", "a - b") +
           "network: p\n");
  ASSERT_EQ(drawn.named("circle", "place").size(), 1);
  ASSERT_EQ(drawn.named("ellipse").size(), 1);
  // The plot of a single point is 0.1 m wide.
  const double pixels_per_metre = number(drawn.named("svg").at(1), "height") / 0.1;
  Eigen::Matrix2d covariance;
  covariance << 10e-6, 8e-6, 8e-6, 10e-6;
  expect_ellipse(drawn.named("ellipse")[0], covariance, pixels_per_metre);
}

TEST(Picture, RightHandedFramesHaveXUpAndYToTheLeft) {
  const Drawn drawn =
      draw("ilss: points\nmodules:\n" +
           point_module("ahead", "laser", "y",
                        "a: {value: 2 m, std: 3 mm}, b: {value: 0 m, std: 1 mm}", "a", "b") +
           point_module("left", "laser", "y",
                        "a: {value: 0 m, std: 3 mm}, b: {value: 1 m, std: 1 mm}", "a", "b") +
           "network: {combine: [ahead, left]}\n");
  const Elements places = drawn.named("circle", "place");
  ASSERT_EQ(places.size(), 2);
  EXPECT_LT(number(places[0], "cy"), number(places[1], "cy"));
  EXPECT_GT(number(places[0], "cx"), number(places[1], "cx"));
  EXPECT_TRUE(drawn.says("y (m)"));
}

TEST(Picture, LeavesOutWhatIsInAnotherFrameAndSaysSo) {
  const std::string values = "a: {value: 2 m, std: 3 mm}, b: {value: 0 m, std: 1 mm}";
  const Drawn drawn = draw(
      "ilss: points\nmodules:\n" + point_module("here", "one", "z", values, "a", "b") +
      point_module("there", "two", "z", values, "a", "b") + "network: {combine: [here, there]}\n");
  EXPECT_EQ(drawn.named("circle", "place").size(), 1);
  EXPECT_EQ(drawn.heard.errors,
            "ilss: --picture: 'there' is in frame two, the picture in one: left out\n");
}

TEST(Picture, TextsAreEscaped) {
  const Drawn drawn = draw(R"(ilss: points
description: 'a < b & "c" > d'
modules:
)" + point_module("p", "lep", "z", "a: 1 m, b: 1 m", "a", "b") +
                           "network: p\n");
  EXPECT_TRUE(drawn.says(R"(a < b & "c" > d)"));
}

TEST(Picture, WithoutAnythingToDrawThereIsAMessageAndNoFile) {
  const std::filesystem::path file = test_file("none.svg");
  const Heard heard =
      call_command("run graphs/wall_pose_sonar.yaml --ticks 1 --picture '" + file.string() + "'");
  EXPECT_EQ(heard.status, 1);
  EXPECT_EQ(heard.errors,
            "ilss: --picture: nothing that the run gave has a place in a plane: no range scan, "
            "segment, arc, edge or point\n");
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(Picture, AFileThatCannotBeWrittenIsRefusedBeforeTheRun) {
  const Heard heard =
      call_command("run graphs/lep_lines.yaml --ticks 1 --picture /no/such/folder/picture.svg");
  EXPECT_EQ(heard.status, 2);
  EXPECT_EQ(heard.errors,
            "ilss: --picture: cannot write '/no/such/folder/picture.svg': No such file or "
            "directory\n");
  EXPECT_EQ(heard.output, "");
}

TEST(Picture, ScaleIsRefusedWithoutAPictureOrOutOfRange) {
  EXPECT_EQ(call_command("run graphs/lep_lines.yaml --picture-scale 10").status, 2);
  for (const char* scale : {"0", "-1", "nan", "1e9", "large"}) {
    const std::filesystem::path file = test_file("scale.svg");
    const Heard heard = call_command("run graphs/lep_lines.yaml --picture '" + file.string() +
                                     "' --picture-scale " + scale);
    EXPECT_EQ(heard.status, 2) << scale;
    EXPECT_TRUE(heard.output.empty()) << scale;
    EXPECT_NE(heard.errors.find("--picture-scale"), std::string::npos) << heard.errors;
    EXPECT_FALSE(std::filesystem::exists(file));
  }
}

/// The commands in a page that draw its pictures: the line from `ilss` up to a pipe, and the file.
struct DrawingCommand {
  std::string arguments;
  std::string picture;
};
std::vector<DrawingCommand> drawing_commands(const std::filesystem::path& page) {
  std::vector<DrawingCommand> commands;
  std::istringstream lines(text_of(page));
  const std::regex command(R"(\$ ilss (run .*)--picture (docs/pictures/\S+)([^|]*)(\|.*)?)");
  std::smatch match;
  for (std::string line; std::getline(lines, line);)
    if (std::regex_match(line, match, command))
      commands.push_back({match[1].str() + match[3].str(), match[2].str()});
  return commands;
}

TEST(DocumentedPictures, AreWhatTheCommandsBesideThemDraw) {
  std::size_t pictures = 0;
  for (const auto& page : std::filesystem::directory_iterator(ILSS_SOURCE_DIR "/docs")) {
    if (page.path().extension() != ".md") continue;
    for (const DrawingCommand& command : drawing_commands(page.path())) {
      SCOPED_TRACE(command.picture);
      ++pictures;
      const std::filesystem::path drawn = test_file("drawn.svg");
      const Heard heard = call_command(command.arguments + " --picture '" + drawn.string() + "'");
      EXPECT_EQ(heard.status, 0) << heard.errors;
      EXPECT_EQ(text_of(drawn), text_of(ILSS_SOURCE_DIR "/" + command.picture))
          << command.picture << " is out of date: run\n  scripts/draw_pictures " ILSS_COMMAND;
      std::filesystem::remove(drawn);
    }
  }
  EXPECT_GE(pictures, 4);
}

}  // namespace
}  // namespace ilss
