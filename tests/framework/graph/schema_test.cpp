// The JSON Schema: valid JSON, and of one mind with `check` about graphs.
#include "framework/graph/schema.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

using nlohmann::json;

TEST(GraphSchema, IsJsonOfTheDraftThatItNames) {
  const json schema = json::parse(graph_schema(test::registry()));
  EXPECT_EQ(schema.at("$schema"), "https://json-schema.org/draft/2020-12/schema");
  EXPECT_EQ(schema.at("required"), (json{"modules", "network"}));
}

TEST(GraphSchema, HasARuleForEveryTypeWithItsParameters) {
  const json schema = json::parse(graph_schema(test::registry()));
  std::map<std::string, json> rules;
  for (const json& rule : schema.at("$defs").at("module").at("allOf")) {
    const json& type = rule.at("if").at("properties").at("type");
    if (type.contains("const")) rules[type.at("const")] = rule.at("then");
  }
  for (const ModuleType* type : test::registry().types()) {
    ASSERT_TRUE(rules.contains(type->name)) << type->name;
    for (const ParameterDeclaration& d : type->declarations)
      EXPECT_TRUE(rules[type->name].at("properties").contains(d.name)) << type->name << d.name;
  }
  EXPECT_EQ(rules["gain"].at("required"), (json{"type", "gain"}));
  EXPECT_EQ(rules["reading"].at("properties").at("bias").at("description"),
            "added to every reading; a length (m); default 0 m");
}

/// Judges graphs by the schema with Python's jsonschema; the schema and the graphs as JSON.
class SchemaByPython : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("python3 -c 'import jsonschema, yaml' 2>/dev/null") != 0)
      GTEST_SKIP() << "python3-jsonschema or python3-yaml is not installed, so the schema "
                      "was not tried on any graph";
  }
  bool accepts(const std::string& schema, const std::filesystem::path& graph) const {
    folder_.write("schema.json", schema);
    const std::string command =
        "python3 -W ignore -c 'import sys, json, yaml, jsonschema; "
        "jsonschema.Draft202012Validator(json.load(open(sys.argv[1]))).validate("
        "yaml.safe_load(open(sys.argv[2])))' '" +
        (folder_.path() / "schema.json").string() + "' '" + graph.string() + "' 2>'" +
        (folder_.path() / "errors").string() + "'";
    return std::system(command.c_str()) == 0;
  }
  std::string errors() const {
    std::ifstream stream(folder_.path() / "errors");
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  test::Folder folder_;
};

TEST_F(SchemaByPython, AcceptsWhatCheckAccepts) {
  const std::string text = R"(
ilss: all_forms
constants: {k: {value: 2, std: 0.1}, l: 1 mm, v: {value: {x: 1 m, y: 2 mm}, covariance: [[1, 0], [0, 1]]}}
modules:
  a: {type: reading, value: 3 m, value_std: 1 mm, noise: normal, period: 2, skipped: [4], time: 1 ms}
  b: {type: reading, bias: {value: 0, std: 1 mm}, mount: {x: $v.x}, frame:}
  g: {type: gain, gain: $k, offset: 0, time: {typical: 1 ms, worst: 2 ms}}
  h: {type: gain, gain: 2.5}
  s: {type: subtract}
  head: {type: head}
network:
  combine:
    - serial: [combine: {of: [{serial: [a, g]}, {serial: [b, h]}], align: latest, max_age: 1 s}, s]
    - head
commands: {look: head.rotate_to, turn: {to: head.rotate_at}, zoom: {to: head.zoom, from: head.ratio}}
)";
  test::plan_of(text);
  folder_.write("graph.yaml", text);
  EXPECT_TRUE(accepts(graph_schema(test::registry()), folder_.path() / "graph.yaml")) << errors();
}

TEST_F(SchemaByPython, RefusesMistakes) {
  const std::string schema = graph_schema(test::registry());
  for (const char* module :
       {"{type: readin}", "{type: reading, bais: 1 mm}", "{type: reading, noise: normale}",
        "{type: reading, bias: 3}", "{type: gain}", "{value: 1 m}", "{type: reading, period: x}",
        "{type: {ils: other.yaml}}", "{type: reading, mount: 3 mm}"}) {
    folder_.write("graph.yaml", std::string("modules: {a: ") + module + "}\nnetwork: a\n");
    EXPECT_FALSE(accepts(schema, folder_.path() / "graph.yaml")) << module;
  }
  for (const char* commands :
       {"[a]", "{l: a}", "{l: {from: a.x}}", "{l: {to: a.b, form: a.x}}", "{l.m: a.b}"}) {
    folder_.write("graph.yaml", std::string("modules: {a: {type: reading}}\nnetwork: a\n") +
                                    "commands: " + commands + "\n");
    EXPECT_FALSE(accepts(schema, folder_.path() / "graph.yaml")) << commands;
  }
}

TEST_F(SchemaByPython, AcceptsTheShippedGraphs) {
  const std::string schema_file = (folder_.path() / "of_command.json").string();
  ASSERT_EQ(std::system((std::string(ILSS_COMMAND) + " schema > '" + schema_file + "'").c_str()),
            0);
  std::ifstream stream(schema_file);
  const std::string schema{std::istreambuf_iterator<char>(stream), {}};
  int graphs = 0;
  for (const char* folder : {ILSS_SOURCE_DIR "/graphs", ILSS_TEST_DATA "/gum"})
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (!name.ends_with(".yaml") || name.find(".study.") != std::string::npos) continue;
      EXPECT_TRUE(accepts(schema, entry.path())) << name << "\n" << errors();
      ++graphs;
    }
  EXPECT_GT(graphs, 8);
}

}  // namespace
}  // namespace ilss
