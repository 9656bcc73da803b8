// Fusion of estimates whose correlation is not known.
#include "sensors/fusion/covariance_intersection.h"

#include "sensors/fusion/fuse.h"
#include "tests/sensors/fusion/fusion_run.h"

namespace ilss::test {
namespace {

const std::vector<double> truth = {1.0, -2.0, 3.1};

Estimate intersected(const std::vector<Output>& inputs) {
  CovarianceIntersection module;
  ModuleRun result = run_on(module, inputs);
  EXPECT_TRUE(result.outcome) << (result.outcome.is_fault() ? result.outcome.fault().message : "");
  result.output.estimate.type = inputs.front().estimate.type;
  return result.output.estimate;
}

/// The same estimate with every random source renamed, so that what it shares is hidden.
Output with_hidden_correlation(Output output, std::uint32_t owner) {
  Lineage hidden(output.estimate.dimension());
  const Lineage& known = output.estimate.lineage;
  for (std::size_t k = 0; k < known.size(); ++k)
    hidden.add(known.sources()[k].persistent() ? known.sources()[k]
                                               : Source{owner, static_cast<std::uint32_t>(k), 0},
               known.column(k));
  output.estimate.lineage = hidden;
  return output;
}

/// Normalised errors over pairs of unequal estimates of one hidden correlation.
ConsistencyStatistic consistency_of(double correlation, std::uint64_t seed, bool systematic) {
  RandomBits random(seed);
  ConsistencyStatistic statistic;
  for (int r = 0; r < 4000; ++r) {
    Errors errors(derive_seed(seed, static_cast<std::uint64_t>(r)));
    const Eigen::MatrixXd factor = 0.05 * random_factor(3, random);
    std::vector<Output> inputs;
    for (std::uint32_t i = 0; i < 2; ++i) {
      Lineage lineage = correlated_pair(correlation, (i + 1.0) * factor)[i];
      if (systematic) add_columns(lineage, 60, 0.05 * random_factor(3, random), persistent_tick);
      inputs.push_back(with_hidden_correlation(drawn(pose(), truth, lineage, errors), 70 + i));
    }
    statistic.add(nees(intersected(inputs), truth));
  }
  return statistic;
}

TEST(CovarianceIntersection, IsNeverOverconfidentWhateverTheCorrelationIs) {
  const std::uint64_t seed = 1;
  for (const double correlation : {0.0, 0.5, 0.9, 1.0})
    for (const bool systematic : {false, true}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", correlation " << correlation
                                      << ", systematic errors " << systematic);
      const ConsistencyStatistic statistic = consistency_of(correlation, seed, systematic);
      EXPECT_LE(statistic.mean(), statistic.bounds(probability).high);
      EXPECT_EQ(statistic.unexplained(), 0);
    }
}

TEST(CovarianceIntersection, BoundHoldsForAnyJointCovarianceOfThreeInputs) {
  // The true covariance of sum W_i e_i under joint covariances drawn at random, with the marginal
  // covariances that the inputs state, never exceeds the stated one in any direction.
  const std::uint64_t seed = 2;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  RandomBits random(seed);
  for (int r = 0; r < 2000; ++r) {
    const Eigen::MatrixXd joint =
        0.1 * Eigen::MatrixXd::NullaryExpr(9, 3 + r % 7, [&] { return draw_normal(random); });
    std::vector<Output> inputs;
    for (std::uint32_t i = 0; i < 3; ++i) {
      inputs.push_back(output_of<Pose>({1, 2, 3}));
      inputs.back().estimate.lineage = lineage_of(80 + i, joint.middleRows(Eigen::Index{3} * i, 3));
    }
    const Estimate stated = intersected(inputs);
    // The gains, column by column, from what moving an input does.
    Eigen::MatrixXd moved(3, 9);
    for (std::uint32_t i = 0; i < 3; ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        const double step = 1e-3;
        std::vector<Output> shifted = inputs;
        shifted[i].estimate.value[c] += step;
        moved.col(Eigen::Index{3} * i + static_cast<Eigen::Index>(c)) =
            difference(intersected(shifted), stated.value) / step;
      }
    const Eigen::MatrixXd spare =
        stated.lineage.covariance() - moved * joint * joint.transpose() * moved.transpose();
    const double least = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(spare).eigenvalues()[0];
    ASSERT_GE(least, -1e-9 * stated.lineage.covariance().trace()) << "draw " << r;
  }
}

TEST(CovarianceIntersection, KeepsSystematicErrorsSystematicAndExact) {
  Lineage first = lineage_of(5, 0.1 * Eigen::MatrixXd::Identity(1, 1));
  Lineage second = lineage_of(6, 0.1 * Eigen::MatrixXd::Identity(1, 1));
  const double offset = 0.03;
  first.add({9, 0, persistent_tick}, {&offset, 1});
  second.add({9, 0, persistent_tick}, {&offset, 1});
  Errors errors(3);
  const Estimate result =
      intersected({drawn(length(), {1.0}, first, errors), drawn(length(), {1.0}, second, errors)});
  ASSERT_EQ(result.lineage.size(), 2u);
  EXPECT_EQ(result.lineage.sources()[0], (Source{1, 0, 0}));  // the module's own, of this tick
  EXPECT_NEAR(result.lineage.column(0)[0], 0.1, 1e-12);
  EXPECT_EQ(result.lineage.sources()[1], (Source{9, 0, persistent_tick}));
  EXPECT_NEAR(result.lineage.column(1)[0], offset, 1e-15);
}

TEST(CovarianceIntersection, SaysThatItsCorrelationIsUnknown) {
  EXPECT_TRUE(intersected({length_of(1, 0.1, 5), length_of(1, 0.1, 6)}).correlation_unknown);
}

TEST(CovarianceIntersection, OfOneEstimateTwiceIsThatEstimate) {
  Errors errors(4);
  RandomBits random(4);
  const Output one = drawn(pose(), truth, lineage_of(7, random_factor(3, random)), errors);
  const Estimate result = intersected({one, one});
  EXPECT_LE(difference(result, one.estimate.value).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LE((result.lineage.covariance() - one.estimate.lineage.covariance()).norm(), 1e-9);
}

TEST(CovarianceIntersection, TakesTheBetterOfTwoScalars) {
  // With one component the best weights are 0 and 1 (Julier & Uhlmann 1997, sec. 2).
  const Estimate result = intersected({length_of(1.0, 0.1, 5), length_of(1.1, 0.3, 6)});
  EXPECT_NEAR(result.value[0], 1.0, 1e-4);
  EXPECT_NEAR(result.lineage.standard_deviation(0), 0.1, 1e-4);
}

TEST(CovarianceIntersection, CrossedEllipsesGiveOneSmallerInVolumeThanEither) {
  // Variances 1, 4 and 4, 1: by symmetry w = 1/2 and P = diag(1.6, 1.6).
  const Estimate result = intersected(
      {output_of<Pose>({0, 0, 1}, {1, 2, 1}, 5), output_of<Pose>({1, 1, 1}, {2, 1, 1}, 6)});
  EXPECT_NEAR(result.lineage.variance(0), 1.6, 1e-6);
  EXPECT_NEAR(result.lineage.variance(1), 1.6, 1e-6);
  EXPECT_NEAR(result.value[0], 0.2, 1e-6);
  EXPECT_NEAR(result.value[1], 0.8, 1e-6);
}

TEST(CovarianceIntersection, DoesNotDependOnTheUnitsOfComponents) {
  // Lengths a thousand times as large, angles as they are.
  const auto scaled_result = [](double unit) {
    return intersected({output_of<Pose>({0, 0, 1}, {unit, 2 * unit, 0.1}, 5),
                        output_of<Pose>({unit, unit, 1.1}, {2 * unit, 1.5 * unit, 0.05}, 6)});
  };
  const Estimate small = scaled_result(1);
  const Estimate large = scaled_result(1000);
  EXPECT_NEAR(large.value[0], 1000 * small.value[0], 1e-6);
  EXPECT_NEAR(large.value[2], small.value[2], 1e-9);
  EXPECT_NEAR(large.lineage.variance(0), 1e6 * small.lineage.variance(0), 1e-3);
}

TEST(CovarianceIntersection, OrderOfInputsDoesNotMatter) {
  RandomBits random(5);
  Errors errors(5);
  std::vector<Output> inputs;
  for (std::uint32_t i = 0; i < 3; ++i)
    inputs.push_back(
        drawn(pose(), truth, lineage_of(10 + i, 0.1 * random_factor(3, random)), errors));
  const Estimate first = intersected(inputs);
  std::swap(inputs[0], inputs[2]);
  const Estimate second = intersected(inputs);
  EXPECT_LE(difference(first, second.value).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LE((first.lineage.covariance() - second.lineage.covariance()).norm(), 1e-12);
}

TEST(CovarianceIntersection, ExactBesideInexactGivesTheExactWithinAMillionth) {
  const Estimate result = intersected({output_of<Length>({2.0}), length_of(2.3, 0.2, 7)});
  EXPECT_NEAR(result.value[0], 2.0, 0.3e-6);
  EXPECT_LE(result.lineage.standard_deviation(0), 0.2e-6);
}

TEST(CovarianceIntersection, EstimatesOfLowerRankStayOfThatRank) {
  Eigen::MatrixXd line(3, 1);
  line << 1, 2, 0.5;
  const Output a = output_of<Pose>({1, 2, 0.5});
  std::vector<Output> inputs = {a, a};
  inputs[0].estimate.lineage = lineage_of(5, 0.1 * line);
  inputs[1].estimate.lineage = lineage_of(6, 0.2 * line);
  const Estimate result = intersected(inputs);
  EXPECT_EQ(normalized_squared_error(Eigen::VectorXd::Zero(3), result.lineage.covariance()).rank,
            1);
  EXPECT_NEAR(result.lineage.standard_deviation(0), 0.1, 1e-3);
}

TEST(CovarianceIntersection, ExactInputsThatDifferAreDegenerate) {
  CovarianceIntersection module;
  const ModuleRun result = run_on(module, {output_of<Length>({2.0}), output_of<Length>({2.5})});
  ASSERT_EQ(fault_of(result.outcome), "degenerate");
  EXPECT_EQ(result.outcome.fault().message,
            "inputs 1 and 2 both claim an exact 'x', but differ by 0.5 m");
}

TEST(CovarianceIntersection, IsWhatFuseDoesWhenAnInputsCorrelationIsUnknown) {
  Fuse fuse;
  std::vector<Output> inputs = {length_of(1, 0.1, 5), length_of(1.05, 0.12, 6)};
  inputs[1].estimate.correlation_unknown = true;
  const ModuleRun result = run_on(fuse, inputs);
  ASSERT_TRUE(result.outcome);
  EXPECT_TRUE(result.output.estimate.correlation_unknown);
  EXPECT_NEAR(result.output.estimate.lineage.standard_deviation(0), 0.1, 1e-3);
}

TEST(CovarianceIntersection, IsWhatFuseDoesWhenThePlanSaysSo) {
  Fuse fuse;
  const std::vector<Output> inputs = {length_of(1, 0.1, 5), length_of(1.05, 0.12, 6)};
  Tick tick;
  for (const Output& input : inputs) tick.inputs.push_back(&input);
  Output output;
  const Evaluation known = tick.evaluation();
  const Evaluation unknown{known.tick,       known.time,   known.seed, known.owner,
                           known.parameters, known.inputs, true};
  ASSERT_TRUE(fuse.evaluate(unknown, output));
  EXPECT_TRUE(output.estimate.correlation_unknown);
  Output fused;
  ASSERT_TRUE(fuse.evaluate(known, fused));
  EXPECT_FALSE(fused.estimate.correlation_unknown);
}

}  // namespace
}  // namespace ilss::test
