// What the summary of a run tells.
#include "framework/report/run_summary.h"

#include <gtest/gtest.h>

#include "tests/framework/runtime/test_modules.h"

namespace ilss {
namespace {

using runtime_test::plan_of;

const std::string pair = R"(
modules: {a: {type: counter, std: 0.1, fault_at: 2}, b: {type: counter, std: 0.1}}
network: {combine: [a, b]}
)";

/// The summary of a run of `pair`.
std::string summary_of(RunOptions options, bool samples_verdicts = false) {
  const Plan plan = plan_of(pair);
  ilss::Run run(plan, std::move(options));
  RunSummary summary(plan, samples_verdicts);
  run.add(summary);
  run.finish();
  return summary_text(run, summary);
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(RunSummary, SaysHowManyTicksWereJudgedWhereNotAllWere) {
  const auto first_line = [](const std::string& text) {
    return text.substr(1, text.find('\n', 1));
  };
  EXPECT_EQ(first_line(summary_of({.most_ticks = 3, .judge_every = 1})), "3 ticks\n");
  EXPECT_EQ(first_line(summary_of({.most_ticks = 3, .judge_every = 2})),
            "3 ticks; verdicts on 2 of them\n");
  EXPECT_EQ(first_line(summary_of({.most_ticks = 1, .judge_every = 0})), "1 tick; no verdicts\n");
}

TEST(RunSummary, SamplesVerdictsEverMoreSeldomOnOneOutputAfterAnother) {
  EXPECT_TRUE(has(summary_of({.most_ticks = 1000}, true), "; 10 verdicts, on 10 of them\n"));
  EXPECT_TRUE(has(summary_of({.most_ticks = 1025}, true), "; 11 verdicts, on 11 of them\n"));
  EXPECT_TRUE(has(summary_of({.most_ticks = 1}, true), "1 tick; 1 verdict, on 1 of them\n"));
}

TEST(RunSummary, CountsOutputsAndFaultsAndStatesTheRootMeanSquare) {
  const std::string text = summary_of({.most_ticks = 4});
  EXPECT_TRUE(has(text,
                  "a                           3  1 no_detection                           "
                  "value 0.1\n"))
      << text;
  EXPECT_TRUE(has(text,
                  "b                           4  -                                        "
                  "value 0.1\n"))
      << text;
}

TEST(RunSummary, ComparesNeighboursOfOnePayload) {
  EXPECT_TRUE(
      has(summary_of({.most_ticks = 4}), "a                    b                            3 "));
}

TEST(RunSummary, HasARowOfComputeTimesAModule) {
  const std::string text = summary_of({.most_ticks = 4});
  EXPECT_TRUE(has(text, "\na                           4 ")) << text;
  EXPECT_TRUE(has(text, "\nend to end                  4 ")) << text;
}

}  // namespace
}  // namespace ilss
