// Wall pose by sonar, whole chain: does the error that it states hold over thousands of runs?
#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "framework/estimate/consistency.h"
#include "sensors/sonar/sonar.h"
#include "sensors/wall/wall_pose.h"
#include "sensors/wall/wedge_sonar_line.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr int runs = 2000;

/// Two sonars' mounts: {x, z, heading}.
struct Mounting {
  const char* name;
  std::array<std::array<double, 3>, 2> mounts;
};

const Mounting ring{"neighbours on a ring",
                    {{{0.3 * std::cos(7.5 * degree), -0.3 * std::sin(7.5 * degree), -7.5 * degree},
                      {0.3 * std::cos(7.5 * degree), 0.3 * std::sin(7.5 * degree), 7.5 * degree}}}};
const Mounting apart{"0.2 m apart", {{{0, -0.1, -7.5 * degree}, {0, 0.1, 7.5 * degree}}}};

/// Poses of Henderson & Dekhil 1997, table 1, and the case that both mountings see them in.
struct Pose {
  double range;
  double angle;
  const char* contact;
};
const std::array<Pose, 5> poses = {{{0.919, -21 * degree, "(-,-)"},
                                    {0.930, 20 * degree, "(+,+)"},
                                    {1.242, 0, "(0,0)"},
                                    {1.164, -11 * degree, "(0,-)"},
                                    {1.283, 6 * degree, "(+,0)"}}};

/// What the two sonars' mounts and beams are believed to be good for.
struct MountError {
  double place = 0;
  double heading = 0;
  double beam = 0;
};

/// The chain sonar, sonar -> wedge line -> wall pose on a simulated wall across the world's origin.
class Chain {
 public:
  Chain(const Mounting& mounting, const Pose& pose, double range_std, MountError error)
      : error_(error), truth_{pose.range, pose.angle}, sonar_(options(range_std)) {
    for (const std::size_t side : {0u, 1u}) {
      Estimate& believed = believed_[side];
      believed = Estimate(descriptor<Sonar::Parameters>());
      believed.value = {polaroid_half_angle,
                        mounting.mounts[side][0],
                        mounting.mounts[side][1],
                        mounting.mounts[side][2],
                        -pose.range,
                        0,
                        -pose.angle};
      believed.lineage.reset(believed.value.size());
      for (std::size_t i = 0; i < 4; ++i)
        if (std_of(i) > 0)
          believed.lineage.add({10 + static_cast<std::uint32_t>(side),
                                static_cast<std::uint32_t>(i), persistent_tick},
                               i, std_of(i));
    }
  }

  /// One run with the mounts' errors drawn anew; nothing where a module gives a fault.
  std::optional<NormalizedError> run(std::uint64_t seed, std::string_view contact,
                                     int& other_contacts) {
    RandomBits random(derive_seed(seed, "mounts"));
    std::array<Output, 2> readings;
    for (const std::size_t side : {0u, 1u}) {
      Estimate actual = believed_[side];
      for (std::size_t i = 0; i < 4; ++i) actual.value[i] += std_of(i) * draw_normal(random);
      actual.lineage.reset(actual.value.size());
      const auto measured = measure(actual, derive_seed(seed, side));
      if (!measured) return std::nullopt;
      // The range was measured with the actual mount; what is known is the believed one.
      Output point = *measured;
      std::fill(point.estimate.value.begin() + 1, point.estimate.value.end(), required);
      const Tick tick{believed_[side], {}, 0, 0, 20 + static_cast<std::uint32_t>(side)};
      if (!sonar_.expect(tick.evaluation(), &point, readings[side])) return std::nullopt;
    }
    Tick tick;
    tick.inputs = {&readings[0], &readings[1]};
    const auto points = ilss::run(wedge_, tick);
    if (!points.outcome) return std::nullopt;
    other_contacts +=
        wall_contacts[static_cast<std::size_t>(points.output.estimate.labels[0])] != contact;
    tick.inputs = {&points.output};
    auto pose = ilss::run(wall_pose_, tick);
    if (!pose.outcome) return std::nullopt;
    pose.output.estimate.type = &descriptor<WallPose>();
    return nees(pose.output.estimate, truth_);
  }

 private:
  static Sonar::Options options(double range_std) {
    Sonar::Options result;
    result.range_std = range_std;
    result.input.scene.emplace();
    result.input.scene->content.walls.push_back({{0, -20}, {0, 20}, 0.8, {}});
    return result;
  }
  double std_of(std::size_t parameter) const {
    return parameter == 0 ? error_.beam : parameter == 3 ? error_.heading : error_.place;
  }
  std::optional<Output> measure(const Estimate& actual, std::uint64_t seed) {
    const Tick tick{actual, {}, 0, seed, 1};
    auto result = ilss::run(sonar_, tick);
    if (!result.outcome) return std::nullopt;
    return result.output;
  }

  MountError error_;
  std::array<double, 2> truth_;
  std::array<Estimate, 2> believed_;
  Sonar sonar_;
  FunctionModule<WedgeSonarLine> wedge_{WedgeSonarLine({})};
  FunctionModule<WallPoseModule> wall_pose_{WallPoseModule()};
};

std::string test_name() { return ::testing::UnitTest::GetInstance()->current_test_info()->name(); }

void expect_consistent(const Mounting& mounting, const Pose& pose, double range_std,
                       MountError error = {}) {
  const std::uint64_t seed =
      derive_seed(derive_seed(1997, mounting.name), std::string(pose.contact) + test_name());
  SCOPED_TRACE(::testing::Message()
               << mounting.name << ", contact " << pose.contact << ", seed " << seed);
  Chain chain(mounting, pose, range_std, error);
  ConsistencyStatistic statistic;
  int other_contacts = 0;
  for (std::uint64_t run = 0; run < runs; ++run) {
    const auto error_of_run = chain.run(derive_seed(seed, run), pose.contact, other_contacts);
    ASSERT_TRUE(error_of_run) << "a fault in run " << run;
    ASSERT_EQ(error_of_run->rank, 2);
    statistic.add(*error_of_run);
  }
  EXPECT_TRUE(statistic.consistent(0.99))
      << "mean NEES per degree of freedom " << statistic.mean() << " outside ["
      << statistic.bounds(0.99).low << ", " << statistic.bounds(0.99).high << "]";
  EXPECT_EQ(other_contacts, 0);
}

TEST(SonarWallPose, IsConsistentInEveryCaseOfARing) {
  for (const Pose& pose : poses) expect_consistent(ring, pose, 0.0002);
}

TEST(SonarWallPose, IsConsistentInEveryCaseOfSonarsApart) {
  for (const Pose& pose : poses) expect_consistent(apart, pose, 0.0002);
}

// 2 mm leave these poses well inside their cases.
TEST(SonarWallPose, IsConsistentAtTwoMillimetresOffTheCaseBoundaries) {
  expect_consistent(apart, {0.919, -30 * degree, "(-,-)"}, 0.002);
  expect_consistent(apart, {1.242, 0, "(0,0)"}, 0.002);
  expect_consistent(apart, {1.0, -11 * degree, "(0,-)"}, 0.002);
}

// Mounts and beams that are wrong, differently in every run, and say so.
TEST(SonarWallPose, IsConsistentWithUncertainMounts) {
  for (const Pose& pose : poses)
    expect_consistent(apart, pose, 0.0002, {0.0002, 0.05 * degree, 0.05 * degree});
}

}  // namespace
}  // namespace ilss
