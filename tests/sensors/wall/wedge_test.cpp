// The geometry of two sonars and one wall, on hundreds of thousands of random walls.
#include "sensors/wall/wedge.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <numbers>
#include <random>

#include "framework/estimate/angle.h"
#include "sensors/scene/beam.h"
#include "tests/sensors/wall/sonar_contact.h"

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }

 private:
  std::mt19937_64 engine_;
};

struct Pair {
  SonarReading<double> left;
  SonarReading<double> right;
};

/// Any places within 0.3 m and axes within 0.6 rad of forward; both beams of their own width.
Pair random_pair(Random& random) {
  const auto sonar = [&] {
    return SonarReading<double>{0, random(1, 40) * degree, random(-0.3, 0.3), random(-0.3, 0.3),
                                random(-0.6, 0.6)};
  };
  return {sonar(), sonar()};
}

/// Side by side with equal axes.
Pair parallel_pair(Random& random) {
  const double beam = random(1, 40) * degree;
  const double half_width = random(0.01, 0.5);
  return {{0, beam, 0, -half_width, 0}, {0, beam, 0, half_width, 0}};
}

/// Neighbours on a ring, looking outwards.
Pair ring_pair(Random& random) {
  const double beam = random(1, 40) * degree;
  const double radius = random(0.05, 0.5);
  const double spacing = random(1, 30) * degree;
  const double left = random(-std::numbers::pi, std::numbers::pi);
  const double right = left + spacing;
  return {{0, beam, radius * std::cos(left), radius * std::sin(left), left},
          {0, beam, radius * std::cos(right), radius * std::sin(right), right}};
}

/// A wall that both sonars of `pair` get an echo from within 10 m; the ranges go into `pair`.
struct SeenWall {
  WallLine wall;
  Contact left;
  Contact right;
};
SeenWall random_wall(Random& random, Pair& pair) {
  for (;;) {
    const WallLine wall{random(0.02, 5), random(-std::numbers::pi, std::numbers::pi)};
    const auto left = sonar_contact(pair.left, wall);
    const auto right = sonar_contact(pair.right, wall);
    if (!left || !right || left->range > 10 || right->range > 10) continue;
    pair.left.range = left->range;
    pair.right.range = right->range;
    return {wall, left->contact, right->contact};
  }
}

bool same(const WallLine& a, const WallLine& b) {
  return std::abs(a.range - b.range) < 1e-5 && std::abs(wrap_angle(a.bearing - b.bearing)) < 1e-5;
}

const WedgeSolution* find(const WedgeSolutions& solutions, const WallLine& wall) {
  for (const WedgeSolution& solution : solutions)
    if (same(solution.wall, wall)) return &solution;
  return nullptr;
}

TEST(SolveWedge, FindsTheTrueWallWithItsCaseAmongRandomMountings) {
  constexpr unsigned seed = 1997;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  Random random(seed);
  std::array<int, 10> of_case{};
  int several = 0;
  for (int run = 0; run < 200000; ++run) {
    Pair pair = random_pair(random);
    const SeenWall seen = random_wall(random, pair);
    const WedgeSolutions solutions = solve_wedge(pair.left, pair.right);
    const WedgeSolution* truth = find(solutions, seen.wall);
    ASSERT_NE(truth, nullptr) << "run " << run;
    ASSERT_EQ(truth->left, seen.left) << "run " << run;
    ASSERT_EQ(truth->right, seen.right) << "run " << run;
    ASSERT_FALSE(solutions.undetermined) << "run " << run;
    ++of_case[static_cast<std::size_t>(contact_label(seen.left, seen.right))];
    several += solutions.size() > 1;
  }
  for (std::size_t label = 1; label < of_case.size(); ++label)
    EXPECT_GT(of_case[label], 1000) << wall_contacts[label];
  EXPECT_GT(several, 10000);
}

TEST(SolveWedge, GivesOnlyWallsThatReproduceBothReadingsInTheirCase) {
  constexpr unsigned seed = 11;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  Random random(seed);
  int checked = 0;
  for (int run = 0; run < 100000; ++run) {
    Pair pair = random_pair(random);
    random_wall(random, pair);
    for (const WedgeSolution& solution : solve_wedge(pair.left, pair.right)) {
      const auto left = sonar_contact(pair.left, solution.wall);
      const auto right = sonar_contact(pair.right, solution.wall);
      ASSERT_TRUE(left && right) << "run " << run;
      ASSERT_NEAR(left->range, pair.left.range, 1e-6 * pair.left.range) << "run " << run;
      ASSERT_NEAR(right->range, pair.right.range, 1e-6 * pair.right.range) << "run " << run;
      ASSERT_EQ(left->contact, solution.left) << "run " << run;
      ASSERT_EQ(right->contact, solution.right) << "run " << run;
      ++checked;
    }
  }
  EXPECT_GT(checked, 100000);
}

