#include "sensors/laser/acquire/laser_log.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>

#include "sensors/laser/scan_points.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

std::filesystem::path written(const std::string& name, const std::string& text) {
  const auto path = std::filesystem::temp_directory_path() / name;
  std::ofstream(path) << text;
  return path;
}

LaserLog log_of(const std::filesystem::path& path) {
  LaserLog::Options options;
  options.file = path;
  return LaserLog(options);
}

/// A tick of a log whose laser stands in the robot's origin.
Tick tick_of(std::int64_t number = 0) {
  return {.parameters = Estimate(descriptor<LaserLog::Parameters>()), .tick = number};
}

const std::string two_scans =
    "PARAM laser front\n"
    "FLASER 3 1 81.9 3 0 0 0 0 0 0 1 h 1\n"
    "FLASER 3 4 5 0 0 0 0 0 0 0 2 h 2\n";

TEST(LaserLog, GivesAScanATickAndThenEnds) {
  LaserLog log = log_of(written("laser_log_two.log", two_scans));
  const ModuleRun first = run(log, tick_of());
  ASSERT_TRUE(first.outcome);
  const auto beams = beams_of(first.output);
  ASSERT_EQ(beams.size(), 3U);
  EXPECT_DOUBLE_EQ(beams[0].range, 1);
  EXPECT_DOUBLE_EQ(beams[1].range, 0) << "81.9 m is SICK's code for no return";
  EXPECT_NEAR(beams[2].bearing, std::numbers::pi / 2, 1e-12);
  const ModuleRun second = run(log, tick_of(1));
  ASSERT_TRUE(second.outcome);
  EXPECT_DOUBLE_EQ(beams_of(second.output)[2].range, 0) << "0 is no range";
  EXPECT_EQ(fault_of(run(log, tick_of(2)).outcome), "end_of_data");
  log.reset();
  EXPECT_TRUE(run(log, tick_of()).outcome);
}

TEST(LaserLog, ABadScanHasItsTurnWithTheOneBeforeItOrTheFirstThatCanBeRead) {
  const std::string bad = "FLASER 3 1 x 3 0 0 0 0 0 0 9 h 9\n";
  LaserLog log = log_of(written("laser_log_bad_times.log", bad + two_scans + bad));
  ASSERT_TRUE(log.open());
  std::vector<std::string> outcomes;
  std::vector<double> times;
  for (int i = 0; i < 4; ++i) {
    const auto time = log.next_time();
    ASSERT_TRUE(time) << i;
    times.push_back(seconds(*time));
    outcomes.push_back(fault_of(run(log, tick_of(i)).outcome));
  }
  EXPECT_EQ(times, (std::vector<double>{1, 1, 2, 2}));
  EXPECT_EQ(outcomes, (std::vector<std::string>{"bad_data", "output", "output", "bad_data"}));
  EXPECT_FALSE(log.next_time());
}

TEST(LaserLog, ScansCarryTheMountWithItsSources) {
  LaserLog log = log_of(written("laser_log_mount.log", two_scans));
  Tick tick = tick_of();
  tick.parameters.value = {0.2, -0.1, 0.3};
  tick.parameters.lineage.add({7, 0, persistent_tick}, std::array{0.01, 0.0, 0.02});
  tick.parameters.lineage.add({8, 0, persistent_tick}, 1, 0.03);
  for (int scan = 0; scan < 2; ++scan) {
    const ModuleRun result = run(log, tick);
    ASSERT_TRUE(result.outcome);
    const auto carried = payload_of<LaserScan>(result.output.estimate);
    EXPECT_EQ(carried.mount_x, 0.2);
    EXPECT_EQ(carried.mount_z, -0.1);
    EXPECT_EQ(carried.mount_heading, 0.3);
    const Lineage& lineage = result.output.estimate.lineage;
    ASSERT_EQ(lineage.size(), 2U) << "at every tick the same two";
    EXPECT_EQ(lineage.sources()[0], (Source{7, 0, persistent_tick}));
    EXPECT_DOUBLE_EQ(lineage.standard_deviation(first_mount), 0.01);
    EXPECT_DOUBLE_EQ(lineage.standard_deviation(first_mount + 1), 0.03);
    EXPECT_DOUBLE_EQ(lineage.standard_deviation(first_mount + 2), 0.02);
    EXPECT_EQ(uncertain_biases(result.output.estimate).count, 0U) << "no error of the ranges";
  }
}

TEST(LaserLog, ReadsCompressedLogs) {
  const auto path = std::filesystem::temp_directory_path() / "laser_log_compressed.log.gz";
  gzFile file = gzopen(path.c_str(), "wb");
  gzputs(file, two_scans.c_str());
  gzclose(file);
  LaserLog log = log_of(path);
  EXPECT_TRUE(run(log, tick_of()).outcome);
  // Cut in the middle of the compressed data.
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 12);
  LaserLog cut = log_of(path);
  EXPECT_EQ(fault_of(run(cut, tick_of()).outcome), "output") << "the held file is not read again";
}

