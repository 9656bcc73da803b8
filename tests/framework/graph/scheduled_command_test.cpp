// Commands as users write them on a command line.
#include "framework/graph/scheduled_command.h"

#include <gtest/gtest.h>

#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

constexpr double degree = 0.017453292519943295;

const Plan& plan() {
  static const Plan result = test::plan_of(R"(
modules: {head: {type: head}}
network: head
commands: {look_at: head.rotate_to, zoom: head.zoom, sweeps: head.sweeps, light: head.light, label: head.label, mode: head.mode}
)");
  return result;
}

/// The command that the text gives; what is wrong fails the test.
ScheduledCommand read(const std::string& text) {
  Diagnostics diagnostics;
  const auto command = parse_command(text, plan(), "--command", diagnostics);
  EXPECT_EQ(test::messages(diagnostics), "");
  return command.value_or(ScheduledCommand{});
}

std::string error_of(const std::string& text) {
  Diagnostics diagnostics;
  EXPECT_FALSE(parse_command(text, plan(), "--command", diagnostics)) << text;
  return test::messages(diagnostics);
}

TEST(ScheduledCommand, IsAQuantityInSiAtATime) {
  const ScheduledCommand command = read("look_at=30 deg@1.5 s");
  EXPECT_EQ(command.command, 0U);
  EXPECT_DOUBLE_EQ(std::get<double>(command.value), 30 * degree);
  EXPECT_EQ(command.time, time_at(1.5));
}

TEST(ScheduledCommand, WithoutATimeIsForTheStart) { EXPECT_EQ(read("zoom=2").time, time_at(0)); }

TEST(ScheduledCommand, HasAValueOfEachDeclaredKind) {
  EXPECT_EQ(read("zoom=2.5@200 ms").value, CommandValue(2.5));
  EXPECT_EQ(read("zoom=2.5@200 ms").time, time_at(0.2));
  EXPECT_EQ(read("sweeps=-3").value, CommandValue(std::int64_t{-3}));
  EXPECT_EQ(read("light=true").value, CommandValue(true));
  EXPECT_EQ(read("label=top left").value, CommandValue(std::string("top left")));
  EXPECT_EQ(read("label=3").value, CommandValue(std::string("3")));
  EXPECT_EQ(read("mode=far").value, CommandValue(std::string("far")));
}

TEST(ScheduledCommand, IsSplitAtTheFirstEqualsSignAndTheLastAt) {
  const ScheduledCommand command = read("label=a=b@c@2 s");
  EXPECT_EQ(command.value, CommandValue(std::string("a=b@c")));
  EXPECT_EQ(command.time, time_at(2));
}

TEST(ScheduledCommand, TellsAnUnknownNameWhatThereIs) {
  EXPECT_EQ(error_of("lok_at=3 deg"),
            "--command: there is no command 'lok_at'; did you mean 'look_at'?; the system has "
            "look_at, an angle (rad); zoom, a number; sweeps, an integer; light, true or "
            "false; label, a text; mode, one of near, far\n");
}

TEST(ScheduledCommand, ValueMustFitTheDeclaration) {
  EXPECT_EQ(error_of("look_at=30"), "--command: '30' has no unit; expected an angle (rad)\n");
  EXPECT_EQ(error_of("look_at=30 mm"), "--command: 'mm' is not an angle (rad)\n");
  EXPECT_EQ(error_of("look_at={value: 30 deg, std: 1 deg}"),
            "--command: expected an angle (rad), got a map\n");
  EXPECT_EQ(error_of("zoom=2 m"), "--command: 'm' is not a pure number\n");
  EXPECT_EQ(error_of("sweeps=2.5"), "--command: expected an integer, got '2.5'\n");
  EXPECT_EQ(error_of("light=yes"), "--command: expected true or false, got 'yes'\n");
  EXPECT_EQ(error_of("label=[1]"), "--command: expected a text, got a list\n");
  EXPECT_EQ(error_of("mode=fat"),
            "--command: expected one of near, far, got 'fat'; did you mean 'far'?\n");
}

TEST(ScheduledCommand, TimeMustBeOneFromZeroUp) {
  EXPECT_EQ(error_of("zoom=2@1"), "--command: time: '1' has no unit; expected a time (s)\n");
  EXPECT_EQ(error_of("zoom=2@1 m"), "--command: time: 'm' is not a time (s)\n");
  EXPECT_EQ(error_of("zoom=2@-1 s"), "--command: the time of a command cannot be negative\n");
  EXPECT_NE(error_of("zoom=2@"), "");
  EXPECT_NE(error_of("zoom=2@nan s"), "");
  EXPECT_NE(error_of("zoom=2@inf s"), "");
}

TEST(ScheduledCommand, NeedsANameAndAValue) {
  for (const char* text : {"", "zoom", "=2", "zoom=", "zoom=~", "@1 s", "zoom=@1 s"})
    EXPECT_NE(error_of(text).find("expected NAME=VALUE or NAME=VALUE@TIME, got '"),
              std::string::npos)
        << text;
}

TEST(ScheduledCommand, AllMistakesOfOneAreReported) {
  EXPECT_EQ(error_of("mode=fat@1 m"),
            "--command: expected one of near, far, got 'fat'; did you mean 'far'?\n"
            "--command: time: 'm' is not a time (s)\n");
}

}  // namespace
}  // namespace ilss