void expect_never_ambiguous(Pair (*mounting)(Random&), std::initializer_list<int> labels) {
  constexpr unsigned seed = 24;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  Random random(seed);
  std::array<int, 10> of_case{};
  for (int run = 0; run < 100000; ++run) {
    Pair pair = mounting(random);
    const SeenWall seen = random_wall(random, pair);
    const WedgeSolutions solutions = solve_wedge(pair.left, pair.right);
    ASSERT_EQ(solutions.size(), 1u) << "run " << run;
    ASSERT_TRUE(same(solutions[0].wall, seen.wall)) << "run " << run;
    ASSERT_EQ(solutions[0].left, seen.left) << "run " << run;
    ASSERT_EQ(solutions[0].right, seen.right) << "run " << run;
    ++of_case[static_cast<std::size_t>(contact_label(seen.left, seen.right))];
  }
  int in_labels = 0;
  for (const int label : labels) {
    EXPECT_GT(of_case[static_cast<std::size_t>(label)], 100) << wall_contacts[label];
    in_labels += of_case[static_cast<std::size_t>(label)];
  }
  EXPECT_EQ(in_labels, 100000) << "some other case occurred";
}

// SEEDS, section 1: equal axes leave (-,-), (0,0) and (+,+).
TEST(SolveWedge, IsNeverAmbiguousForParallelSonarsSideBySide) {
  expect_never_ambiguous(parallel_pair, {1, 5, 9});
}

// Axes that diverge to the right give five cases as the wall turns: (-,-), (0,-), then (0,0) or
// (+,-), then (+,0), (+,+).
TEST(SolveWedge, IsNeverAmbiguousForNeighboursOnARing) {
  expect_never_ambiguous(ring_pair, {1, 4, 5, 7, 8, 9});
}

TEST(SolveWedge, CountsAWallOnACaseBoundaryOnce) {
  const double beam = 11 * degree;
  for (const double bearing : {beam, -beam, beam - 1e-9, beam + 1e-9}) {
    Pair pair{{0, beam, 0, -0.1, 0}, {0, beam, 0, 0.1, 0}};
    const WallLine wall{1, bearing};
    pair.left.range = sonar_contact(pair.left, wall)->range;
    pair.right.range = sonar_contact(pair.right, wall)->range;
    const WedgeSolutions solutions = solve_wedge(pair.left, pair.right);
    ASSERT_EQ(solutions.size(), 1u) << "bearing " << bearing;
    EXPECT_TRUE(same(solutions[0].wall, wall)) << "bearing " << bearing;
  }
}

TEST(SolveWedge, SaysThatTwoSonarsInOnePlaceDoNotDetermineTheWall) {
  const SonarReading<double> sonar{1, 11 * degree, 0.1, 0.2, 0.3};
  SonarReading<double> other = sonar;
  EXPECT_TRUE(solve_wedge(sonar, other).undetermined);
  other.range = 1.01;
  EXPECT_TRUE(solve_wedge(sonar, other).undetermined);
  other.range = sonar.range;
  other.mount_heading += 5 * degree;  // both touch every wall between their axes as a tangent
  EXPECT_TRUE(solve_wedge(sonar, other).undetermined);
}

TEST(SonarContact, AgreesWithTheNearestPointOfASimulatedWall) {
  constexpr unsigned seed = 3;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  Random random(seed);
  std::array<int, 3> of_contact{};
  for (int run = 0; run < 50000; ++run) {
    const SonarReading<double> sonar = random_pair(random).left;
    const WallLine wall{random(0.02, 5), random(-std::numbers::pi, std::numbers::pi)};
    // Long enough to be endless for ranges below 100 m.
    const double nx = std::cos(wall.bearing);
    const double nz = std::sin(wall.bearing);
    const Scene scene{"",
                      {{{wall.range * nx - 200 * nz, wall.range * nz + 200 * nx},
                        {wall.range * nx + 200 * nz, wall.range * nz - 200 * nx},
                        0.8,
                        {}}}};
    const auto hit = nearest_in_beam(scene, {sonar.mount_x, sonar.mount_z, sonar.mount_heading},
                                     sonar.beam_half_angle, 100);
    const auto contact = sonar_contact(sonar, wall);
    const double distance = wall.range - nx * sonar.mount_x - nz * sonar.mount_z;
    if (distance < 0) continue;  // the sonar has crossed the wall and sees its other side
    ASSERT_EQ(hit.has_value(), contact.has_value() && contact->range <= 100) << "run " << run;
    if (!hit) continue;
    ASSERT_NEAR(hit->range, contact->range, 1e-9 * contact->range * contact->range / distance)
        << "run " << run;
    ++of_contact[static_cast<std::size_t>(static_cast<int>(contact->contact) + 1)];
  }
  for (const int count : of_contact) EXPECT_GT(count, 3000);
}

}  // namespace
}  // namespace ilss
