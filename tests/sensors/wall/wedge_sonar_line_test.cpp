// The wedge line as a module: its outputs, faults and derivatives.
#include "sensors/wall/wedge_sonar_line.h"

#include <gtest/gtest.h>

#include <array>
#include <numbers>
#include <random>

#include "tests/sensors/module_run.h"
#include "tests/sensors/wall/sonar_contact.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double mm = 1e-3;
using Wedge = FunctionModule<WedgeSonarLine>;

ModuleRun run_wedge(const Output& left, const Output& right,
                    ContactAssumption contact = ContactAssumption::geometric) {
  Wedge module(WedgeSonarLine({contact, "robot"}));
  Tick tick;
  tick.inputs = {&left, &right};
  return run(module, tick);
}

std::string message_of(const ModuleRun& result) { return result.outcome.fault().message; }

// Henderson & Dekhil 1997, sec. 2.3: {cos², sin², cos², sin²}(theta) L_r for L_r = 4 mm².
TEST(WedgeSonarLine, GivesThePapersVariancesInTheWorstCase) {
  const Output left = output_of<SonarReading>({1, 11 * degree, 0, 0, 0}, {2 * mm});
  const Output right = output_of<SonarReading>({1, 11 * degree, 0, 0, 0}, {2 * mm}, 101);
  const auto result = run_wedge(left, right, ContactAssumption::worst_case);
  ASSERT_TRUE(result.outcome);
  const double expected[] = {3.85, 0.15, 3.85, 0.15};
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(result.output.estimate.lineage.variance(i) / (mm * mm), expected[i], 0.01);
}

TEST(WedgeSonarLine, TakesTheRightEdgeOfBothBeamsInTheWorstCase) {
  const double direction = 0.2 + 11 * degree;
  const auto result =
      run_wedge(output_of<SonarReading>({2, 11 * degree, 0.1, -0.1, 0.2}),
                output_of<SonarReading>({1, 5 * degree, 0, 0.1, 0}), ContactAssumption::worst_case);
  ASSERT_TRUE(result.outcome);
  const auto points = payload_of<WallPoints>(result.output.estimate);
  EXPECT_DOUBLE_EQ(points.x1, 0.1 + 2 * std::cos(direction));
  EXPECT_DOUBLE_EQ(points.z1, -0.1 + 2 * std::sin(direction));
  EXPECT_DOUBLE_EQ(points.x2, std::cos(5 * degree));
  EXPECT_DOUBLE_EQ(points.z2, 0.1 + std::sin(5 * degree));
}

/// Readings of two sonars for a wall; the sonars see it.
struct Readings {
  SonarReading<double> left;
  SonarReading<double> right;
};
Readings readings_of(Readings sonars, const WallLine& wall) {
  sonars.left.range = sonar_contact(sonars.left, wall)->range;
  sonars.right.range = sonar_contact(sonars.right, wall)->range;
  return sonars;
}

const Readings side_by_side{{0, 11 * degree, 0, -0.1, 0}, {0, 11 * degree, 0, 0.1, 0}};

TEST(WedgeSonarLine, RecoversWallTouchingBothBeamsAsTangent) {
  const auto readings = readings_of(side_by_side, {1, 5 * degree});
  const auto result = run_wedge(output_of(readings.left), output_of(readings.right));
  ASSERT_TRUE(result.outcome);
  const auto points = payload_of<WallPoints>(result.output.estimate);
  EXPECT_EQ(wall_contacts[static_cast<std::size_t>(points.label[0])], "(0,0)");
  const double c = std::cos(5 * degree);
  const double s = std::sin(5 * degree);
  EXPECT_NEAR(c * points.x1 + s * points.z1, 1, 1e-12);
  EXPECT_NEAR(c * points.x2 + s * points.z2, 1, 1e-12);
}

TEST(WedgeSonarLine, RecoversWallTouchingBothBeamEdges) {
  const auto readings = readings_of(side_by_side, {1, -30 * degree});
  const auto result = run_wedge(output_of(readings.left), output_of(readings.right));
  ASSERT_TRUE(result.outcome);
  const auto points = payload_of<WallPoints>(result.output.estimate);
  EXPECT_EQ(wall_contacts[static_cast<std::size_t>(points.label[0])], "(-,-)");
  EXPECT_NEAR(points.z1, -0.1 - readings.left.range * std::sin(11 * degree), 1e-12);
}

TEST(WedgeSonarLine, CrossesACaseBoundaryToTheNeighbouringCase) {
  const WallLine wall{1, 11 * degree};
  const auto readings = readings_of(side_by_side, wall);
  // The farther the right sonar's reading, the less the wall turns to the right.
  for (const auto& [change, contact] : {std::pair{+2 * mm, "(0,0)"}, std::pair{-2 * mm, "(+,+)"}}) {
    auto right = readings.right;
    right.range += change;
    const auto result = run_wedge(output_of(readings.left), output_of(right));
    ASSERT_TRUE(result.outcome);
    EXPECT_EQ(wall_contacts[static_cast<std::size_t>(result.output.estimate.labels[0])], contact);
  }
}

