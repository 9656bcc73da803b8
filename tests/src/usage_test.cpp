// What the command says of bad usage: one line after its name, exit status 2, nothing done.
#include <gtest/gtest.h>

#include "command.h"

namespace ilss {
namespace {

/// The call is bad usage, and its first line of errors is this.
void expect_bad_usage(const std::string& arguments, const std::string& message) {
  const Heard heard = call_command(arguments);
  EXPECT_EQ(heard.status, 2) << arguments;
  EXPECT_EQ(heard.output, "") << arguments;
  EXPECT_EQ(heard.errors.substr(0, heard.errors.find('\n')), message) << arguments;
}

TEST(Usage, UnknownCommandIsNamedWithTheNearestOne) {
  expect_bad_usage("Run x", "ilss: unknown command 'Run'; did you mean 'run'?");
  expect_bad_usage("xyzzy", "ilss: unknown command 'xyzzy'");
}

TEST(Usage, MessagesBeginWithTheCommandsName) {
  expect_bad_usage("", "ilss: A subcommand is required");
  expect_bad_usage("run", "ilss: GRAPH is required");
}

TEST(Usage, SeedOutOfRangeIsRefusedNotWrapped) {
  const std::string range = " is not a whole number from 0 to 18446744073709551615";
  expect_bad_usage("run graphs/sonar_ring.yaml --seed -1", "ilss: --seed: '-1'" + range);
  expect_bad_usage("run graphs/sonar_ring.yaml --seed 18446744073709551616",
                   "ilss: --seed: '18446744073709551616'" + range);
  expect_bad_usage("compare graphs/wall_pose_scene.study.yaml --seed -1",
                   "ilss: --seed: '-1'" + range);
}

TEST(Usage, LargestSeedIsTaken) {
  EXPECT_EQ(call_command("run graphs/sonar_ring.yaml --quiet --ticks 1 --seed 18446744073709551615")
                .status,
            0);
}

TEST(Usage, TicksOutOfRangeAreRefused) {
  const std::string range = " is not a whole number from 0 to 9223372036854775807";
  expect_bad_usage("run graphs/sonar_ring.yaml --ticks -1", "ilss: --ticks: '-1'" + range);
  expect_bad_usage("run graphs/sonar_ring.yaml --ticks 9223372036854775808",
                   "ilss: --ticks: '9223372036854775808'" + range);
  expect_bad_usage("run graphs/sonar_ring.yaml --ticks 1.5", "ilss: --ticks: '1.5'" + range);
}

TEST(Usage, LeadingZeroDoesNotMakeTicksOctal) {
  const Heard heard = call_command("run graphs/sonar_ring.yaml --quiet --ticks 010");
  EXPECT_EQ(heard.output.substr(0, 10), "\n10 ticks;");
}

TEST(Usage, RunsOutOfRangeAreRefused) {
  const std::string range = " is not a whole number from 1 to 1000000000";
  expect_bad_usage("compare graphs/wall_pose_scene.study.yaml --runs 0",
                   "ilss: --runs: '0'" + range);
  expect_bad_usage("compare graphs/wall_pose_scene.study.yaml --runs 4294967297",
                   "ilss: --runs: '4294967297'" + range);
}

TEST(Usage, PeriodMustBeAboveZeroAndAtMostAMillionSeconds) {
  const std::string message = "ilss: --period must be above 0 and at most 1000000 s";
  expect_bad_usage("run graphs/sonar_ring.yaml --period '0 s'", message);
  expect_bad_usage("run graphs/sonar_ring.yaml --period '1000001 s'", message);
  EXPECT_EQ(
      call_command("run graphs/sonar_ring.yaml --quiet --ticks 2 --period '1000000 s'").status, 0);
}

TEST(Usage, PeriodHasNoPlaceWhereALogGivesTheTicks) {
  expect_bad_usage("run graphs/laser_features.yaml --time log --period '1 s'",
                   "ilss: --period: with --time log the data say when the ticks are");
}

TEST(Usage, JsonLinesCannotBeQuiet) {
  expect_bad_usage("run graphs/sonar_ring.yaml --json --quiet", "ilss: --quiet excludes --json");
}

TEST(Usage, ProfileNeedsAFileThatCanBeWritten) {
  expect_bad_usage("run graphs/sonar_ring.yaml --profile ''",
                   "ilss: --profile: the file's name is empty");
  expect_bad_usage("run graphs/sonar_ring.yaml --profile /no/such/folder/profile.yaml",
                   "ilss: --profile: cannot write '/no/such/folder/profile.yaml': No such file or "
                   "directory");
}

}  // namespace
}  // namespace ilss
