// The head's angle over time.
#include "sensors/lep/head_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;

TEST(HeadMotion, StandsWhereItStartsUntilItIsCommanded) {
  const HeadMotion head({}, 12 * degree);
  for (const double time : {0.0, 1.0, 100.0}) EXPECT_EQ(head.angle(time), 12 * degree);
}

// Pears 1997, table 1: 90 degrees in 0.5 s.
TEST(HeadMotion, TurnsNinetyDegreesInHalfASecond) {
  HeadMotion head({}, 0);
  head.turn_to(90 * degree, 1);
  EXPECT_EQ(head.angle(1), 0);
  EXPECT_NEAR(head.angle(1.25), 45 * degree, 1e-12);
  EXPECT_LT(head.angle(1.499), 90 * degree);
  EXPECT_NEAR(head.angle(1.5), 90 * degree, 1e-12);
  EXPECT_NEAR(head.angle(99), 90 * degree, 1e-12);
}

// Pears 1997, table 1: steps of 0.36 degrees.
TEST(HeadMotion, TurnsToTheNearestStep) {
  for (int k = -250; k <= 250; ++k) {
    HeadMotion head({}, 3 * degree);
    head.turn_to((0.36 * k + 0.17) * degree - (k == 250 ? 0.17 * degree : 0), 0);
    EXPECT_NEAR(head.angle(2), 0.36 * k * degree, 1e-12) << k;
  }
}

TEST(HeadMotion, NeverTurnsBeyondAStopForTheSakeOfItsStep) {
  HeadMotion head({.step = 7 * degree}, 0);
  head.turn_to(90 * degree, 0);
  EXPECT_NEAR(head.angle(9), 84 * degree, 1e-12) << "91 degrees are a step, but beyond the stop";
  head.turn_to(-90 * degree, 10);
  EXPECT_NEAR(head.angle(19), -84 * degree, 1e-12);
}

TEST(HeadMotion, StopsAtItsStopsWhenTurningAtARate) {
  HeadMotion head({}, 10 * degree);
  head.turn_at(-40 * degree, 0);
  EXPECT_NEAR(head.angle(1), -30 * degree, 1e-12);
  EXPECT_NEAR(head.angle(3), -90 * degree, 1e-12);
  head.turn_at(-40 * degree, 4);
  EXPECT_NEAR(head.angle(5), -90 * degree, 1e-12);
  head.turn_at(100 * degree, 6);
  EXPECT_NEAR(head.angle(6.9), 0, 1e-12);
  EXPECT_NEAR(head.angle(8), 90 * degree, 1e-12);
}

TEST(HeadMotion, HoldsWhereItIsAtARateOfZero) {
  HeadMotion head({}, 0);
  head.turn_at(40 * degree, 0);
  head.turn_at(0, 0.5);
  EXPECT_NEAR(head.angle(7), 20 * degree, 1e-12);
}

// A scan that began before a command asks for the angles before it.
TEST(HeadMotion, KeepsHowItTurnedBeforeACommand) {
  HeadMotion head({}, 0);
  head.turn_at(40 * degree, 0);
  head.turn_at(0, 0.5);
  head.turn_at(-20 * degree, 0.75);
  EXPECT_NEAR(head.angle(0.25), 10 * degree, 1e-12);
  EXPECT_NEAR(head.angle(0.6), 20 * degree, 1e-12);
  EXPECT_NEAR(head.angle(1.0), 15 * degree, 1e-12);
}

TEST(HeadMotion, ForgetsOnlyWhatWasBefore) {
  HeadMotion head({}, 0);
  head.turn_at(40 * degree, 0);
  head.turn_at(0, 0.5);
  head.turn_at(-20 * degree, 0.75);
  head.forget_before(0.6);
  EXPECT_NEAR(head.angle(0.6), 20 * degree, 1e-12);
  EXPECT_NEAR(head.angle(1.0), 15 * degree, 1e-12);
  head.forget_before(9);
  EXPECT_NEAR(head.angle(9), -90 * degree, 1e-12);
}

TEST(HeadMotion, FollowsTheLastOfTwoCommandsOfOneTime) {
  HeadMotion head({}, 0);
  head.turn_to(36 * degree, 1);
  head.turn_to(-36 * degree, 1);
  EXPECT_NEAR(head.angle(1.1), -18 * degree, 1e-12);
  EXPECT_NEAR(head.angle(3), -36 * degree, 1e-12);
}

}  // namespace
}  // namespace ilss
