// A tick as people read it.
#include "framework/report/tick_text.h"

#include <gtest/gtest.h>

#include "framework/runtime/runner.h"
#include "tests/framework/runtime/test_modules.h"

namespace ilss {
namespace {

using runtime_test::plan_of;

/// The last of so many ticks of 0.1 s as text, with verdicts where there are any.
std::string text_of(const std::string& graph, int ticks, const std::vector<Verdict>& verdicts = {},
                    std::optional<ScheduledCommand> command = {}) {
  const Plan plan = plan_of(graph);
  Runner runner(plan);
  if (command) runner.schedule(*command);
  for (int tick = 0; tick < ticks; ++tick) runner.step(time_at(0.1 * tick));
  std::vector<VerdictReport> reports;
  for (const Verdict verdict : verdicts) reports.push_back({.verdict = verdict});
  return tick_text(
      TickView(runner.system(), {.verdicts = reports, .commands = runner.commander().given()}));
}

const std::string one = "modules: {a: {type: counter, fault_at: 1}}\nnetwork: a\n";
const std::string two =
    "modules: {a: {type: counter}, b: {type: counter, period: 2}}\n"
    "network: {combine: [a, b]}\n";
const std::string five =
    "modules: {a: {type: counter}, b: {type: counter}, c: {type: counter}, d: "
    "{type: counter}, e: {type: counter, fault_at: 0}}\n"
    "network: {combine: [a, b, c, d, e]}\n";

TEST(TickText, OneOutputStandsOnTheTicksLine) {
  EXPECT_EQ(text_of(one, 1), "     0     0.000 s  value 1.000 ± 0.000\n");
}

TEST(TickText, AFaultSaysWhichModuleAndWhy) {
  EXPECT_EQ(text_of(one, 2), "     1     0.100 s  no_detection in a: nothing\n");
}

TEST(TickText, FewOutputsHaveALineEach) {
  EXPECT_EQ(text_of(two, 2),
            "     1     0.100 s\n"
            "         a                    value 2.000 ± 0.000\n"
            "         b                    pending\n");
}

TEST(TickText, ManyOutputsAreCounted) {
  EXPECT_EQ(text_of(five, 1), "     0     0.000 s  4 of 5 outputs\n");
}

TEST(TickText, VerdictsThatAreNotLinearAreMarkedOrCounted) {
  EXPECT_EQ(text_of(one, 1, {Verdict::second_order}),
            "     0     0.000 s  value 1.000 ± 0.000  ~ second_order\n");
  EXPECT_EQ(text_of(one, 1, {Verdict::invalid}),
            "     0     0.000 s  value 1.000 ± 0.000  ! invalid\n");
  EXPECT_EQ(text_of(one, 1, {Verdict::linear_ok}), text_of(one, 1));
  EXPECT_EQ(text_of(five, 1,
                    {Verdict::linear_ok, Verdict::second_order, Verdict::invalid,
                     Verdict::second_order, Verdict::invalid}),
            "     0     0.000 s  4 of 5 outputs (2 second_order, 1 invalid)\n")
      << "the fault has no verdict";
}

TEST(TickText, CommandsGivenBeforeATickComeFirst) {
  EXPECT_EQ(text_of("modules: {dial: {type: dial}}\nnetwork: dial\ncommands: {turn: dial.set}\n", 1,
                    {}, ScheduledCommand{0, -1.0, {}}),
            "           0.000 s  command turn = -1: refused: below zero\n"
            "     0     0.000 s  value 0.000 ± 0.000\n");
}

}  // namespace
}  // namespace ilss
