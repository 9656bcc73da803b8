// Which element is which: by hand.
#include "framework/study/set_matching.h"

#include <gtest/gtest.h>

#include "tests/framework/study/set_modules.h"

namespace ilss {
namespace {

using test::Piece;
using test::Spot;

Estimate piece(double first, double last) {
  Estimate element(descriptor<Piece>());
  assign<Piece>(element, {0, 0, first, last});
  return element;
}

Estimate spot(double x, double z, int colour = 0) {
  Estimate element(descriptor<Spot>());
  assign<Spot>(element, {x, z, {colour}});
  return element;
}

/// Matches as pairs of indices.
std::vector<std::pair<std::size_t, std::size_t>> matches_of(const ElementRule& rule,
                                                            const std::vector<Estimate>& truth,
                                                            const std::vector<Estimate>& found) {
  std::vector<const Estimate*> pointers[2];
  for (const Estimate& element : truth) pointers[0].push_back(&element);
  for (const Estimate& element : found) pointers[1].push_back(&element);
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const auto& [t, f] : match_elements(rule, pointers[0], pointers[1]))
    pairs.emplace_back(t, f);
  return pairs;
}

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

TEST(IntervalOverlap, IsIntersectionOverUnionOfWholeNumbers) {
  EXPECT_DOUBLE_EQ(interval_overlap(0, 9, 0, 9), 1);
  EXPECT_DOUBLE_EQ(interval_overlap(0, 9, 5, 14), 5.0 / 15);
  EXPECT_DOUBLE_EQ(interval_overlap(0, 9, 9, 9), 0.1);
  EXPECT_DOUBLE_EQ(interval_overlap(0, 9, 10, 19), 0);
}

TEST(MatchElements, TakesPairsThatOverlapEnough) {
  const ElementRule rule = element_rule(descriptor<Piece>());
  EXPECT_EQ(matches_of(rule, {piece(0, 9)}, {piece(0, 6)}), (Pairs{{0, 0}}));  // 7 of 10
  EXPECT_EQ(matches_of(rule, {piece(0, 9)}, {piece(0, 5)}), Pairs{});
  EXPECT_EQ(matches_of(rule, {piece(0, 9)}, {piece(0, 14)}), Pairs{});
}

TEST(MatchElements, IsOneToOneAndTheBestPairGoesFirst) {
  ElementRule rule = element_rule(descriptor<Piece>());
  rule.overlap = 0.3;
  // The second found one fits the first truth best; the first is left with the second truth.
  EXPECT_EQ(matches_of(rule, {piece(0, 9), piece(5, 14)}, {piece(2, 11), piece(0, 9)}),
            (Pairs{{0, 1}, {1, 0}}));
  EXPECT_EQ(matches_of(rule, {piece(0, 9)}, {piece(0, 8), piece(0, 9), piece(0, 7)}),
            (Pairs{{0, 1}}));
}

TEST(MatchElements, TakesTheNearestPlacesWithinTheGate) {
  const ElementRule rule = element_rule(descriptor<Spot>());
  EXPECT_EQ(matches_of(rule, {spot(0, 0), spot(0.08, 0)}, {spot(0.07, 0), spot(0.01, 0.02)}),
            (Pairs{{0, 1}, {1, 0}}));
  EXPECT_EQ(matches_of(rule, {spot(0, 0)}, {spot(0.08, 0.08)}), Pairs{});
}

TEST(MatchElements, PlacesNeedEqualLabels) {
  const ElementRule rule = element_rule(descriptor<Spot>());
  EXPECT_EQ(matches_of(rule, {spot(0, 0, 1)}, {spot(0, 0, 0), spot(0.05, 0, 1)}), (Pairs{{0, 1}}));
}

TEST(MatchElements, NothingMatchesWhatIsNotANumber) {
  const ElementRule by_place = element_rule(descriptor<Spot>());
  EXPECT_EQ(matches_of(by_place, {spot(0, 0)}, {spot(NAN, 0)}), Pairs{});
  const ElementRule by_readings = element_rule(descriptor<Piece>());
  EXPECT_EQ(matches_of(by_readings, {piece(0, 9)}, {piece(NAN, 9)}), Pairs{});
}

TEST(ElementRule, ConcernsElementsOfItsPayloadWithTheWantedLabels) {
  ElementRule rule = element_rule(descriptor<Spot>());
  EXPECT_TRUE(rule.applies_to(spot(0, 0, 0)));
  EXPECT_FALSE(rule.applies_to(piece(0, 9)));
  rule.only = {{0, 1}};
  EXPECT_FALSE(rule.applies_to(spot(0, 0, 0)));
  EXPECT_TRUE(rule.applies_to(spot(0, 0, 1)));
}

}  // namespace
}  // namespace ilss
