// The best estimate of several, whatever errors they share.
#include "sensors/fusion/fuse.h"

#include "sensors/camera/vision_line.h"
#include "sensors/fusion/fusion_inputs.h"
#include "tests/sensors/fusion/fusion_run.h"

namespace ilss::test {
namespace {

const std::vector<double> truth = {1.0, -2.0, 3.1};  // a heading 2.4 degrees from pi

Eigen::MatrixXd pose_factor() {
  return (Eigen::MatrixXd(3, 3) << 0.03, 0, 0, 0.01, 0.05, 0, -0.02, 0.03, 0.08).finished();
}

Estimate fused(const std::vector<Output>& inputs) {
  Fuse module;
  ModuleRun result = run_on(module, inputs);
  EXPECT_TRUE(result.outcome) << (result.outcome.is_fault() ? result.outcome.fault().message : "");
  result.output.estimate.type = inputs.front().estimate.type;
  return result.output.estimate;
}

void expect_same(const Estimate& a, const Estimate& b, double tolerance) {
  EXPECT_LE(difference(a, b.value).cwiseAbs().maxCoeff(), tolerance);
  EXPECT_LE((a.lineage.covariance() - b.lineage.covariance()).cwiseAbs().maxCoeff(), tolerance);
  EXPECT_LE((cross_covariance(a.lineage, b.lineage) - a.lineage.covariance()).cwiseAbs().maxCoeff(),
            tolerance);
}

/// Weights by inverse variance, as if the two were independent.
Estimate naively_fused(const Output& a, const Output& b) {
  const Eigen::MatrixXd first = a.estimate.lineage.covariance().inverse();
  const Eigen::MatrixXd second = b.estimate.lineage.covariance().inverse();
  const Eigen::MatrixXd covariance = (first + second).inverse();
  Estimate result = a.estimate;
  const Eigen::VectorXd moved = covariance * second * difference(b.estimate, a.estimate.value);
  for (std::size_t c = 0; c < result.dimension(); ++c)
    result.value[c] += moved[static_cast<Eigen::Index>(c)];
  result.lineage.reset(result.dimension());
  result.lineage.add_noise({99, 0, 0}, covariance);
  return result;
}

constexpr int runs = 4000;

template <typename Fusion>
ConsistencyStatistic consistency_of(double correlation, std::uint64_t seed, const Fusion& fusion) {
  ConsistencyStatistic statistic;
  const std::vector<Lineage> lineages = correlated_pair(correlation, pose_factor());
  for (int r = 0; r < runs; ++r) {
    Errors errors(derive_seed(seed, static_cast<std::uint64_t>(r)));
    const Output a = drawn(pose(), truth, lineages[0], errors);
    const Output b = drawn(pose(), truth, lineages[1], errors);
    statistic.add(nees(fusion(a, b), truth));
  }
  return statistic;
}

TEST(Fuse, IsAsWrongAsItSaysWhateverTheCorrelation) {
  for (const double correlation : {0.0, 0.5, 0.9}) {
    const std::uint64_t seed = 1;
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", correlation " << correlation);
    const auto statistic = consistency_of(correlation, seed, [](const Output& a, const Output& b) {
      return fused({a, b});
    });
    EXPECT_TRUE(statistic.consistent(probability)) << statistic.mean();
  }
}

TEST(Fuse, NaiveFusionOfCorrelatedEstimatesIsOverconfident) {
  // Of two estimates of correlation r, the naive variance is too small by the factor 1 + r.
  const std::uint64_t seed = 2;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  const ConsistencyStatistic statistic = consistency_of(0.9, seed, naively_fused);
  EXPECT_FALSE(statistic.consistent(probability));
  EXPECT_NEAR(statistic.mean(), 1.9, 0.1);
}

TEST(Fuse, IsAsWrongAsItSaysForPartlySharedErrorsOfUnequalEstimates) {
  const std::uint64_t seed = 3;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  RandomBits random(seed);
  ConsistencyStatistic statistic;
  for (int r = 0; r < runs; ++r) {
    std::vector<Output> inputs;
    Errors errors(derive_seed(seed, static_cast<std::uint64_t>(r)));
    for (std::uint32_t i = 0; i < 3; ++i) {
      Lineage lineage = lineage_of(10 + i, 0.1 * random_factor(3, random));
      add_columns(lineage, 20, 0.1 * random_factor(3, random), persistent_tick);
      inputs.push_back(drawn(pose(), truth, lineage, errors));
    }
    statistic.add(nees(fused(inputs), truth));
  }
  EXPECT_TRUE(statistic.consistent(probability)) << statistic.mean();
}

TEST(Fuse, EstimatesThatAreTheSameStayAsTheyAre) {
  Errors errors(4);
  const Output one = drawn(pose(), truth, lineage_of(7, pose_factor()), errors);
  expect_same(fused({one, one}), one.estimate, 1e-15);
  expect_same(fused({one, one, one}), one.estimate, 1e-15);
}

TEST(Fuse, SameErrorsByAnotherWayOfComputingAddNothing) {
  // As after a + b - b: equal but for rounding, which must not pass for information.
  Errors errors(5);
  const Output one = drawn(pose(), truth, lineage_of(7, pose_factor()), errors);
  Output other = one;
  other.estimate.lineage = lineage_of(7, pose_factor() * (1 + 3e-16));
  other.estimate.value[0] += 4e-16;
  expect_same(fused({one, other}), one.estimate, 1e-14);
}

TEST(Fuse, ExactBesideInexactGivesTheExact) {
  const Output exact = output_of<Length>({2.0});
  const Output inexact = length_of(2.3, 0.2, 7);
  for (const auto& inputs : {std::vector{exact, inexact}, std::vector{inexact, exact}}) {
    const Estimate result = fused(inputs);
    EXPECT_NEAR(result.value[0], 2.0, 1e-15);
    EXPECT_EQ(result.lineage.variance(0), 0.0);
  }
}

TEST(Fuse, ExactComponentsComeOutExactAndTeachTheOthers) {
  // One knows x exactly, the other's errors in x and z are the same one: so z is known, too.
  Output exact_in_x = output_of<Pose>({1.0, 2.0, 0.0}, {0, 1.0, 0}, 5);
  Output correlated = output_of<Pose>({1.1, 2.1, 0.0});
  const double column[] = {0.1, 0.1, 0.0};
  correlated.estimate.lineage.add({6, 0, 0}, column);
  const Estimate result = fused({exact_in_x, correlated});
  EXPECT_NEAR(result.value[0], 1.0, 1e-12);
  EXPECT_NEAR(result.value[1], 2.0, 1e-12);
  EXPECT_NEAR(result.lineage.standard_deviation(1), 0, 1e-12);
}

TEST(Fuse, AnglesAreFusedAcrossPi) {
  const Output a = output_of<Pose>({0, 0, pi - 0.03}, {1, 1, 0.1}, 5);
  const Output b = output_of<Pose>({0, 0, -pi + 0.05}, {1, 1, 0.1}, 6);
  const Estimate result = fused({a, b});
  EXPECT_NEAR(result.value[2], -pi + 0.01, 1e-12);
  EXPECT_NEAR(result.lineage.variance(2), 0.005, 1e-12);
}

TEST(Fuse, OrderOfInputsDoesNotMatter) {
  RandomBits random(6);
  Errors errors(6);
  std::vector<Output> inputs;
  for (std::uint32_t i = 0; i < 3; ++i) {
    Lineage lineage = lineage_of(10 + i, 0.1 * random_factor(3, random));
    add_columns(lineage, 20, 0.1 * random_factor(3, random));
    inputs.push_back(drawn(pose(), truth, lineage, errors));
  }
  const Estimate first = fused(inputs);
  std::swap(inputs[0], inputs[2]);
  expect_same(fused(inputs), first, 1e-12);
  std::swap(inputs[0], inputs[1]);
  expect_same(fused(inputs), first, 1e-12);
}

TEST(Fuse, VarianceIsNeverAboveTheBestInputs) {
  const std::uint64_t seed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  RandomBits random(seed);
  for (int r = 0; r < 2000; ++r) {
    Errors errors(derive_seed(seed, static_cast<std::uint64_t>(r)));
    std::vector<Output> inputs;
    for (std::uint32_t i = 0; i < 3; ++i) {
      const double size = 0.01 * std::pow(10.0, draw_uniform(random, -3, 3));
      Lineage lineage = lineage_of(10 + i, size * random_factor(3, random));
      add_columns(lineage, 20, size * random_factor(3, random));
      inputs.push_back(drawn(pose(), truth, lineage, errors));
    }
    const Estimate result = fused(inputs);
    for (std::size_t c = 0; c < 3; ++c)
      for (const Output& input : inputs)
        EXPECT_LE(result.lineage.variance(c), input.estimate.lineage.variance(c) * (1 + 1e-9));
  }
}

TEST(Fuse, OfIndependentEstimatesIsTheBatchLeastSquares) {
  const std::uint64_t seed = 8;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  RandomBits random(seed);
  Errors errors(seed);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(3, 3);
  Eigen::VectorXd weighted = Eigen::VectorXd::Zero(3);
  std::vector<Output> inputs;
  for (std::uint32_t i = 0; i < 3; ++i) {
    inputs.push_back(
        drawn(pose(), truth, lineage_of(10 + i, 0.02 * random_factor(3, random)), errors));
    const Eigen::MatrixXd weight = inputs.back().estimate.lineage.covariance().inverse();
    information += weight;
    weighted += weight * difference(inputs.back().estimate, truth);
  }
  const Estimate result = fused(inputs);
  const Eigen::VectorXd expected = information.inverse() * weighted;
  EXPECT_LE((difference(result, truth) - expected).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LE((result.lineage.covariance() - information.inverse()).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Fuse, LineageIsWhatMovingEachSourceDoes) {
  RandomBits random(9);
  std::vector<Lineage> lineages;
  for (std::uint32_t i = 0; i < 3; ++i) {
    lineages.push_back(lineage_of(10 + i, 0.05 * random_factor(3, random)));
    add_columns(lineages.back(), 20, 0.05 * random_factor(3, random), persistent_tick);
  }
  const auto moved_by = [&](const Source& source, double amount) {
    Errors errors(9);
    std::vector<Output> inputs;
    for (const Lineage& lineage : lineages) drawn(pose(), truth, lineage, errors);
    errors.move(source, amount);
    inputs.reserve(lineages.size());
    for (const Lineage& lineage : lineages) inputs.push_back(drawn(pose(), truth, lineage, errors));
    return fused(inputs);
  };
  const Estimate result = moved_by({10, 0, 0}, 0);
  ASSERT_EQ(result.lineage.size(), 12u);
  for (std::size_t k = 0; k < result.lineage.size(); ++k) {
    const Source source = result.lineage.sources()[k];
    // Linear but for the circle, so any step is exact.
    const Eigen::VectorXd slope = difference(moved_by(source, 0.5), moved_by(source, -0.5).value);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(slope[static_cast<Eigen::Index>(c)], result.lineage.column(k)[c], 1e-12);
  }
}

/// Wall points of fixed abscissae: linear in offset and slope, so of rank 2.
Eigen::MatrixXd wall_of_rank_two() {
  return (Eigen::MatrixXd(4, 2) << 0, 0, 1, 0, 0, 0, 1, 0.7).finished();
}

TEST(Fuse, WallPointsOfRankTwoAreFusedInTheirTwoUnknowns) {
  const std::uint64_t seed = 10;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  const Eigen::MatrixXd map = wall_of_rank_two();
  RandomBits random(seed);
  ConsistencyStatistic statistic;
  for (int r = 0; r < 2000; ++r) {
    Errors errors(derive_seed(seed, static_cast<std::uint64_t>(r)));
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(2, 2);
    Eigen::VectorXd weighted = Eigen::VectorXd::Zero(2);
    const std::vector<double> wall = {0, 1, 0.7, 1.14};
    std::vector<Output> inputs;
    for (std::uint32_t i = 0; i < 3; ++i) {
      const Eigen::MatrixXd factor = 0.01 * random_factor(2, random);
      inputs.push_back(
          drawn(descriptor<WallPoints>(), wall, lineage_of(10 + i, map * factor), errors));
      inputs.back().estimate.labels = {static_cast<int>(i)};
      const Eigen::VectorXd unknowns =
          map.completeOrthogonalDecomposition().solve(difference(inputs.back().estimate, wall));
      const Eigen::MatrixXd weight = (factor * factor.transpose()).inverse();
      information += weight;
      weighted += weight * unknowns;
    }
    const Estimate result = fused(inputs);
    const Eigen::VectorXd expected = map * (information.inverse() * weighted);
    ASSERT_LE((difference(result, wall) - expected).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_EQ(result.labels, std::vector<int>{0});
    const NormalizedError error = nees(result, wall);
    EXPECT_EQ(error.rank, 2);
    statistic.add(error);
  }
  EXPECT_TRUE(statistic.consistent(probability)) << statistic.mean();
}

TEST(Fuse, TiltedTangentPlanesOfACurvedPayloadAreNotTakenForExact) {
  // Two images of one wall: (0, z) and (cos a, z - sin a) lie on a curved surface, and each
  // estimate claims to be exact across its own tangent plane. Their planes' intersection is no
  // knowledge: taken for it, the second point would be exact.
  const std::uint64_t seed = 11;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  FunctionModule<VisionLine> line{VisionLine{}};
  Tick tick;
  tick.parameters = Estimate(descriptor<VisionLine::Parameters>());
  tick.parameters.value = {0.2, 0.3, 0.006, 1};
  tick.parameters.lineage.reset(4);
  for (const double angle : {0.0, 0.3, -0.6}) {
    SCOPED_TRACE(testing::Message() << "angle " << angle);
    const double side = 0.15 * std::sin(angle);
    const std::vector<double> depths = {1.2 + side, 1.2, 1.2 - side};
    const std::vector<double> wall = {0, 1.2, std::cos(angle), 1.2 - std::sin(angle)};
    const double row_std = 2e-6;
    ConsistencyStatistic statistic;
    double squared_error = 0;
    double variance = 0;
    for (int r = 0; r < 2000; ++r) {
      Errors errors(derive_seed(seed, static_cast<std::uint64_t>(r)));
      std::vector<Output> walls;
      for (std::uint32_t i = 0; i < 2; ++i) {
        std::vector<double> rows;
        rows.reserve(depths.size());
        for (const double depth : depths) rows.push_back(0.2 * 0.006 / depth);
        const Output seen =
            drawn(descriptor<TargetRows>(), rows,
                  lineage_of(10 + i, row_std * Eigen::MatrixXd::Identity(3, 3)), errors);
        tick.inputs = {&seen};
        walls.push_back(run(line, tick).output);
        walls.back().estimate.type = &descriptor<WallPoints>();
      }
      const Estimate result = fused(walls);
      const Eigen::Vector2d error = difference(result, wall)({1, 3});
      const Eigen::Matrix2d covariance = result.lineage.covariance()({1, 3}, {1, 3});
      statistic.add(normalized_squared_error(error, covariance));
      squared_error += error[1] * error[1];
      variance += covariance(1, 1);
    }
    EXPECT_TRUE(statistic.consistent(0.999)) << statistic.mean();
    EXPECT_NEAR(squared_error / variance, 1, 0.2);
  }
}

/// A lineage of any rank, from 0 up, whose errors are its own, shared, or both.
Lineage any_lineage(std::uint32_t i, RandomBits& random) {
  const auto choice = [](RandomBits& bits) {
    return static_cast<Eigen::Index>(draw_index(bits, 4));
  };
  const auto factor = [&] {
    const double size = 0.1 * std::pow(10.0, draw_uniform(random, -3, 0));
    return Eigen::MatrixXd(size * random_factor(3, random).leftCols(choice(random)));
  };
  Lineage lineage(3);
  add_columns(lineage, 10 + i, factor());
  add_columns(lineage, 20, factor());  // one source, other sensitivities
  if (choice(random) == 0) return lineage_of(30, 0.1 * Eigen::MatrixXd::Identity(3, 3));
  return lineage;
}

TEST(Fuse, HoldsForAnyMixtureOfRanksAndSharedErrors) {
  const std::uint64_t seed = 12;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  RandomBits random(seed);
  ConsistencyStatistic statistic;
  for (int r = 0; r < 5000; ++r) {
    SCOPED_TRACE(testing::Message() << "run " << r);
    Errors errors(derive_seed(seed, static_cast<std::uint64_t>(r)));
    std::vector<Output> inputs;
    for (std::uint32_t i = 0; i < 2 + static_cast<std::uint32_t>(r) % 3; ++i)
      inputs.push_back(drawn(pose(), truth, any_lineage(i, random), errors));
    const Estimate result = fused(inputs);
    // Two of different rank 1 leave nothing but rounding.
    if (difference(result, truth).norm() > 1e-12) {
      const NormalizedError error = nees(result, truth);
      ASSERT_LT(error.unexplained, 1e-3);
      statistic.add(error);
    }
    for (const Output& input : inputs)
      for (std::size_t c = 0; c < 3; ++c)
        // Where two planes count as one, the best is not quite reached (1.15 here).
        ASSERT_LE(result.lineage.variance(c), 1.2 * input.estimate.lineage.variance(c) + 1e-12);
  }
  EXPECT_TRUE(statistic.consistent(probability)) << statistic.mean();
}

TEST(Fuse, ExactInputsThatDifferAreDegenerate) {
  Fuse module;
  const ModuleRun result = run_on(
      module, {output_of<Length>({2.0}), length_of(2.1, 0.1, 7), output_of<Length>({2.003})});
  ASSERT_EQ(fault_of(result.outcome), "degenerate");
  EXPECT_EQ(result.outcome.fault().message,
            "inputs 1 and 3 both claim an exact 'x', but differ by 0.003 m");
}

TEST(Fuse, RoundingOfErrorsThatCancelledIsNoError) {
  // As a + b - b - a leaves: errors of 1e-17 beside values that differ by 4e-16.
  const Estimate result = fused({length_of(2.0, 1e-17, 5), length_of(2.0 + 4e-16, 2e-17, 6)});
  EXPECT_NEAR(result.value[0], 2.0, 1e-15);
}

TEST(Fuse, ExactInputsThatDifferByRoundingAgree) {
  const Estimate result = fused({output_of<Length>({2.0}), output_of<Length>({2.0 * (1 + 2e-16)})});
  EXPECT_NEAR(result.value[0], 2.0, 1e-15);
}

TEST(Fuse, EqualErrorsThatCannotExplainADifferenceAreDegenerate) {
  Fuse module;
  const ModuleRun result = run_on(module, {length_of(2.0, 0.1, 7), length_of(4.0, 0.1, 7)});
  ASSERT_EQ(fault_of(result.outcome), "degenerate");
  EXPECT_NE(result.outcome.fault().message.find("by 1 m in 'x', 10 standard deviations"),
            std::string::npos)
      << result.outcome.fault().message;
}

TEST(Fuse, WhatSecondOrderLeavesBetweenSharedErrorsIsTolerated) {
  const Estimate result = fused({length_of(2.0, 0.1, 7), length_of(2.002, 0.1, 7)});
  EXPECT_NEAR(result.value[0], 2.001, 1e-12);
  EXPECT_NEAR(result.lineage.standard_deviation(0), 0.1, 1e-12);
}

TEST(Fuse, TakesAtLeastTwoEstimatesOfComponentsAlone) {
  PayloadDescriptor bare{"bare", "", {}};
  PayloadDescriptor picture{"picture", "", {{"pitch", "m", "", {}, false}}};
  picture.samples = SamplesDescriptor{"1", {"row"}};
  const auto complaints = [](std::vector<const PayloadDescriptor*> inputs) {
    Diagnostics diagnostics;
    Settings settings;
    Interface interface = Fuse::interface();
    Fuse::resolve({std::move(inputs), {}, &diagnostics}, settings, interface);
    std::string text;
    for (const Diagnostic& d : diagnostics.sorted()) text += d.message + "\n";
    return text;
  };
  EXPECT_EQ(complaints({&pose(), &pose()}), "");
  EXPECT_EQ(complaints({&pose()}), "'fuse' takes at least 2 estimates, but is fed by 1\n");
  EXPECT_EQ(complaints({&bare, &bare}), "'fuse' takes estimates, but bare has no components\n");
  EXPECT_EQ(complaints({&picture, &picture}),
            "'fuse' takes estimates of components alone, but picture has samples\n");
}

}  // namespace
}  // namespace ilss::test
