// Options: what is declared of them, and every message with its place.
#include "framework/module/parameters.h"

#include <gtest/gtest.h>

#include <fstream>

namespace ilss {
namespace {

using Messages = std::vector<std::string>;

enum class Colour { red, green };
constexpr std::array<std::string_view, 2> choices(Colour) { return {"red", "green"}; }

struct Place {
  double x = 0;
  double heading = 0.5;
  void declare(OptionVisitor& visit) {
    visit("x", x, "forward", {.unit = "m", .required = true});
    visit("heading", heading, "to the right", {.unit = "rad"});
  }
};

struct Content {
  int count = 1;
  void declare(OptionVisitor& visit) { visit("count", count, "how many", {.minimum = 0}); }
};

struct Everything {
  bool on = true;
  int rows = 128;
  std::uint8_t level = 3;
  std::int64_t big = 0;
  double gain = 2;
  double length = 0.25;
  std::string title = "none";
  std::filesystem::path file = {};
  Colour colour = Colour::green;
  std::optional<double> limit = {};
  std::vector<double> lengths = {};
  std::vector<Place> places = {};
  std::optional<Place> spare = {};
  FileOf<Content> scene = {};
  void declare(OptionVisitor& visit) {
    visit("on", on, "a switch");
    visit("rows", rows, "of the image", {.minimum = 8, .maximum = 4096});
    visit("level", level, "grey");
    visit("big", big, "an integer");
    visit("gain", gain, "a number");
    visit("length", length, "a length", {.unit = "m", .minimum = 0});
    visit("title", title, "a text");
    visit("file", file, "a path");
    visit("colour", colour, "a choice");
    visit("limit", limit, "may be left out", {.unit = "s"});
    visit("lengths", lengths, "a list", {.unit = "m"});
    visit("places", places, "a list of groups");
    visit("spare", spare, "a group that may be left out");
    visit("scene", scene, "another file");
    visit.require(rows % 2 == 0, "rows must be even");
  }
};

template <typename Options>
std::pair<Options, Messages> read(const std::string& text,
                                  const std::filesystem::path& directory = "/graphs") {
  Diagnostics diagnostics;
  const Node root = parse_document(text, "f.yaml", diagnostics);
  const Node* map = root.is_map() ? &root : nullptr;
  if (map != nullptr) check_keys(*map, declare_options<Options>(), "camera", diagnostics);
  std::pair<Options, Messages> result{
      read_options<Options>(map, directory, diagnostics, root.position), {}};
  for (const Diagnostic& d : diagnostics.sorted()) result.second.push_back(format_diagnostic(d));
  return result;
}

Messages messages(const std::string& text) { return read<Everything>(text).second; }

TEST(Options, AreTheirDefaultsWhereNothingIsGiven) {
  const auto [options, errors] = read<Everything>("");
  EXPECT_EQ(errors, Messages{});
  EXPECT_EQ(options.rows, 128);
  EXPECT_EQ(options.colour, Colour::green);
  EXPECT_FALSE(options.limit || options.spare);
}

TEST(Options, AreReadInEveryKind) {
  const auto [o, errors] = read<Everything>(
      "on: false\nrows: 64\nlevel: 255\nbig: -9000000000\ngain: 1.5\nlength: 30 mm\ntitle: a b\n"
      "file: images/a.png\ncolour: red\nlimit: 20 ms\nlengths: [1 m, 2 cm]\n"
      "places: [{x: 1 m}, {x: 2 m, heading: 90 deg}]\nspare: {x: 3 m}\n");
  EXPECT_EQ(errors, Messages{});
  EXPECT_FALSE(o.on);
  EXPECT_EQ(o.rows, 64);
  EXPECT_EQ(o.level, 255);
  EXPECT_EQ(o.big, -9'000'000'000);
  EXPECT_EQ(o.gain, 1.5);
  EXPECT_DOUBLE_EQ(o.length, 0.03);
  EXPECT_EQ(o.title, "a b");
  EXPECT_EQ(o.file, "/graphs/images/a.png");
  EXPECT_EQ(o.colour, Colour::red);
  EXPECT_DOUBLE_EQ(o.limit.value(), 0.02);
  EXPECT_EQ(o.lengths, (std::vector{1.0, 0.02}));
  ASSERT_EQ(o.places.size(), 2u);
  EXPECT_EQ(o.places[0].heading, 0.5);
  EXPECT_EQ(o.places[1].x, 2);
  EXPECT_EQ(o.spare.value().x, 3);
  EXPECT_EQ(read<Everything>("file: /absolute/a.png\n").first.file, "/absolute/a.png");
}

TEST(Options, OfTheWrongTypeAreAllReportedAtTheirPlaces) {
  EXPECT_EQ(
      messages("on: yes\nrows: 1.5\ngain: 3 m\nlength: [1]\ntitle: {a: 1}\nfile: [x]\n"
               "colour: gren\nlimit: 5\nlengths: 1 m\nplaces: [1]\nspare: 7\nscene: []\n"),
      (Messages{
          "f.yaml:1:5: expected true or false, got 'yes'",
          "f.yaml:2:7: expected an integer, got '1.5'", "f.yaml:3:7: 'm' is not a pure number",
          "f.yaml:4:9: expected a length (m), got a list", "f.yaml:5:8: expected a text, got a map",
          "f.yaml:6:7: expected a path, got a list",
          "f.yaml:7:9: expected one of red, green, got 'gren'; did you mean 'green'?",
          "f.yaml:8:8: '5' has no unit; expected a time (s)",
          "f.yaml:9:10: expected a list, got '1 m'", "f.yaml:10:10: expected a map, got '1'",
          "f.yaml:11:8: expected a map, got '7'", "f.yaml:12:8: expected a path, got a list"}));
}

TEST(Options, OutsideTheirRangeAreReported) {
  EXPECT_EQ(messages("rows: 4\nlevel: 256\nlength: -1 mm\nbig: 99999999999999999999\n"),
            (Messages{"f.yaml:1:7: 4 is outside [8, 4096]", "f.yaml:2:8: 256 is outside [0, 255]",
                      "f.yaml:3:9: -0.001 is outside [0, inf] m",
                      "f.yaml:4:6: expected an integer, got '99999999999999999999'"}));
}

TEST(Options, ThatAreUnknownAreReportedWithASuggestion) {
  EXPECT_EQ(messages("rwos: 4\nspare: {x: 1 m, heding: 0}\nplaces: [{x: 0, y: 1}]\nzzz: 1\n"),
            (Messages{"f.yaml:1:1: camera has no parameter 'rwos'; did you mean 'rows'?",
                      "f.yaml:2:17: camera has no parameter 'heding'; did you mean 'heading'?",
                      "f.yaml:3:17: camera has no parameter 'y'",
                      "f.yaml:4:1: camera has no parameter 'zzz'"}));
}

TEST(Options, ThatWereMovedAreReportedWithWhereTheyStand) {
  Diagnostics diagnostics;
  const Node root = parse_document("mount: {x: 1 m}\nrows: 8\n", "f.yaml", diagnostics);
  check_keys(root, declare_options<Everything>(), "camera", diagnostics,
             {{"mount", "give it to the tripod"}});
  ASSERT_EQ(diagnostics.size(), 1U);
  EXPECT_EQ(format_diagnostic(diagnostics.sorted()[0]),
            "f.yaml:1:1: camera has no parameter 'mount': give it to the tripod");
}

TEST(Options, ThatMustFitTogetherAreReportedAtTheirMap) {
  EXPECT_EQ(messages("title: x\nrows: 129\n"), (Messages{"f.yaml:1:1: rows must be even"}));
}

struct Mounted {
  Place mount;
  void declare(OptionVisitor& visit) { visit("mount", mount, "where it is"); }
};

TEST(Options, ThatAreRequiredAreMissedInGroupsToo) {
  EXPECT_EQ(read<Mounted>("mount: {heading: 0}\n").second,
            (Messages{"f.yaml:1:8: missing parameter 'mount.x'"}));
  EXPECT_EQ(read<Mounted>("").second, (Messages{"f.yaml:1:1: missing parameter 'mount.x'"}));
  EXPECT_EQ(messages("places: [{heading: 1 rad}]\n"),
            (Messages{"f.yaml:1:10: missing parameter 'places.x'"}));
  EXPECT_EQ(messages("spare: {}\n"), (Messages{"f.yaml:1:8: missing parameter 'spare.x'"}));
}

TEST(Options, OfAnotherFileAreReportedInThatFile) {
  const std::filesystem::path directory = testing::TempDir();
  std::ofstream(directory / "good.yaml") << "count: 4\n";
  std::ofstream(directory / "bad.yaml") << "cuont: 4\ncount: -1\n";
  std::ofstream(directory / "list.yaml") << "[1]\n";
  const auto good = read<Everything>("scene: good.yaml\n", directory);
  EXPECT_EQ(good.second, Messages{});
  EXPECT_EQ(good.first.scene.content.count, 4);
  const std::string bad = (directory / "bad.yaml").string();
  EXPECT_EQ(read<Everything>("scene: bad.yaml\n", directory).second,
            (Messages{bad + ":1:1: bad.yaml has no parameter 'cuont'; did you mean 'count'?",
                      bad + ":2:8: -1 is outside [0, 2147483647]"}));
  EXPECT_EQ(read<Everything>("scene: list.yaml\n", directory).second,
            (Messages{(directory / "list.yaml").string() + ":1:1: expected a map, got a list"}));
  EXPECT_EQ(read<Everything>("scene: none.yaml\n", directory).second,
            (Messages{(directory / "none.yaml").string() + ": the file cannot be read"}));
}

TEST(Declarations, SayKindUnitAndDefault) {
  using Kind = ParameterDeclaration::Kind;
  const auto declared = declare_options<Everything>();
  std::vector<std::tuple<std::string, Kind, std::string>> found;
  for (const auto& d : declared) found.emplace_back(d.name, d.kind, d.default_text);
  EXPECT_EQ(found, (std::vector<std::tuple<std::string, Kind, std::string>>{
                       {"on", Kind::boolean, "true"},
                       {"rows", Kind::integer, "128"},
                       {"level", Kind::integer, "3"},
                       {"big", Kind::integer, "0"},
                       {"gain", Kind::number, "2"},
                       {"length", Kind::quantity, "0.25 m"},
                       {"title", Kind::text, "none"},
                       {"file", Kind::path, ""},
                       {"colour", Kind::choice, "green"},
                       {"limit", Kind::quantity, ""},
                       {"lengths", Kind::list, ""},
                       {"places", Kind::list, ""},
                       {"spare", Kind::group, ""},
                       {"scene", Kind::path, ""}}));
  EXPECT_EQ(declared[8].choices, (std::vector<std::string>{"red", "green"}));
  EXPECT_EQ(declared[11].children.front().children.front().name, "x");
  EXPECT_TRUE(declared[11].children.front().children.front().required);
}

template <typename T>
struct Mounting {
  T x, heading, gain;
  static constexpr std::string_view name = "test_mounting";
  static constexpr auto fields = Fields{{"mount.x", "m", "forward"},
                                        {"mount.heading", "rad", "", 0.0, Geometry::circular},
                                        {"gain", "1", "", 2.0}};
};

TEST(Declarations, OfDottedQuantitiesAreGroups) {
  auto declared = quantity_declarations(descriptor<Mounting>());
  ASSERT_EQ(declared.size(), 2u);
  EXPECT_EQ(declared[0].name, "mount");
  ASSERT_EQ(declared[0].children.size(), 2u);
  EXPECT_TRUE(declared[0].children[0].required && declared[0].children[0].uncertain);
  EXPECT_EQ(declared[0].children[1].default_text, "0 rad");
  EXPECT_EQ(declared[1].default_text, "2");
  merge_declarations(declared, declare_options<Mounted>());
  ASSERT_EQ(declared.size(), 2u);
  EXPECT_EQ(declared[0].children.size(), 4u);
}

}  // namespace
}  // namespace ilss
