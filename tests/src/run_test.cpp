// What `ilss run` shows of outputs and verdicts, and how Ctrl-C ends it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <regex>

#include "command.h"

namespace ilss {
namespace {

TEST(RunText, MarksOutputsWhoseErrorIsNotLinear) {
  const Heard heard = call_command("run graphs/wall_pose_vision.yaml --ticks 2");
  ASSERT_EQ(heard.status, 0) << heard.errors;
  EXPECT_TRUE(std::regex_search(heard.output, std::regex("     1 .* z2 .* mm  ~ second_order\n")))
      << heard.output;
  EXPECT_NE(heard.output.find("   (2 second_order)\n"), std::string::npos) << heard.output;
}

TEST(RunText, QuietSummaryCountsVerdicts) {
  const Heard heard = call_command("run graphs/wall_pose_vision.yaml --ticks 2 --quiet");
  ASSERT_EQ(heard.status, 0) << heard.errors;
  EXPECT_NE(heard.output.find("   (2 second_order)\n"), std::string::npos) << heard.output;
}

TEST(RunText, LinearOutputsHaveNoMark) {
  const Heard heard = call_command("run graphs/wall_pose_sonar.yaml --ticks 2");
  ASSERT_EQ(heard.status, 0) << heard.errors;
  EXPECT_EQ(heard.output.find("linear_ok"), std::string::npos) << heard.output;
  EXPECT_EQ(heard.output.find("second_order"), std::string::npos) << heard.output;
}

TEST(RunText, FewOutputsAreShownOneALine) {
  const std::filesystem::path graph = test_file("graph.yaml");
  std::ofstream(graph) << R"(ilss: two_sonars
modules:
  left: {type: sonar, range_std: 2 mm, no_echo: 5 m, input: {values: [{range: 5 m}]}}
  right: {type: sonar, range_std: 2 mm, no_echo: 5 m, input: {values: [{range: 1.01 m}]}}
network: {combine: [left, right]}
)";
  const Heard heard = call_command("run '" + graph.string() + "'");
  std::filesystem::remove(graph);
  ASSERT_EQ(heard.status, 0) << heard.errors;
  EXPECT_TRUE(std::regex_search(
      heard.output, std::regex("^     0     0.000 s\n"
                               "         left                 no_detection in left: .*\n"
                               "         right                range 1010.0 ± 2.0 mm .*\n")))
      << heard.output;
}

TEST(RunText, ManyOutputsAreCounted) {
  const Heard heard = call_command("run graphs/sonar_ring.yaml --ticks 1");
  EXPECT_TRUE(std::regex_search(heard.output,
                                std::regex("^     0     0.000 s  20 of 24 outputs \\([0-9]+ ")))
      << heard.output;
}

TEST(RunVerdict, OfOneTickInNHasAVerdictInTheFirstOnly) {
  const Heard heard = call_command("run graphs/wall_pose_vision.yaml --ticks 2 --json --verdict 2");
  ASSERT_EQ(heard.status, 0) << heard.errors;
  const auto end = heard.output.find('\n');
  EXPECT_NE(heard.output.substr(0, end).find("\"verdict\":\"second_order\""), std::string::npos);
  EXPECT_NE(heard.output.substr(end).find("\"verdict\":null"), std::string::npos);
}

TEST(RunVerdict, OffIsSaidInTheSummary) {
  const Heard heard = call_command("run graphs/wall_pose_vision.yaml --ticks 2 --verdict off");
  EXPECT_EQ(heard.output.find("second_order"), std::string::npos) << heard.output;
  EXPECT_NE(heard.output.find("\n2 ticks; no verdicts\n"), std::string::npos) << heard.output;
}

TEST(RunVerdict, QuietRunsJudgeEverFewerTicks) {
  const Heard heard = call_command("run graphs/wall_pose_sonar.yaml --ticks 100 --quiet");
  EXPECT_NE(heard.output.find("\n100 ticks; verdicts on 7 of them\n"), std::string::npos)
      << heard.output;
}

TEST(RunVerdict, AProfileIsMeasuredWithoutAny) {
  const auto profile = test_file("profile.yaml");
  const Heard heard = call_command("run graphs/wall_pose_sonar.yaml --ticks 3 --quiet --profile '" +
                                   profile.string() + "'");
  std::filesystem::remove(profile);
  EXPECT_NE(heard.output.find("\n3 ticks; no verdicts\n"), std::string::npos) << heard.output;
}

TEST(RunTime, OfALogGivesEveryTickTheTimeOfItsData) {
  const Heard heard =
      call_command("run graphs/laser_features.yaml --ticks 3 --time log --json --verdict off");
  ASSERT_EQ(heard.status, 0) << heard.errors;
  const std::regex laser("\"laser\":\\{\"outcome\":\"output\",\"compute_ns\":[0-9]+,\"age_ns\":0,");
  const auto begin = std::sregex_iterator(heard.output.begin(), heard.output.end(), laser);
  EXPECT_EQ(std::distance(begin, std::sregex_iterator()), 3) << heard.output;
  EXPECT_EQ(heard.output.find("\"time\":0.0,"), std::string::npos) << "the log's stamps are later";
}

TEST(RunTime, OfALogNeedsDataWithTimes) {
  const Heard heard = call_command("run graphs/wall_pose_sonar.yaml --time log");
  EXPECT_EQ(heard.status, 2);
  EXPECT_EQ(heard.errors,
            "ilss: 'wall_pose_sonar' cannot follow its data: no module has data with times of "
            "their own\n");
}

TEST(RunThreads, TwoGiveTheSameOutputsForEveryGraphThatShips) {
  int graphs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ILSS_SOURCE_DIR "/graphs")) {
    const std::string file = entry.path().filename().string();
    if (!file.ends_with(".yaml") || file.ends_with(".study.yaml")) continue;
    SCOPED_TRACE(file);
    const auto outputs = [&](const std::string& options) {
      const Heard heard =
          call_command("run graphs/" + file + " --ticks 5 --json --verdict off " + options);
      EXPECT_EQ(heard.status, 0) << heard.errors;
      return std::regex_replace(heard.output, std::regex("\"compute_ns\":[0-9]+"), "");
    };
    EXPECT_EQ(outputs("--threads 2"), outputs(""));
    ++graphs;
  }
  EXPECT_GE(graphs, 10);
}