TEST(LaserLog, ACutFileIsAFault) {
  const auto path = std::filesystem::temp_directory_path() / "laser_log_cut.log.gz";
  gzFile file = gzopen(path.c_str(), "wb");
  for (int i = 0; i < 1000; ++i) gzputs(file, (std::to_string(i * 7919) + two_scans).c_str());
  gzclose(file);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  LaserLog log = log_of(path);
  const ModuleRun result = run(log, tick_of());
  EXPECT_EQ(fault_of(result.outcome), "device_lost");
}

TEST(LaserLog, ABadLineIsAFaultWithItsPlaceOrLeftOut) {
  const auto path = written("laser_log_bad.log",
                            "FLASER 3 1 2\n" + two_scans + "FLASER 3 1 2 x 0 0 0 0 0 0 1 h 1\n");
  LaserLog log = log_of(path);
  const ModuleRun first = run(log, tick_of());
  EXPECT_EQ(fault_of(first.outcome), "bad_data");
  EXPECT_EQ(first.outcome.fault().message,
            path.string() + ":1: the line ends at word 5; expected a range");
  EXPECT_TRUE(run(log, tick_of(1)).outcome);
  EXPECT_TRUE(run(log, tick_of(2)).outcome);
  EXPECT_EQ(run(log, tick_of(3)).outcome.fault().message,
            path.string() + ":5: word 5: expected a range, got 'x'");

  LaserLog::Options options;
  options.file = path;
  options.skip_bad = true;
  LaserLog tolerant(options);
  EXPECT_TRUE(run(tolerant, tick_of()).outcome);
  EXPECT_TRUE(run(tolerant, tick_of()).outcome);
  EXPECT_EQ(fault_of(run(tolerant, tick_of()).outcome), "end_of_data");
  EXPECT_EQ(tolerant.note(), "2 bad lines left out, the first: " + path.string() +
                                 ":1: the line ends at word 5; expected a range");
  EXPECT_EQ(log.note(), "") << "nothing is left out without skip_bad";
  tolerant.reset();
  EXPECT_EQ(tolerant.note(), "");
}

/// What a run of a CSV's scans gives, tick by tick: "output" or the fault.
std::vector<std::string> outcomes_of_csv(const std::string& text) {
  LaserLog::Options options;
  options.file = written("laser_log_csv.csv", text);
  options.format = LaserLogFormat::csv;
  LaserLog log(options);
  std::vector<std::string> outcomes;
  for (int i = 0; i < 3; ++i) {
    const ModuleRun result = run(log, tick_of());
    outcomes.push_back(fault_of(result.outcome));
    if (result.outcome.is_fault()) outcomes.back() += ": " + result.outcome.fault().message;
  }
  return outcomes;
}

TEST(LaserLog, ACsvsScansAreAllAsLong) {
  const auto outcomes = outcomes_of_csv("0,1,1,1,1\n0.1,1,1,1\n0.2,1,1,1,1\n");
  EXPECT_EQ(outcomes[0], "output");
  EXPECT_TRUE(outcomes[1].ends_with(":2: 3 ranges; expected 4, as in the scan before"))
      << outcomes[1];
  EXPECT_EQ(outcomes[2], "output");
}

TEST(LaserLog, ACsvsTimesRise) {
  const auto outcomes = outcomes_of_csv("1.02,1,1,1\n1.01,1,1,1\n1.03,1,1,1\n");
  EXPECT_EQ(outcomes[0], "output");
  EXPECT_NE(outcomes[1].find(":2: the time, 1.01 s, is not after"), std::string::npos)
      << outcomes[1];
  EXPECT_EQ(outcomes[2], "output");
}

TEST(LaserLog, AnInfiniteRangeOfACsvIsNoReturn) {
  LaserLog::Options options;
  options.file = written("laser_log_inf.csv", "0,1,inf,1\n");
  options.format = LaserLogFormat::csv;
  LaserLog log(options);
  const ModuleRun result = run(log, tick_of());
  ASSERT_TRUE(result.outcome);
  EXPECT_EQ(beams_of(result.output)[1].range, 0);
}

TEST(LaserLog, FilesWithoutScansAreDeviceLost) {
  const std::string binary("\0\1\2\3", 4);
  for (const auto& path :
       {written("laser_log_empty.log", ""), written("laser_log_binary.log", binary),
        written("laser_log_other.log", "ODOM 0 0 0\n"), std::filesystem::path("/no/such/file.log"),
        std::filesystem::temp_directory_path()}) {
    LaserLog log = log_of(path);
    const ModuleRun result = run(log, tick_of());
    EXPECT_EQ(fault_of(result.outcome), "device_lost") << path;
    EXPECT_NE(result.outcome.fault().message.find(path.string()), std::string::npos) << path;
  }
}

}  // namespace
}  // namespace ilss
