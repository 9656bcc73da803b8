// Scans from a recording: units, senses, columns, ends of scans, errors, and files that are wrong.
#include "sensors/range/range_readings.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "tests/sensors/features/feature_run.h"

namespace ilss {
namespace {

class RangeReadingsTest : public ::testing::Test {
 protected:
  RangeReadingsTest() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::path(::testing::TempDir()) /
            ("ilss_RangeReadings_" + std::string(test->name()) + ".csv");
  }
  ~RangeReadingsTest() override { std::filesystem::remove(path_); }

  void write(const std::string& text) const { std::ofstream(path_) << text; }

  /// Options as YAML says them, beside the file.
  RangeReadings::Options options(const std::string& more = "std_constant: 1 cm") const {
    Diagnostics diagnostics;
    auto read = options_from<RangeReadings::Options>(
        "{file: " + path_.string() + (more.empty() ? "" : ", " + more) + "}", diagnostics);
    for (const Diagnostic& d : diagnostics.sorted()) ADD_FAILURE() << format_diagnostic(d);
    return read;
  }

  static Tick tick(std::int64_t number = 0) {
    Tick at;
    at.parameters = Estimate(descriptor<RangeReadings::Parameters>());
    at.tick = number;
    return at;
  }
  static ModuleRun next(RangeReadings& module, const Tick& at = tick()) {
    ModuleRun result;
    result.output.estimate = Estimate(descriptor<RangeScan>(), "lep");
    result.outcome = module.open();
    if (result.outcome) result.outcome = module.evaluate(at.evaluation(), result.output);
    return result;
  }
  ModuleRun first(const std::string& text, const std::string& more = "std_constant: 1 cm") const {
    write(text);
    RangeReadings module(options(more));
    return next(module);
  }
  /// The fault of a recording's first scan; the path shows as FILE.
  std::string fault_in(const std::string& text,
                       const std::string& more = "std_constant: 1 cm") const {
    const ModuleRun result = first(text, more);
    if (!result.outcome.is_fault()) return "no fault";
    std::string message = result.outcome.fault().message;
    const std::size_t at = message.find(path_.string());
    if (at != std::string::npos) message.replace(at, path_.string().size(), "FILE");
    return fault_of(result.outcome) + ": " + message;
  }
  static std::string mistake_in(const std::string& yaml) {
    Diagnostics diagnostics;
    options_from<RangeReadings::Options>(yaml, diagnostics);
    return diagnostics.sorted().empty() ? "" : diagnostics.sorted()[0].message;
  }

