// `ilss eval` of modules whose inputs follow from their parameters.
#include <gtest/gtest.h>

#include "command.h"
#include "framework/graph/given_outputs.h"

namespace ilss {
namespace {

constexpr const char* difference =
    "eval expression --json --param 'inputs=[a, b]' --param 'quantities={k: 2}' "
    "--param 'output={y: {unit: m, formula: a - k * b.range}}' ";

TEST(Eval, ExpressionTakesInputsByNameInAnyOrder) {
  const std::string a = "--input 'a={type: wall_range, range: {value: 3 m, std: 3 mm}}' ";
  const std::string b = "--input 'b={type: wall_range, range: {value: 1 m, std: 2 mm}}' ";
  const Heard one = call_command(difference + a + b);
  const Heard other = call_command(difference + b + a);
  EXPECT_EQ(one.status, 0) << one.errors;
  EXPECT_EQ(one.output, other.output);
  EXPECT_NE(one.output.find("\"value\": 1.0,\n        \"std\": 0.005"), std::string::npos)
      << one.output;
}

TEST(Eval, InputOfAnyPayloadMustSayWhich) {
  const Heard heard = call_command(std::string(difference) +
                                   "--input 'a={range: 3 m}' --input 'b={type: wall_rang}'");
  EXPECT_EQ(heard.status, 2);
  EXPECT_EQ(heard.errors,
            "--input a={range: 3 m}:1:1: input 'a' takes any payload; say which one this is: "
            "--input 'a={type: PAYLOAD, ...}'\n"
            "--input b={type: wall_rang}:1:8: there is no payload 'wall_rang'\n");
}

TEST(Eval, PayloadOfAnInputThatTakesOneOnlyMustAgree) {
  const Heard heard = call_command("eval vision_line --input 'rows={type: wall_range}'");
  EXPECT_EQ(heard.status, 2);
  EXPECT_NE(heard.errors.find("--input rows={type: wall_range}:1:8: input 'rows' takes "
                              "target_rows, not wall_range\n"),
            std::string::npos)
      << heard.errors;
}

TEST(Eval, RepeatedInputIsGivenSeveralTimes) {
  const Heard heard = call_command(
      "eval fuse --json --input 'estimates={type: wall_range, range: {value: 1 m, std: 1 mm}}' "
      "--input 'estimates={type: wall_range, range: {value: 1.002 m, std: 1 mm}}'");
  EXPECT_EQ(heard.status, 0) << heard.errors;
  EXPECT_NE(heard.output.find("\"value\": 1.001,"), std::string::npos) << heard.output;
}

TEST(Eval, InputThatDoesNotRepeatIsGivenOnce) {
  const Heard heard = call_command(std::string(difference) +
                                   "--input 'a={type: wall_range, range: 3 m}' --input "
                                   "'a={type: wall_range, range: 3 m}'");
  EXPECT_EQ(heard.status, 2);
  EXPECT_NE(heard.errors.find("input 'a' is given twice"), std::string::npos);
}

TEST(Eval, DivisionByZeroIsAFaultInWords) {
  const Heard heard = call_command(
      "eval expression --param 'quantities={x: 0 m}' "
      "--param 'output={y: {unit: 1, formula: x / x}}'");
  EXPECT_EQ(heard.output,
            "fault not_finite: formula of 'y' has no finite value at x = 0 m: it divides by "
            "zero\n");
}

TEST(Predict, DivisionByZeroAtTheOperatingPointIsReported) {
  const std::filesystem::path graph = test_file("zero.yaml");
  std::ofstream(graph)
      << "modules: {f: {type: expression, quantities: {x: {value: 0 m, std: 1 m}}, "
         "output: {q: {unit: 1, formula: x / x}}}}\nnetwork: f\n";
  const Heard heard = call_command("predict '" + graph.string() + "'");
  EXPECT_EQ(heard.status, 1);
  EXPECT_EQ(heard.output, "");
  EXPECT_EQ(heard.errors.substr(0, heard.errors.find('\n')),
            "ilss: no prediction of 'f': 'f': formula of 'q' has no finite value at x = 0 m: it "
            "divides by zero (not_finite)");
  std::filesystem::remove(graph);
}

}  // namespace
}  // namespace ilss