// With one sonar 0.2 m straight behind the other, a wall and its mirror image look the same.
const Readings one_behind_the_other{{0, 11 * degree, 0, 0, 0}, {0, 11 * degree, 0.2, 0, 0}};

TEST(WedgeSonarLine, IsAmbiguousAndListsBothWallsThatFit) {
  const auto readings = readings_of(one_behind_the_other, {1, 5 * degree});
  const auto result = run_wedge(output_of(readings.left), output_of(readings.right));
  ASSERT_EQ(fault_of(result.outcome), "ambiguous");
  EXPECT_EQ(message_of(result),
            "2 walls give both ranges: range 1000.0 mm, angle -5.00 deg, contact (0,0); "
            "range 1000.0 mm, angle 5.00 deg, contact (0,0)");
}

TEST(WedgeSonarLine, DescribesASolutionInMillimetresAndDegrees) {
  EXPECT_EQ(describe({Contact::tangent, Contact::right_edge, 1, {0.912, -21 * degree}}),
            "range 912.0 mm, angle -21.00 deg, contact (0,+)");
  EXPECT_EQ(describe({Contact::tangent, Contact::tangent, 1, {-0.1, 170 * degree}}),
            "range 100.0 mm, angle -10.00 deg, contact (0,0)");
}

TEST(WedgeSonarLine, FindsNothingForRangesThatNoWallGives) {
  // No wall is farther from the rear sonar by more than the front one is ahead of it.
  Readings readings = one_behind_the_other;
  readings.left.range = 1.5;
  readings.right.range = 1.0;
  const auto result = run_wedge(output_of(readings.left), output_of(readings.right));
  ASSERT_EQ(fault_of(result.outcome), "no_detection");
  EXPECT_EQ(message_of(result),
            "no straight wall gives both ranges, left 1500.0 mm and right 1000.0 mm");
}

TEST(WedgeSonarLine, IsDegenerateForTwoSonarsInOnePlace) {
  const Output sonar = output_of<SonarReading>({1, 11 * degree, 0, 0, 0});
  EXPECT_EQ(fault_of(run_wedge(sonar, sonar).outcome), "degenerate");
}

TEST(WedgeSonarLine, RefusesReadingsAndBeamsOutOfRange) {
  const Output good = output_of<SonarReading>({1, 11 * degree, 0, 0.1, 0});
  for (const SonarReading<double>& bad : {SonarReading<double>{0, 11 * degree, 0, 0, 0},
                                          {-1, 11 * degree, 0, 0, 0},
                                          {std::nan(""), 11 * degree, 0, 0, 0},
                                          {HUGE_VAL, 11 * degree, 0, 0, 0},
                                          {1, 0, 0, 0, 0},
                                          {1, 90 * degree, 0, 0, 0},
                                          {1, 11 * degree, std::nan(""), 0, 0}}) {
    EXPECT_EQ(fault_of(run_wedge(output_of(bad), good).outcome), "out_of_range");
    EXPECT_EQ(fault_of(run_wedge(good, output_of(bad)).outcome), "out_of_range");
  }
}

TEST(WedgeSonarLine, WantsBothMountsInOneFrame) {
  const ModuleType type = function_type<WedgeSonarLine>();
  const Interface interface = type.interface({});
  EXPECT_EQ(interface.inputs[0].frame, "robot");
  EXPECT_EQ(interface.inputs[1].frame, "robot");
}

/// Derivatives of the points by all ten components, by central differences.
std::array<double, 40> central_differences(const Readings& readings) {
  constexpr double h = 1e-6;
  const WedgeSonarLine wedge({});
  std::array<double, 40> jacobian{};
  for (std::size_t column = 0; column < 10; ++column) {
    std::array<WallPoints<double>, 2> points{};
    for (const std::size_t side : {0u, 1u}) {
      Readings moved = readings;
      components(column < 5 ? moved.left : moved.right)[column % 5] += side == 0 ? -h : h;
      points[side] = *wedge(moved.left, moved.right);
    }
    for (std::size_t row = 0; row < 4; ++row)
      jacobian[column * 4 + row] =
          (components(points[1])[row] - components(points[0])[row]) / (2 * h);
  }
  return jacobian;
}