  std::filesystem::path path_;
};

TEST_F(RangeReadingsTest, ReadsItsColumnsInTheirUnits) {
  const ModuleRun result = first(
      "t,a,r,s,h\n0.5,90,1500,30,10\n0.6,91,1200,20,11\n",
      "angle: a, angle_unit: deg, range: r, range_unit: mm, range_std: s, head: h, time_column: t");
  ASSERT_TRUE(result.outcome);
  const auto readings = readings_of(result.output);
  ASSERT_EQ(readings.size(), 2u);
  EXPECT_EQ(readings[0].time, 0.5);
  EXPECT_EQ(result.output.acquired.oldest, time_at(0.5));
  EXPECT_NEAR(readings[0].head, 10 * degree, 1e-12);
  EXPECT_NEAR(readings[0].bearing, 100 * degree, 1e-12) << "the angle is in the head";
  EXPECT_NEAR(readings[0].inverse_range, 1 / 1.5, 1e-12);
  EXPECT_NEAR(readings[0].deviation, 0.03 / (1.5 * 1.5), 1e-12);
  EXPECT_NEAR(readings[1].bearing, 102 * degree, 1e-12);
}

TEST_F(RangeReadingsTest, ARowWithoutATimeDoesNotEndTheTimes) {
  write("t,angle,range\n0.5,0.1,1\n,0.2,1\n,0.1,1\n,0.2,1\n0.9,0.1,1\n");
  RangeReadings module(options("std_constant: 1 cm, time_column: t, readings: 2"));
  ASSERT_TRUE(module.open());
  std::vector<double> times;
  for (std::optional<Time> time; (time = module.next_time()) && times.size() < 9;) {
    times.push_back(seconds(*time));
    next(module, tick());
  }
  EXPECT_EQ(times, (std::vector<double>{0.5, 0.9, 0.9}));
}

TEST_F(RangeReadingsTest, TakesTheTicksTimeWithoutATimeColumn) {
  write("angle,range\n0.1,1\n0.2,1\n");
  RangeReadings module(options());
  const ModuleRun result = next(module, tick(7));
  ASSERT_TRUE(result.outcome);
  EXPECT_NEAR(readings_of(result.output)[1].time, 0.7, 1e-12);
}

TEST_F(RangeReadingsTest, TurnsAnglesThatCountFromForwardToTheRight) {
  const ModuleRun result = first("angle,range,head\n30,2,10\n40,2,10\n",
                                 "std_constant: 1 cm, angle_unit: deg, angles: from_z_to_x, "
                                 "head: head");
  ASSERT_TRUE(result.outcome);
  const RangeReading& r = readings_of(result.output)[0];
  EXPECT_NEAR(r.bearing, (90 - 30 - 10) * degree, 1e-12);
  EXPECT_NEAR(r.head, -10 * degree, 1e-12);
}

TEST_F(RangeReadingsTest, AddsItsPartsOfARangesError) {
  const ModuleRun result = first("angle,range,sd\n0.1,2,0.03\n0.2,2,0.03\n",
                                 "range_std: sd, std_constant: 4 cm, std_proportional: 0.06");
  ASSERT_TRUE(result.outcome);
  EXPECT_NEAR(readings_of(result.output)[0].deviation, 0.13 / 4, 1e-12);
}

TEST_F(RangeReadingsTest, PutsTheRaysWhereTheMountIs) {
  write("angle,range,head\n0.1,2,0.3\n0.2,2,0.3\n");
  RangeReadings module(
      options("std_constant: 1 cm, head: head, noise_correlation: 0.1, "
              "beam_width: 4 mm"));
  Tick at = tick();
  at.parameters.value = {0, 1, 0.05, 0.07, 0.02};
  const ModuleRun result = next(module, at);
  ASSERT_TRUE(result.outcome);
  const RangeReading& r = readings_of(result.output)[0];
  EXPECT_NEAR(r.origin_x, std::cos(0.3) * 0.05 - std::sin(0.3) * 0.07, 1e-12);
  EXPECT_NEAR(r.origin_z, std::sin(0.3) * 0.05 + std::cos(0.3) * 0.07, 1e-12);
  EXPECT_NEAR(r.bearing, 0.1 + 0.3 + 0.02, 1e-12);
  const auto scan = payload_of<RangeScan>(result.output.estimate);
  EXPECT_EQ(scan.mount_x, 0.05);
  EXPECT_EQ(scan.mount_heading, 0.02);
  EXPECT_EQ(scan.noise_correlation, 0.1);
  EXPECT_EQ(scan.beam_width, 0.004);
}

TEST_F(RangeReadingsTest, LeavesEmptyRangesOut) {
  const ModuleRun result = first("angle,range\n0.1,1\n0.2,\n0.3,1\n");
  ASSERT_TRUE(result.outcome);
  ASSERT_EQ(readings_of(result.output).size(), 2u);
  EXPECT_EQ(readings_of(result.output)[1].bearing, 0.3);
  EXPECT_EQ(fault_in("angle,range\n0.1,\n0.2,\n"),
            "no_detection: FILE:2: no row of the scan has a range");
}

TEST_F(RangeReadingsTest, AScanEndsWhereTheAngleJumpsBack) {
  for (const char* text : {"angle,range\n0.1,1\n0.2,1\n0.3,1\n0.1,2\n0.2,2\n",
                           "angle,range\n0.3,1\n0.2,1\n0.1,1\n0.3,2\n0.2,2\n"}) {
    write(text);
    RangeReadings module(options());
    EXPECT_EQ(readings_of(next(module).output).size(), 3u);
    EXPECT_EQ(readings_of(next(module).output).size(), 2u);
    EXPECT_EQ(fault_of(next(module).outcome), "end_of_data");
    EXPECT_EQ(fault_of(next(module).outcome), "end_of_data");
    module.reset();
    EXPECT_EQ(readings_of(next(module).output).size(), 3u);
  }
}

TEST_F(RangeReadingsTest, AScanEndsAfterItsNumberOfReadings) {
  write("angle,range\n0.1,1\n0.2,1\n0.3,1\n0.1,2\n0.2,2\n");
  RangeReadings module(options("std_constant: 1 cm, readings: 2"));
  for (const std::size_t count : {2, 2, 1})
    EXPECT_EQ(readings_of(next(module).output).size(), count);
  EXPECT_EQ(fault_of(next(module).outcome), "end_of_data");
}

TEST_F(RangeReadingsTest, OffsetScaleAndMountErrByAsMuchAsTheyMoveReadings) {
  write("angle,range\n0.1,1.3\n0.2,0.7\n");
  const std::vector<double> values = {0.05, 1.1, 0.02, 0.03, 0.04};
  for (std::size_t parameter = 0; parameter < 5; ++parameter) {
    constexpr double by = 1e-6;
    RangeReadings module(options());
    Tick uncertain = tick();
    uncertain.parameters.value = values;
    uncertain.parameters.lineage.add({9, 0, persistent_tick}, parameter, by);
    Tick changed = tick();
    changed.parameters.value = values;
    changed.parameters.value[parameter] += by;
    const ModuleRun stated = next(module, uncertain);
    module.reset();
    const ModuleRun moved = next(module, changed);
    ASSERT_TRUE(stated.outcome && moved.outcome);
    const auto column = stated.output.estimate.lineage.column(0);
    for (std::size_t i = 0; i < 2; ++i) {
      const RangeReading& a = readings_of(stated.output)[i];
      const RangeReading& b = readings_of(moved.output)[i];
      double change = 0;
      for (std::size_t k = 0; k < shared_range_errors; ++k)
        change += a.sensitivity[k] * column[3 + k];
      EXPECT_NEAR((b.inverse_range - a.inverse_range) / by, change / by, 1e-4) << parameter;
      EXPECT_NEAR(b.origin_x - a.origin_x, column[0], 1e-12);
      EXPECT_NEAR(b.origin_z - a.origin_z, column[1], 1e-12);
      EXPECT_NEAR(b.bearing - a.bearing, column[2], 1e-12);
    }
  }
}

TEST_F(RangeReadingsTest, SaysWhereARowIsWrong) {
  const std::string head = "angle,range\n0.1,1\n";
  EXPECT_EQ(fault_in(head + "0.2,0\n"), "bad_data: FILE:3: a range of 0 m; expected one above 0");
  EXPECT_EQ(fault_in(head + "0.2,-1\n"), "bad_data: FILE:3: a range of -1 m; expected one above 0");
  EXPECT_NE(fault_in(head + "0.2,nan\n").find("bad_data: FILE:3:"), std::string::npos);
  EXPECT_NE(fault_in(head + "0.2,inf\n").find("bad_data: FILE:3:"), std::string::npos);
  EXPECT_NE(fault_in(head + "0.2,far\n").find("bad_data: FILE:3:"), std::string::npos);
  EXPECT_NE(fault_in(head + "0.2\n").find("bad_data: FILE:3:"), std::string::npos);
  EXPECT_NE(fault_in(head + ",1\n").find("bad_data: FILE:3:"), std::string::npos) << "no angle";
  EXPECT_NE(fault_in(head + "x,1\n").find("bad_data: FILE:3:"), std::string::npos);
  const std::string field = "std_constant: 1 cm, min_range: 0.5 m, max_range: 2 m";
  EXPECT_EQ(fault_in(head + "0.2,0.4\n", field),
            "bad_data: FILE:3: a range of 0.4 m is outside the sensor's field");
  EXPECT_EQ(fault_in(head + "0.2,2.1\n", field),
            "bad_data: FILE:3: a range of 2.1 m is outside the sensor's field");
  EXPECT_EQ(fault_in("angle,range,sd\n0.1,1,0.1\n0.2,1,0\n", "range_std: sd"),
            "bad_data: FILE:3: an sd of 0 m; expected one above 0");
  EXPECT_NE(fault_in("angle,range,sd\n0.1,1,-0.1\n", "range_std: sd").find("FILE:2:"),
            std::string::npos);
  EXPECT_NE(fault_in("angle,range,sd\n0.1,1,\n", "range_std: sd").find("bad_data: FILE:2:"),
            std::string::npos);
}

TEST_F(RangeReadingsTest, SaysWhereARangeIsTooLargeOrSmallForNumbers) {
  for (const char* range : {"1e-200", "1e200", "5e-324"})
    EXPECT_NE(
        fault_in("angle,range\n0.1,1\n0.2," + std::string(range) + "\n", "std_proportional: 0.01")
            .find("bad_data: FILE:3:"),
        std::string::npos)
        << range;
}

TEST_F(RangeReadingsTest, RefusesARangeBelowTheOffset) {
  write("angle,range\n0.1,1\n0.2,0.05\n");
  RangeReadings module(options());
  Tick at = tick();
  at.parameters.value[0] = 0.1;
  EXPECT_EQ(fault_of(next(module, at).outcome), "bad_data");
}

TEST_F(RangeReadingsTest, GoesOnWithTheNextScanAfterABadOne) {
  write("angle,range\n0.1,1\n0.2,bad\n0.1,2\n0.2,2\n");
  RangeReadings module(options());
  EXPECT_EQ(fault_of(next(module).outcome), "bad_data");
  const ModuleRun second = next(module);
  ASSERT_TRUE(second.outcome);
  EXPECT_EQ(readings_of(second.output)[0].inverse_range, 0.5);
}

TEST_F(RangeReadingsTest, LosesItsDeviceWithoutTheFileOrAColumn) {
  EXPECT_NE(fault_in("angle,distance\n0.1,1\n").find("device_lost"), std::string::npos);
  EXPECT_NE(
      fault_in("angle,range\n0.1,1\n", "std_constant: 1 cm, time_column: t").find("device_lost"),
      std::string::npos);
  RangeReadings::Options missing;
  missing.file = "/nonexistent/readings.csv";
  missing.std_constant = 1;
  RangeReadings module(missing);
  EXPECT_EQ(fault_of(next(module).outcome), "device_lost");
}

TEST_F(RangeReadingsTest, OptionsNeedAnErrorAndKnownUnits) {
  EXPECT_NE(mistake_in("{file: a.csv}").find("need an error"), std::string::npos);
  EXPECT_NE(mistake_in("{file: a.csv, std_constant: 1 cm, angle_unit: kg}").find("angle_unit"),
            std::string::npos);
  EXPECT_NE(mistake_in("{file: a.csv, std_constant: 1 cm, range_unit: s}").find("range_unit"),
            std::string::npos);
  EXPECT_NE(mistake_in("{file: a.csv, std_constant: 1 cm, noise_correlation: 1}"), "");
  EXPECT_NE(mistake_in("{std_constant: 1 cm}"), "");
}

TEST_F(RangeReadingsTest, MutatedFilesNeitherCrashNorGiveWhatIsNoNumber) {
  constexpr unsigned seed = 251;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  const auto pick = [&](std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(random);
  };
  std::string good = "angle,range,sd,head\n";
  for (int i = 0; i < 8; ++i)
    good += std::to_string(0.1 * (i % 4)) + ",1." + std::to_string(i) + ",0.01,0\n";
  const std::string characters = "0123456789.,-+e\n\";# naif\t\0xE";
  int outputs = 0;
  LineExtractor extractor({});
  for (int run = 0; run < 2000; ++run) {
    std::string text = good;
    const std::size_t changes = 1 + pick(4);
    for (std::size_t k = 0; k < changes; ++k) {
      const std::size_t at = pick(text.size());
      const char c = characters[pick(characters.size())];
      switch (pick(4)) {
        case 0:
          text[at] = c;
          break;
        case 1:
          text.insert(at, 1, c);
          break;
        case 2:
          text.erase(at, 1 + pick(5));
          break;
        default:
          text.insert(at, text.substr(at, pick(12)));
      }
      if (text.empty()) text = ",";
    }
    write(text);
    RangeReadings module(options("range_std: sd, head: head, std_proportional: 0.01"));
    for (int scan = 0; scan < 4; ++scan) {
      const ModuleRun result = next(module);
      if (!result.outcome) continue;
      ++outputs;
      ASSERT_TRUE(all_finite(result.output)) << text;
      for (const RangeReading& r : readings_of(result.output)) {
        ASSERT_GT(r.inverse_range, 0) << text;
        ASSERT_GT(r.deviation, 0) << text;
      }
      const ModuleRun features = extract(extractor, result.output);
      if (features.outcome) {
        ASSERT_TRUE(all_finite(features.output)) << text;
      }
    }
  }
  EXPECT_GT(outputs, 1000);
}

TEST_F(RangeReadingsTest, BadRowsAreLeftOutAndCountedWhereWanted) {
  write("angle,range\n0.1,1\n0.2,far\n0.3,\n0.4,-1\n0.5,1\n");
  RangeReadings module(options("std_constant: 1 cm, skip_bad: true"));
  const ModuleRun result = next(module);
  ASSERT_TRUE(result.outcome);
  EXPECT_EQ(readings_of(result.output).size(), 2U);
  EXPECT_EQ(module.note(), "2 bad lines left out, the first: " + path_.string() +
                               ":3: expected a number in column 2, got 'far'")
      << "the empty range is no bad row";
  module.reset();
  EXPECT_EQ(module.note(), "");
}

}  // namespace
}  // namespace ilss