/// A graph of the test's own in which two of three recordings are missing.
class GraphWithoutItsData : public testing::Test {
 protected:
  GraphWithoutItsData() {
    std::ofstream(graph_)
        << "ilss: lost\n"
           "modules:\n"
           "  a: {type: sonar, range_std: 2 mm, input: {csv: {file: /no/a.csv, "
           "column: A}}}\n"
           "  b: {type: sonar, range_std: 2 mm, input: {values: [{range: 1 m}]}}\n"
           "  c: {type: sonar, range_std: 2 mm, input: {csv: {file: /no/c.csv, "
           "column: C}}}\n"
           "network: {combine: [a, b, c]}\n";
  }
  ~GraphWithoutItsData() override { std::filesystem::remove(graph_); }

  void expect_both_reported(const std::string& arguments) const {
    const Heard heard = call_command(arguments + " '" + graph_.string() + "'");
    EXPECT_EQ(heard.status, 2);
    EXPECT_EQ(heard.output, "");
    EXPECT_EQ(heard.errors.find(graph_.string() + ":3:3: 'a': "), 0U) << heard.errors;
    EXPECT_NE(heard.errors.find("\n" + graph_.string() + ":5:3: 'c': "), std::string::npos)
        << heard.errors;
  }
  std::filesystem::path graph_ = test_file("graph.yaml");
};

TEST_F(GraphWithoutItsData, IsNoStartForARun) { expect_both_reported("run"); }

TEST_F(GraphWithoutItsData, IsReportedByACheckThatOpens) { expect_both_reported("check --open"); }

TEST_F(GraphWithoutItsData, IsFineForACheckThatDoesNot) {
  EXPECT_EQ(call_command("check '" + graph_.string() + "'").status, 0);
}

