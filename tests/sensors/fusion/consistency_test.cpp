// Whether estimates differ by no more than they say.
#include "sensors/fusion/consistency.h"

#include "tests/sensors/fusion/fusion_run.h"

namespace ilss::test {
namespace {

const std::vector<double> truth = {1.0, -2.0, 3.1};

Consistency<double> consistency_of(const std::vector<Output>& inputs) {
  ConsistencyModule module;
  const ModuleRun result = run_on(module, inputs);
  EXPECT_TRUE(result.outcome);
  EXPECT_TRUE(result.output.estimate.lineage.empty());
  return payload_of<Consistency>(result.output.estimate);
}

TEST(Consistency, OfTwoScalarsIsTheirSquaredDistanceInStandardDeviations) {
  const auto result = consistency_of({length_of(1.0, 0.3, 5), length_of(2.0, 0.4, 6)});
  EXPECT_NEAR(result.nis, 4, 1e-12);
  EXPECT_EQ(result.degrees_of_freedom, 1);
  EXPECT_NEAR(result.probability, 0.04550026, 1e-8);  // of 2 standard deviations, both tails
}

TEST(Consistency, OfTwoEstimatesIsTheirNormalisedInnovationSquared) {
  RandomBits random(1);
  Errors errors(1);
  std::vector<Output> inputs;
  for (std::uint32_t i = 0; i < 2; ++i) {
    Lineage lineage = lineage_of(10 + i, 0.1 * random_factor(3, random));
    add_columns(lineage, 20, 0.1 * random_factor(3, random));
    inputs.push_back(drawn(pose(), truth, lineage, errors));
  }
  const auto result = consistency_of(inputs);
  const NormalizedError expected = nis(inputs[0].estimate, inputs[1].estimate);
  EXPECT_NEAR(result.nis, expected.value, 1e-9 * expected.value);
  EXPECT_EQ(result.degrees_of_freedom, expected.rank);
}

TEST(Consistency, ProbabilityIsUniformWhereInputsAreHonest) {
  const std::uint64_t seed = 2;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  RandomBits random(seed);
  constexpr int runs = 4000;
  constexpr int bins = 10;
  std::array<int, bins> counts{};
  for (int r = 0; r < runs; ++r) {
    Errors errors(derive_seed(seed, static_cast<std::uint64_t>(r)));
    std::vector<Output> inputs;
    for (std::uint32_t i = 0; i < 3; ++i) {
      Lineage lineage = lineage_of(10 + i, 0.1 * random_factor(3, random));
      add_columns(lineage, 20, 0.1 * random_factor(3, random));
      inputs.push_back(drawn(pose(), truth, lineage, errors));
    }
    const auto result = consistency_of(inputs);
    ASSERT_EQ(result.degrees_of_freedom, 6);
    ++counts[std::min<std::size_t>(bins - 1, static_cast<std::size_t>(result.probability * bins))];
  }
  double chi_square = 0;
  constexpr double expected = 1.0 * runs / bins;
  for (const int count : counts) chi_square += std::pow(count - expected, 2) / expected;
  EXPECT_LT(chi_square, chi_square_quantile(bins - 1, probability));
}

TEST(Consistency, NothingToCompareIsCertain) {
  const auto result = consistency_of({length_of(1, 0.1, 5), length_of(1, 0.1, 5)});
  EXPECT_EQ(result.nis, 0);
  EXPECT_EQ(result.degrees_of_freedom, 0);
  EXPECT_EQ(result.probability, 1);
}

TEST(Consistency, ExactInputsThatDifferCannotBe) {
  EXPECT_EQ(consistency_of({output_of<Length>({1}), output_of<Length>({1.01})}).probability, 0);
}

TEST(Consistency, SharedErrorsThatCannotExplainADifferenceCannotBe) {
  EXPECT_EQ(consistency_of({length_of(1, 0.1, 5), length_of(2.5, 0.1, 5)}).probability, 0);
}

TEST(Consistency, DifferencesOfAnglesAreTakenOnTheCircle) {
  const auto result = consistency_of({output_of<Pose>({0, 0, pi - 0.01}, {1, 1, 0.1}, 5),
                                      output_of<Pose>({0, 0, -pi + 0.01}, {1, 1, 0.1}, 6)});
  EXPECT_NEAR(result.nis, 0.02, 1e-9);
}

TEST(Consistency, OfUnknownCorrelationIsABoundThatHoldsForAny) {
  // Var(a - b) of sd 0.3 and 0.4 is at most 0.49; the bound is 2 (0.09 + 0.16) = 0.5.
  std::vector<Output> inputs = {length_of(1.0, 0.3, 5), length_of(2.0, 0.4, 6)};
  inputs[0].estimate.correlation_unknown = true;
  EXPECT_NEAR(consistency_of(inputs).nis, 2, 1e-12);
}

TEST(Consistency, SystematicErrorsThatAreSharedCancelWhereCorrelationIsUnknown) {
  std::vector<Output> inputs = {length_of(1.0, 0.3, 5), length_of(2.0, 0.4, 6)};
  for (Output& input : inputs) {
    input.estimate.correlation_unknown = true;
    input.estimate.lineage.add({9, 0, persistent_tick}, 0, 10.0);
  }
  EXPECT_NEAR(consistency_of(inputs).nis, 2, 1e-9);
}

}  // namespace
}  // namespace ilss::test
