// Budgets: who is to blame, what halving would bring, and how well a standard deviation is known.
#include "framework/estimate/budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "framework/estimate/consistency.h"

namespace ilss {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// One component with errors of these owners.
std::vector<BudgetEntry> entries_of(const std::vector<double>& deviations) {
  Lineage lineage(1);
  for (std::size_t k = 0; k < deviations.size(); ++k)
    lineage.add({static_cast<std::uint32_t>(k), 0, persistent_tick}, std::size_t{0}, deviations[k]);
  return budget(lineage);
}

SourceOwners owners_of(const std::vector<double>& degrees_of_freedom) {
  SourceOwners owners;
  for (const double degrees : degrees_of_freedom) owners.push_back({"x", true, {}, degrees});
  return owners;
}

TEST(Budget, JoinsColumnsOfOneOwner) {
  Lineage lineage(1);
  lineage.add({3, 0, 0}, std::size_t{0}, 3);
  lineage.add({3, 1, 0}, std::size_t{0}, 4);
  const auto entries = budget(lineage);
  ASSERT_EQ(entries.size(), 1U);
  EXPECT_EQ(entries[0].variance[0], 25);
}

TEST(Budget, HalvingTheOnlySourceHalvesTheError) {
  const auto one = entries_of({3});
  EXPECT_DOUBLE_EQ(deviation_if_halved(one, 0, 0), 1.5);
  const auto two = entries_of({3, 4});
  EXPECT_DOUBLE_EQ(deviation_if_halved(two, 1, 0), std::sqrt(13));
}

// JCGM 100:2008, G.4.1: y of three factors with relative uncertainties 0.25, 0.57, 0.82 % on 9, 4
// and 14 degrees of freedom has 19.0.
TEST(DegreesOfFreedom, OfTheGuidesExample) {
  EXPECT_NEAR(
      effective_degrees_of_freedom(entries_of({0.25, 0.57, 0.82}), owners_of({9, 4, 14}), 0), 19.0,
      0.05);
}

TEST(DegreesOfFreedom, AreInfiniteWhereEveryErrorIsKnown) {
  EXPECT_EQ(effective_degrees_of_freedom(entries_of({1, 2}), owners_of({infinity, infinity}), 0),
            infinity);
  EXPECT_EQ(effective_degrees_of_freedom({}, {}, 0), infinity);
}

// JCGM 100:2008, table G.2.
TEST(CoverageFactor, IsThatOfStudentsT) {
  EXPECT_NEAR(coverage_factor(1, 0.95), 12.71, 0.005);
  EXPECT_NEAR(coverage_factor(5, 0.9545), 2.65, 0.005);
  EXPECT_NEAR(coverage_factor(16, 0.99), 2.92, 0.005);
  EXPECT_NEAR(coverage_factor(infinity, 0.95), 1.960, 0.0005);
}

}  // namespace
}  // namespace ilss
