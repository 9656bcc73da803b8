// Predicted times over networks: sums, longest branches, shared modules.
#include "framework/semantics/time_prediction.h"

#include <gtest/gtest.h>

#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

using test::plan_of;
using Names = std::vector<std::string>;

Names names(const Plan& plan, const std::vector<std::size_t>& nodes) {
  Names result;
  for (const std::size_t node : nodes) result.push_back(plan.nodes[node].name);
  return result;
}

constexpr const char* chain = R"(
modules: {a: {type: reading, time: {typical: 1 ms, worst: 4 ms}}, b: {type: sine, time: 2 ms}, c: {type: sine, time: 3 ms}}
network: {serial: [a, b, c]}
)";

/// `shared` feeds both branches; up is typically slower, down at worst.
constexpr const char* branches = R"(
modules:
  shared: {type: reading, time: 10 ms}
  up: {type: sine, time: {typical: 5 ms, worst: 6 ms}}
  down: {type: sine, time: {typical: 2 ms, worst: 20 ms}}
  end: {type: add, time: 1 ms}
network: {serial: [shared, combine: [up, down], end]}
)";

TEST(TimePrediction, OfSerialIsTheSum) {
  const Plan plan = plan_of(chain);
  for (const Execution execution : {Execution::one_thread, Execution::parallel}) {
    const TimePrediction time = predict_time(plan, execution);
    EXPECT_DOUBLE_EQ(time.typical, 0.006);
    EXPECT_DOUBLE_EQ(time.worst, 0.009);
    EXPECT_EQ(names(plan, time.critical_path), (Names{"a", "b", "c"}));
    EXPECT_TRUE(time.unknown.empty());
  }
}

TEST(TimePrediction, OfCombineIsTheSumInOneThreadAndASharedModuleCountsOnce) {
  const TimePrediction time = predict_time(plan_of(branches), Execution::one_thread);
  EXPECT_DOUBLE_EQ(time.typical, 0.018);
  EXPECT_DOUBLE_EQ(time.worst, 0.037);
}

TEST(TimePrediction, OfCombineIsTheLongestBranchInParallel) {
  const Plan plan = plan_of(branches);
  const TimePrediction time = predict_time(plan, Execution::parallel);
  EXPECT_DOUBLE_EQ(time.typical, 0.016);
  EXPECT_DOUBLE_EQ(time.worst, 0.031);
  EXPECT_EQ(names(plan, time.critical_path), (Names{"shared", "down", "end"}));
}

TEST(TimePrediction, OfSeveralOutputsIsThatOfTheLatest) {
  const Plan plan = plan_of(R"(
modules: {a: {type: reading, time: 1 ms}, b: {type: reading, time: 7 ms}, c: {type: reading, time: 3 ms}}
network: {combine: [a, b, c]}
)");
  const TimePrediction time = predict_time(plan, Execution::parallel);
  EXPECT_DOUBLE_EQ(time.worst, 0.007);
  EXPECT_EQ(names(plan, time.critical_path), Names{"b"});
  EXPECT_DOUBLE_EQ(predict_time(plan, Execution::one_thread).worst, 0.011);
}

TEST(TimePrediction, CountsTimesThatAreNotKnownAsZeroAndSaysSo) {
  const Plan plan = plan_of(R"(
modules: {a: {type: reading}, b: {type: sine, time: 2 ms}, c: {type: sine}}
network: {serial: [a, b, c]}
)");
  const TimePrediction time = predict_time(plan, Execution::parallel);
  EXPECT_DOUBLE_EQ(time.worst, 0.002);
  EXPECT_EQ(names(plan, time.unknown), (Names{"a", "c"}));
  EXPECT_EQ(names(plan, time.critical_path), (Names{"a", "b", "c"}));
}

}  // namespace
}  // namespace ilss