TEST(RunText, OneTickIsSingular) {
  const Heard heard = call_command("run graphs/sonar_ring.yaml --quiet --ticks 1");
  EXPECT_EQ(heard.output.substr(0, 8), "\n1 tick;");
}

TEST(RunProfile, IsLeftAsItIsWhereTheRunDoesNotStart) {
  const auto profile = test_file("profile.yaml");
  std::ofstream(profile) << "precious";
  EXPECT_EQ(call_command("run /no/such/graph.yaml --profile '" + profile.string() + "'").status, 2);
  EXPECT_EQ(text_of(profile), "precious");
  std::filesystem::remove(profile);
}

/// An endless run whose standard output is a pipe of the test's.
class EndlessRun {
 public:
  EndlessRun() : errors_(test_file("errors")) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) std::abort();
    process_ = fork();
    if (process_ == 0) {
      dup2(ends[1], STDOUT_FILENO);
      close(ends[0]);
      close(ends[1]);
      if (std::freopen(errors_.c_str(), "w", stderr) == nullptr) _exit(127);
      execl(ILSS_COMMAND, "ilss", "run", ILSS_SOURCE_DIR "/graphs/wall_pose_sonar.yaml", "--ticks",
            "0", nullptr);
      _exit(127);
    }
    close(ends[1]);
    read_end_ = ends[0];
  }
  ~EndlessRun() {
    if (process_ > 0) {
      kill(process_, SIGKILL);
      waitpid(process_, nullptr, 0);
    }
    close(read_end_);
    std::filesystem::remove(errors_);
  }
  EndlessRun(const EndlessRun&) = delete;
  EndlessRun& operator=(const EndlessRun&) = delete;

  /// Waits until the pipe is full, so that the run cannot get on: false where it never is.
  bool wait_until_stuck() const {
    for (int i = 0; i < 1000; ++i) {
      int unread = 0;
      if (ioctl(read_end_, FIONREAD, &unread) == 0 && unread >= fcntl(read_end_, F_GETPIPE_SZ))
        return true;
      usleep(10'000);
    }
    return false;
  }
  void interrupt() const { kill(process_, SIGINT); }
  /// Waits for output, so that the run is under way; empty at the end.
  std::string read_some() const {
    std::array<char, 4096> buffer{};
    const ssize_t size = read(read_end_, buffer.data(), buffer.size());
    return {buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
  }
  /// The wait status, once the run has ended.
  std::optional<int> ended() {
    int status = 0;
    if (waitpid(process_, &status, WNOHANG) == 0) return std::nullopt;
    process_ = -1;
    return status;
  }
  int wait_for_end() {
    int status = 0;
    waitpid(process_, &status, 0);
    process_ = -1;
    return status;
  }
  std::string errors() const { return text_of(errors_); }

 private:
  std::filesystem::path errors_;
  pid_t process_ = -1;
  int read_end_ = -1;
};

TEST(RunInterrupt, FirstEndsTheRunWithItsSummary) {
  EndlessRun run;
  std::string output = run.read_some();
  run.interrupt();
  for (std::string more = run.read_some(); !more.empty(); more = run.read_some()) output += more;
  const int status = run.wait_for_end();
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_NE(output.find("\nend to end "), std::string::npos);
  EXPECT_TRUE(std::regex_match(run.errors(), std::regex("ilss: interrupted after [0-9]+ ticks?\n")))
      << run.errors();
}

TEST(RunInterrupt, SecondEndsARunThatHangs) {
  EndlessRun run;
  ASSERT_TRUE(run.wait_until_stuck());
  std::optional<int> status;
  for (int i = 0; i < 1000 && !status; ++i) {
    run.interrupt();
    usleep(20'000);
    status = run.ended();
  }
  ASSERT_TRUE(status) << "still there";
  ASSERT_TRUE(WIFSIGNALED(*status));
  EXPECT_EQ(WTERMSIG(*status), SIGINT);
}

}  // namespace
}  // namespace ilss
