// A tick as JSON: the fields that programs rely on.
#include "framework/report/tick_json.h"

#include <gtest/gtest.h>

#include "framework/runtime/runner.h"
#include "tests/framework/runtime/test_modules.h"

namespace ilss {
namespace {

using runtime_test::plan_of;

const std::string graph = R"(
modules: {slow: {type: counter, period: 2, delay: 20 ms, std: 0.1}, next: {type: increment}}
network: {serial: [slow, next]}
)";

Json json_of(const std::string& text, int ticks, std::span<const VerdictReport> verdicts = {}) {
  const Plan plan = plan_of(text);
  Runner runner(plan);
  for (int tick = 0; tick < ticks; ++tick) runner.step(time_at(0.1 * tick));
  return tick_json(TickView(runner.system(), {.counts = runner.counts(), .verdicts = verdicts}));
}

TEST(TickJson, HasTheFieldsOfTheContract) {
  const std::vector<VerdictReport> verdicts(1);
  const Json json = json_of(graph, 1, verdicts);
  EXPECT_EQ(json["tick"], 0);
  EXPECT_EQ(json["time"], 0.0);
  EXPECT_EQ(json["outcome"], "output");
  EXPECT_EQ(json["output"]["components"][0]["name"], "value");
  EXPECT_EQ(json["output"]["verdict"], "linear_ok");
  const Json& slow = json["modules"]["slow"];
  EXPECT_EQ(slow["outcome"], "output");
  EXPECT_EQ(slow["age_ns"], 20'000'000);
  EXPECT_EQ(slow["acquired_ns"], (Json{-20'000'000, -20'000'000}));
  EXPECT_TRUE(slow["compute_ns"].is_number_integer());
}

TEST(TickJson, APendingModuleTellsTheAgeOfWhatItGaveLast) {
  const Json json = json_of(graph, 2);
  EXPECT_EQ(json["outcome"], "pending");
  EXPECT_EQ(json["output"], nullptr);
  EXPECT_EQ(json["modules"]["slow"]["age_ns"], 120'000'000);
}

TEST(TickJson, WhatNobodyJudgedHasNoVerdict) {
  const Json json = json_of(graph, 1);
  ASSERT_TRUE(json["output"].contains("verdict"));
  EXPECT_EQ(json["output"]["verdict"], nullptr);
}

TEST(TickJson, AFaultNamesItsModuleInEveryModuleThatInheritsIt) {
  const Json json = json_of(
      "modules: {a: {type: counter, fault_at: 0}, b: {type: increment}}\n"
      "network: {serial: [a, b]}\n",
      1);
  const Json fault = {{"kind", "no_detection"}, {"message", "nothing"}, {"module", "a"}};
  EXPECT_EQ(json["outcome"], "fault");
  EXPECT_EQ(json["fault"], fault);
  EXPECT_EQ(json["modules"]["b"]["fault"], fault);
  EXPECT_EQ(json["modules"]["b"]["age_ns"], nullptr);
  EXPECT_EQ(json["modules"]["b"]["acquired_ns"], nullptr);
}

}  // namespace
}  // namespace ilss
