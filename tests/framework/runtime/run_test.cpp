// Where a run's ticks come from, when it ends, and who looks on.
#include "framework/runtime/run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <thread>

#include "tests/framework/runtime/test_modules.h"

namespace ilss {
namespace {

using runtime_test::plan_of;

const std::string counting =
    "modules: {a: {type: counter, std: 0.1}, b: {type: increment}}\n"
    "network: {serial: [a, b]}\n";

/// Notes what it sees, and calls a function at every tick.
class Notes final : public Observer {
 public:
  explicit Notes(std::function<void()> action = {}) : action_(std::move(action)) {}

  OutputRange wants_verdicts(const TickView& tick) override {
    return {0, tick.tick() == verdict_at ? tick.outputs() : 0};
  }
  void observe(const TickView& tick) override {
    times.push_back(tick.time());
    judged.push_back(tick.judged().count != 0);
    const Output* output = tick.output(0).output;
    values.push_back(output == nullptr ? NAN : output->estimate.value.at(0));
    if (action_) action_();
  }

  std::int64_t verdict_at = -1;
  std::vector<Time> times;
  std::vector<double> values;
  std::vector<bool> judged;

 private:
  std::function<void()> action_;
};

std::vector<Time> at(const std::vector<double>& seconds) {
  std::vector<Time> times;
  for (const double s : seconds) times.push_back(time_at(s));
  return times;
}

/// What a run of the graph came to, as seen by `notes`.
Ending end_of(const std::string& graph, RunOptions options, Notes& notes) {
  const Plan plan = plan_of(graph);
  ilss::Run run(plan, std::move(options));
  run.add(notes);
  Diagnostics diagnostics;
  EXPECT_TRUE(run.open(diagnostics));
  Ending ending = run.finish();
  EXPECT_EQ(run.ticks(), static_cast<std::int64_t>(notes.times.size()));
  EXPECT_FALSE(run.step()) << "it is over";
  ending.module = nullptr;  // it goes with the plan
  return ending;
}

/// What cannot be opened of a graph, a line each.
std::vector<std::string> open_errors(const std::string& graph, RunOptions options = {}) {
  const Plan plan = plan_of(graph);
  ilss::Run run(plan, std::move(options));
  Diagnostics diagnostics;
  const bool is_open = run.open(diagnostics);
  EXPECT_EQ(is_open, diagnostics.empty());
  std::vector<std::string> lines;
  for (const Diagnostic& diagnostic : diagnostics.sorted())
    lines.push_back(format_diagnostic(diagnostic));
  return lines;
}

TEST(Run, SimulatedTicksAreMultiplesOfThePeriodUpToTheMost) {
  Notes notes;
  const Ending ending = end_of(counting, {.period = duration_of(0.1), .most_ticks = 4}, notes);
  EXPECT_EQ(ending.reason, RunEnd::most_ticks);
  EXPECT_EQ(notes.times, at({0, 0.1, 0.2, 0.3}));
}

TEST(Run, EndsWithTheDataAndTheTickThatFindsOutIsNone) {
  const Plan plan = plan_of(
      "modules: {a: {type: archive, count: 3}, b: {type: increment}}\n"
      "network: {serial: [a, b]}\n");
  ilss::Run run(plan, {});
  Notes notes;
  run.add(notes);
  Diagnostics diagnostics;
  ASSERT_TRUE(run.open(diagnostics));
  const Ending& ending = run.finish();
  EXPECT_EQ(ending.reason, RunEnd::end_of_data);
  ASSERT_NE(ending.module, nullptr);
  EXPECT_EQ(ending.module->name, "a");
  EXPECT_EQ(ending.fault.message, "no more numbers");
  EXPECT_EQ(notes.values, (std::vector<double>{2, 3, 4}));
}

TEST(Run, EndsAfterTheTickInWhichItIsInterrupted) {
  std::atomic<bool> interrupted = false;
  Notes notes([&] { interrupted = notes.times.size() == 3; });
  EXPECT_EQ(end_of(counting, {.interrupted = &interrupted}, notes).reason, RunEnd::interrupted);
  EXPECT_EQ(notes.times.size(), 3U);
}

TEST(Run, IsInterruptedWhileItWaitsForTheRealClock) {
  std::atomic<bool> interrupted = false;
  std::optional<std::jthread> other;
  Notes notes([&] {
    other.emplace([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      interrupted = true;
    });
  });
  const RunOptions options{
      .pacing = Pacing::real, .period = std::chrono::hours(24), .interrupted = &interrupted};
  EXPECT_EQ(end_of(counting, options, notes).reason, RunEnd::interrupted);
  EXPECT_EQ(notes.times.size(), 1U);
}

TEST(Run, NoTickIsBeforeItsPeriodBeginsByTheRealClock) {
  Notes notes;
  const auto begin = std::chrono::steady_clock::now();
  const Duration period = std::chrono::milliseconds(2);
  end_of(counting, {.pacing = Pacing::real, .period = period, .most_ticks = 5}, notes);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 4 * period);
  for (std::size_t i = 0; i < notes.times.size(); ++i)
    EXPECT_GE(notes.times[i], Time(static_cast<int>(i) * period));
}

TEST(Run, CountsThePeriodsThatGoByWhileATickTakesLonger) {
  const Plan plan = plan_of(counting);
  const Duration period = std::chrono::milliseconds(2);
  ilss::Run run(plan, {.pacing = Pacing::real, .period = period, .most_ticks = 2});
  Notes notes([&] { std::this_thread::sleep_for(10 * period); });
  run.add(notes);
  run.finish();
  EXPECT_GE(run.missed_periods(), 9);
  EXPECT_GE(notes.times[1], Time(10 * period));
}

TEST(Run, FollowsTheTimesOfItsData) {
  Notes notes;
  const Ending ending = end_of(
      "modules: {a: {type: archive, from: 100 s, step: 1 s}, b: {type: archive, from: 100.5 s, "
      "step: 2 s}}\nnetwork: {combine: [a, b]}\n",
      {.pacing = Pacing::data}, notes);
  EXPECT_EQ(ending.reason, RunEnd::end_of_data);
  EXPECT_EQ(notes.times, at({100, 100.5, 101, 102}));
}

TEST(Run, FollowsOnlyTheDataThatASelectorAsksFor) {
  Notes notes;
  const Ending ending = end_of(
      "modules: {a: {type: archive, step: 1 s}, b: {type: archive, step: 5 s}, s: {type: switch, "
      "stuck_at: 0}}\nnetwork: {serial: [combine: [a, b], s]}\n",
      {.pacing = Pacing::data, .most_ticks = 100}, notes);
  EXPECT_EQ(ending.reason, RunEnd::end_of_data);
  EXPECT_EQ(notes.values[2], 3);
}

TEST(Run, CannotFollowDataWithoutTimes) {
  EXPECT_EQ(open_errors("ilss: dials\nmodules: {a: {type: dial}}\nnetwork: a\n",
                        {.pacing = Pacing::data}),
            std::vector<std::string>{
                "'dials' cannot follow its data: no module has data with times of their own"});
}

TEST(Run, SaysOfEveryModuleThatCannotBeOpenedWhereItStands) {
  EXPECT_EQ(open_errors("modules:\n"
                        "  a: {type: archive, lost: true}\n"
                        "  b: {type: archive}\n"
                        "  c: {type: archive, throws: true}\n"
                        "network: {combine: [a, b, c]}\n"),
            (std::vector<std::string>{"test.yaml:2:3: 'a': no such archive",
                                      "test.yaml:4:3: 'c': the module threw: the shelf is empty"}));
}

TEST(Run, CommandTimesCountFromTheFirstTickOfALog) {
  const Plan plan = plan_of(
      "modules: {dial: {type: dial}, log: {type: archive, from: 1000 s}}\n"
      "network: {combine: [dial, log]}\ncommands: {set: dial.set, time: dial.time}\n");
  ilss::Run run(plan, {.pacing = Pacing::data, .commands = {{0, 7.0, time_at(1)}}});
  Notes notes([&] {
    if (notes.times.size() == 2) run.schedule({0, 9.0, time_at(2)});
  });
  run.add(notes);
  Diagnostics diagnostics;
  ASSERT_TRUE(run.open(diagnostics));
  run.finish();
  EXPECT_EQ(notes.values, (std::vector<double>{0, 7, 9}));
  EXPECT_EQ(run.waiting_commands(), 0U);
}

TEST(Run, ACommandBeyondAllTimeWaits) {
  const Plan plan = plan_of(
      "modules: {dial: {type: dial}, log: {type: archive}}\n"
      "network: {combine: [dial, log]}\ncommands: {set: dial.set}\n");
  ilss::Run run(plan, {.pacing = Pacing::data, .commands = {{0, 7.0, Time::max()}}});
  Diagnostics diagnostics;
  ASSERT_TRUE(run.open(diagnostics));
  EXPECT_EQ(run.waiting_commands(), 1U);
  run.finish();
  EXPECT_EQ(run.waiting_commands(), 1U);
}

TEST(Run, JudgesOneTickInSoMany) {
  Notes notes;
  end_of(counting, {.most_ticks = 5, .judge_every = 2}, notes);
  EXPECT_EQ(notes.judged, (std::vector<bool>{true, false, true, false, true}));
}

TEST(Run, JudgesTheTicksForWhichAnObserverAsks) {
  Notes notes;
  notes.verdict_at = 1;
  end_of(counting, {.most_ticks = 3}, notes);
  EXPECT_EQ(notes.judged, (std::vector<bool>{false, true, false}));
}

TEST(Run, JudgesNoneWhereThatIsSaidWhoeverAsks) {
  const Plan plan = plan_of(counting);
  ilss::Run run(plan, {.most_ticks = 3, .judge_every = 0});
  Notes notes;
  notes.verdict_at = 1;
  run.add(notes);
  run.finish();
  EXPECT_EQ(run.judged_ticks(), 0);
}

TEST(Run, TwoThreadsGiveWhatOneGives) {
  Notes one;
  Notes two;
  const std::string graph =
      "modules: {a: {type: counter, std: 0.1}, b: {type: counter, std: 1}, "
      "c: {type: subtract}}\nnetwork: {serial: [combine: [a, b], c]}\n";
  end_of(graph, {.most_ticks = 200}, one);
  end_of(graph, {.most_ticks = 200, .threads = 2}, two);
  EXPECT_EQ(one.values, two.values);
}

}  // namespace
}  // namespace ilss
