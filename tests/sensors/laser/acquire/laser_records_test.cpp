#include "sensors/laser/acquire/laser_records.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "framework/estimate/random.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;

std::string flaser(int count) {
  std::string line = fmt::format("FLASER {}", count);
  for (int i = 0; i < count; ++i) line += fmt::format(" {}", 1 + 0.5 * i);
  return line + " 1 2 0.3 1 2 0.3 12.5 host 12.6";
}

TEST(CarmenLog, FlaserOf180BeamsStartsAtMinus90InStepsOfOneDegree) {
  const auto record = parse_carmen(flaser(180), CarmenMessage::flaser);
  ASSERT_TRUE(record && *record);
  EXPECT_EQ((*record)->ranges.size(), 180U);
  EXPECT_DOUBLE_EQ((*record)->ranges[2], 2.0);
  EXPECT_NEAR((*record)->first_bearing, -90 * degree, 1e-12);
  EXPECT_NEAR((*record)->step, 1 * degree, 1e-12);
  EXPECT_DOUBLE_EQ((*record)->time, 12.5);
}

TEST(CarmenLog, FlaserOf361BeamsReachesPlus90) {
  const auto record = parse_carmen(flaser(361), CarmenMessage::flaser);
  ASSERT_TRUE(record && *record);
  EXPECT_NEAR((*record)->first_bearing + 360 * (*record)->step, 90 * degree, 1e-12);
}

TEST(CarmenLog, OtherMessagesAndCommentsAreNoScans) {
  for (const char* line : {"", "# FLASER 2 1 1", "ODOM 0 0 0 0 0 0 1 host 1", "RLASER 2 1 1"}) {
    const auto record = parse_carmen(line, CarmenMessage::flaser);
    ASSERT_TRUE(record) << line;
    EXPECT_FALSE(*record) << line;
  }
}

TEST(CarmenLog, RobotLaserTellsItsAngles) {
  const auto record = parse_carmen(
      "ROBOTLASER1 0 -1.5 3.0 1.0 81.9 0.01 0 4 1 2 3 4 0 0 0 0 0 0 0 0 0 0 0 0 17.25 host 17.3",
      CarmenMessage::robotlaser1);
  ASSERT_TRUE(record && *record) << (record ? "" : record.fault().message);
  EXPECT_EQ((*record)->ranges, (std::vector<double>{1, 2, 3, 4}));
  EXPECT_DOUBLE_EQ((*record)->first_bearing, -1.5);
  EXPECT_DOUBLE_EQ((*record)->step, 1.0);
  EXPECT_DOUBLE_EQ((*record)->time, 17.25);
}

TEST(CarmenLog, SaysAtWhichWordALineIsWrong) {
  const auto message = [](const std::string& line) {
    const auto record = parse_carmen(line, CarmenMessage::flaser);
    return record ? std::string("fine") : record.fault().message;
  };
  EXPECT_EQ(message("FLASER 3 1 2"), "the line ends at word 5; expected a range");
  EXPECT_EQ(message("FLASER 2 1 x 0 0 0 0 0 0 1 h 1"), "word 4: expected a range, got 'x'");
  EXPECT_EQ(message("FLASER 2 1 nan 0 0 0 0 0 0 1 h 1"), "word 4: expected a range, got 'nan'");
  EXPECT_EQ(message("FLASER 2.5 1 1"), "word 2: 2.5 is no number of beams");
  EXPECT_EQ(message("FLASER 1e9 1 1"), "word 2: 1000000000 is no number of beams");
  EXPECT_EQ(message("FLASER"), "the line ends at word 2; expected the number of beams");
}

TEST(UrgLog, Has24HeaderNumbersAndMillimetresAround0) {
  std::string line = "2500000";
  for (int i = 1; i < 24; ++i) line += " 0";
  for (int i = 0; i < 683; ++i) line += fmt::format(" {}", 20 + i);
  const auto record = parse_urg(line);
  ASSERT_TRUE(record && *record);
  EXPECT_EQ((*record)->ranges.size(), 683U);
  EXPECT_DOUBLE_EQ((*record)->ranges[1], 0.021);
  EXPECT_DOUBLE_EQ((*record)->time, 2.5);
  EXPECT_NEAR((*record)->first_bearing, -(*record)->step * 341, 1e-12);
  EXPECT_NEAR((*record)->step * 682, 240 * degree, 0.4 * degree);
}

TEST(LaserCsv, IsTimeAndRanges) {
  const auto record = parse_laser_csv("0.5, 1, 2, 3", 2.0);
  ASSERT_TRUE(record && *record);
  EXPECT_EQ((*record)->ranges, (std::vector<double>{1, 2, 3}));
  EXPECT_DOUBLE_EQ((*record)->first_bearing, -1.0);
  EXPECT_DOUBLE_EQ((*record)->step, 1.0);
  EXPECT_FALSE(*parse_laser_csv("time, a, b", 2.0));
  EXPECT_FALSE(*parse_laser_csv("# comment", 2.0));
}

TEST(LaserRecords, GarbageIsAFaultOrFiniteNumbers) {
  const std::string robot_laser =
      "ROBOTLASER1 0 -1.5 3.0 1.0 81.9 0.01 0 4 1 2 3 4 2 7 8 0 0 0 0 0 0 0 0 0 0 0 17.25 h 17.3";
  const std::string good[] = {flaser(6), robot_laser, "1,2,3,4,5,6",
                              "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 "
                              "26 27"};
  constexpr std::string_view letters = "0123456789.-+eE ,#xnaif\t\r\n\xff";
  for (std::uint64_t seed = 0; seed < 20000; ++seed) {
    SCOPED_TRACE(seed);
    RandomBits random(seed);
    std::string line = good[seed % std::size(good)];
    for (std::uint64_t changes = 1 + random() % 4; changes > 0; --changes) {
      const std::size_t at = random() % line.size();
      if (random() % 3 == 0)
        line.erase(at, 1 + random() % 5);
      else
        line[at] = letters[random() % letters.size()];
      if (line.empty()) line = " ";
    }
    for (int reader = 0; reader < 5; ++reader) {
      const auto record = reader < 3    ? parse_carmen(line, static_cast<CarmenMessage>(reader))
                          : reader == 3 ? parse_urg(line)
                                        : parse_laser_csv(line, 3);
      if (!record) {
        EXPECT_EQ(record.fault().kind, FaultKind::bad_data);
        EXPECT_FALSE(record.fault().message.empty());
      } else if (*record) {
        EXPECT_GE((*record)->ranges.size(), 2U);
        for (const double range : (*record)->ranges) EXPECT_TRUE(std::isfinite(range));
        EXPECT_TRUE(std::isfinite((*record)->first_bearing + (*record)->step));
      }
    }
  }
}

}  // namespace
}  // namespace ilss