/// Whether the wall stays in its case, alone, and well determined under small changes.
bool well_inside(const Readings& readings, const WedgeSolutions& solutions) {
  if (solutions.size() != 1 || solutions.undetermined) return false;
  const WallLine& wall = solutions[0].wall;
  for (const SonarReading<double>& sonar : {readings.left, readings.right}) {
    const double delta = std::abs(wrap_angle(wall.bearing - sonar.mount_heading));
    if (std::abs(delta - sonar.beam_half_angle) < 0.01 || delta > sonar.beam_half_angle + 1.3)
      return false;
  }
  const auto points = wedge_points(readings.left, readings.right, solutions[0]);
  return std::hypot(points.x2 - points.x1, points.z2 - points.z1) > 0.05;
}

TEST(WedgeSonarLine, DifferentiatesEachCaseAsCentralDifferencesDo) {
  constexpr unsigned seed = 9;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const Wedge module(WedgeSonarLine({}));
  std::array<int, 10> of_case{};
  for (int run = 0; run < 100000; ++run) {
    const auto sonar = [&] {
      return SonarReading<double>{0, uniform(2, 40) * degree, uniform(-0.3, 0.3),
                                  uniform(-0.3, 0.3), uniform(-0.6, 0.6)};
    };
    const Readings sonars{sonar(), sonar()};
    const WallLine wall{uniform(0.3, 3), uniform(-1.8, 1.8)};
    if (!sonar_contact(sonars.left, wall) || !sonar_contact(sonars.right, wall)) continue;
    const Readings readings = readings_of(sonars, wall);
    const auto solutions = solve_wedge(readings.left, readings.right);
    if (!well_inside(readings, solutions)) continue;
    const Output left = output_of(readings.left);
    const Output right = output_of(readings.right);
    Tick tick;
    tick.inputs = {&left, &right};
    const auto automatic = module.differentiate(tick.evaluation());
    ASSERT_TRUE(automatic);
    const auto numeric = central_differences(readings);
    for (std::size_t i = 0; i < numeric.size(); ++i)
      ASSERT_NEAR(automatic->jacobian[i], numeric[i], 1e-4 * (1 + std::abs(numeric[i])))
          << "run " << run << ", entry " << i << ", " << describe(solutions[0]);
    ++of_case[static_cast<std::size_t>(contact_label(solutions[0].left, solutions[0].right))];
  }
  for (std::size_t label = 1; label < of_case.size(); ++label)
    EXPECT_GT(of_case[label], 100) << wall_contacts[label];
}

Linearization<4, 10> derivatives(const Readings& readings) {
  const Wedge module(WedgeSonarLine({}));
  const Output left = output_of(readings.left);
  const Output right = output_of(readings.right);
  Tick tick;
  tick.inputs = {&left, &right};
  return *module.differentiate(tick.evaluation());
}

// On parallel axes 2w apart sin(phi) = (r_l - r_r) / 2w, so dphi/dr_l = 1 / (2w cos phi).
TEST(WedgeSonarLine, DifferentiatesTwoTangentsAsByHand) {
  const double phi = 5 * degree;
  const Readings readings = readings_of(side_by_side, {1, phi});
  const auto jacobian = derivatives(readings);
  const double c = std::cos(phi);
  const double s = std::sin(phi);
  const double turn = 1 / (0.2 * c);
  const double r1 = readings.left.range;
  const double r2 = readings.right.range;
  EXPECT_NEAR(jacobian.derivative(0, 0), c - r1 * s * turn, 1e-9);
  EXPECT_NEAR(jacobian.derivative(1, 0), s + r1 * c * turn, 1e-9);
  EXPECT_NEAR(jacobian.derivative(2, 0), -r2 * s * turn, 1e-9);
  EXPECT_NEAR(jacobian.derivative(3, 0), r2 * c * turn, 1e-9);
  EXPECT_NEAR(jacobian.derivative(0, 5), r1 * s * turn, 1e-9);
  EXPECT_NEAR(jacobian.derivative(3, 5), s - r2 * c * turn, 1e-9);
}

// A point on a beam's edge moves along the edge with its own range and across it with every angle.
TEST(WedgeSonarLine, DifferentiatesTwoEdgesAsByHand) {
  const Readings readings = readings_of(side_by_side, {1, 30 * degree});
  const auto jacobian = derivatives(readings);
  const double c = std::cos(11 * degree);
  const double s = std::sin(11 * degree);
  const double r1 = readings.left.range;
  const double expected_left[2][5] = {{c, -r1 * s, 1, 0, -r1 * s}, {s, r1 * c, 0, 1, r1 * c}};
  for (std::size_t row = 0; row < 2; ++row)
    for (std::size_t column = 0; column < 5; ++column) {
      EXPECT_NEAR(jacobian.derivative(row, column), expected_left[row][column], 1e-12);
      EXPECT_EQ(jacobian.derivative(row, column + 5), 0);
      EXPECT_EQ(jacobian.derivative(row + 2, column), 0);
    }
}

}  // namespace
}  // namespace ilss
