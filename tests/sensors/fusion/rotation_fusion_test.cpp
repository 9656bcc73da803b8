// Fusion, averages and consistency of what is no vector space: headings around half a turn, and
// rotations in space up to there.
#include <algorithm>

#include "framework/estimate/rotation.h"
#include "sensors/fusion/average.h"
#include "sensors/fusion/consistency.h"
#include "sensors/fusion/covariance_intersection.h"
#include "sensors/fusion/fuse.h"
#include "tests/orientation.h"
#include "tests/sensors/fusion/fusion_run.h"

namespace ilss::test {
namespace {

constexpr int runs = 2000;

/// Poses in space whose rotation is by up to half a turn, one in three nearly or quite so far, and
/// whose joint is near ±pi.
std::vector<double> spatial_truth(RandomBits& random) {
  std::array<double, 3> axis{};
  double length = 0;
  while (length < 0.1 || length > 1) {
    for (double& component : axis) component = draw_uniform(random, -1, 1);
    length = std::hypot(axis[0], axis[1], axis[2]);
  }
  double angle = draw_uniform(random, 0, pi);
  if (draw_index(random, 3) == 0) angle = pi - (draw_index(random, 2) == 0 ? 0 : 0.01);
  for (double& component : axis) component *= angle / length;
  const double joint = wrap_angle(pi + draw_uniform(random, -0.05, 0.05));
  return {draw_uniform(random, -2, 2), axis[0], axis[1], axis[2], 0.5, joint};
}
/// Poses in the plane that look near ±pi.
std::vector<double> planar_truth(RandomBits& random) {
  return {1, -2, wrap_angle(pi + draw_uniform(random, -0.05, 0.05))};
}

struct Kind {
  const char* name;
  const PayloadDescriptor& (*payload)();
  std::vector<double> (*truth)(RandomBits& random);
};

class NoVectorSpace : public testing::TestWithParam<Kind> {
 protected:
  NoVectorSpace() { RecordProperty("seed", static_cast<int>(seed_)); }
  const PayloadDescriptor& payload() const { return GetParam().payload(); }
  Eigen::MatrixXd factor() {
    return 0.06 * random_factor(static_cast<Eigen::Index>(payload().dimension()), random_);
  }

  struct Drawn {
    std::vector<double> truth;
    std::vector<Output> inputs;
  };
  /// Estimates of one thing with errors of their own and some that all share.
  Drawn estimates(std::uint32_t count) {
    Drawn result{GetParam().truth(random_), {}};
    Errors errors(random_());
    const Eigen::MatrixXd shared = 0.5 * factor();
    for (std::uint32_t i = 0; i < count; ++i) {
      Lineage lineage = lineage_of(10 + i, factor());
      add_columns(lineage, 20, shared, persistent_tick);
      result.inputs.push_back(drawn(payload(), result.truth, lineage, errors));
    }
    return result;
  }
  Estimate result_of(Module& module, const std::vector<Output>& inputs, std::int64_t tick = 0) {
    ModuleRun result = run_on(module, inputs, tick);
    EXPECT_TRUE(result.outcome) << (result.outcome.is_fault() ? result.outcome.fault().message
                                                              : "");
    result.output.estimate.type = &payload();
    return result.output.estimate;
  }

  static constexpr std::uint64_t seed_ = 20261128;
  RandomBits random_{seed_};
};

TEST_P(NoVectorSpace, OneEstimateIsAsWrongAsItSays) {
  ConsistencyStatistic statistic;
  for (int r = 0; r < runs; ++r) {
    const Drawn one = estimates(1);
    statistic.add(nees(one.inputs[0].estimate, one.truth));
  }
  EXPECT_TRUE(statistic.consistent(probability)) << statistic.mean();
}

TEST_P(NoVectorSpace, InnovationsOfTwoAreAsLargeAsTheySay) {
  ConsistencyStatistic statistic;
  for (int r = 0; r < runs; ++r) {
    const Drawn two = estimates(2);
    statistic.add(nis(two.inputs[0].estimate, two.inputs[1].estimate));
  }
  EXPECT_TRUE(statistic.consistent(probability)) << statistic.mean();
}

TEST_P(NoVectorSpace, IndependentCovarianceIsThatOfTheDifference) {
  ConsistencyStatistic statistic;
  for (int r = 0; r < runs; ++r) {
    const std::vector<double> truth = GetParam().truth(random_);
    Errors errors(random_());
    const Output a = drawn(payload(), truth, lineage_of(1, factor()), errors);
    const Output b = drawn(payload(), truth, lineage_of(2, factor()), errors);
    statistic.add(normalized_squared_error(difference(a.estimate, b.estimate.value),
                                           independent_covariance(a.estimate, b.estimate)));
  }
  EXPECT_TRUE(statistic.consistent(probability)) << statistic.mean();
}

TEST_P(NoVectorSpace, FusedIsAsWrongAsItSays) {
  ConsistencyStatistic statistic;
  for (int r = 0; r < runs; ++r) {
    const Drawn three = estimates(3);
    Fuse fuse;
    statistic.add(nees(result_of(fuse, three.inputs), three.truth));
  }
  EXPECT_TRUE(statistic.consistent(probability)) << statistic.mean();
}

TEST_P(NoVectorSpace, OrderOfFusionDoesNotMatter) {
  for (int r = 0; r < 100; ++r) {
    Drawn three = estimates(3);
    Fuse fuse;
    const Estimate one = result_of(fuse, three.inputs);
    std::rotate(three.inputs.begin(), three.inputs.begin() + 1, three.inputs.end());
    const Estimate other = result_of(fuse, three.inputs);
    EXPECT_LT(difference(one, other.value).norm(), 1e-10);
    EXPECT_LT((one.lineage.covariance() - other.lineage.covariance()).norm(),
              1e-9 * one.lineage.covariance().norm());
  }
}

TEST_P(NoVectorSpace, AverageIsAsWrongAsItSays) {
  for (const std::int64_t window : {0, 4}) {
    ConsistencyStatistic statistic;
    for (int r = 0; r < 1000; ++r) {
      const std::vector<double> truth = GetParam().truth(random_);
      Errors errors(random_());
      const Eigen::MatrixXd own = factor();
      const Eigen::MatrixXd shared = 0.5 * factor();
      Average average(Average::Options{window});
      Estimate mean;
      for (std::int64_t tick = 0; tick < 6; ++tick) {
        Lineage lineage(payload().dimension());
        add_columns(lineage, 5, own, tick);
        add_columns(lineage, 6, shared, persistent_tick);
        mean = result_of(average, {drawn(payload(), truth, lineage, errors)}, tick);
      }
      statistic.add(nees(mean, truth));
    }
    EXPECT_TRUE(statistic.consistent(probability)) << statistic.mean() << ", window " << window;
  }
}

TEST_P(NoVectorSpace, IntersectionIsNotOverconfident) {
  ConsistencyStatistic statistic;
  for (int r = 0; r < runs; ++r) {
    const Drawn two = estimates(2);
    CovarianceIntersection intersection;
    statistic.add(nees(result_of(intersection, two.inputs), two.truth));
  }
  EXPECT_LE(statistic.mean(), statistic.bounds(probability).high);
  EXPECT_GT(statistic.mean(), 0.2);
}

TEST_P(NoVectorSpace, ProbabilityOfDifferencesIsUniform) {
  constexpr int bins = 10;
  std::array<int, bins> counts{};
  for (int r = 0; r < runs; ++r) {
    ConsistencyModule module;
    const ModuleRun result = run_on(module, estimates(3).inputs);
    ASSERT_TRUE(result.outcome);
    const auto p = payload_of<Consistency>(result.output.estimate).probability;
    ++counts[std::min<std::size_t>(bins - 1, static_cast<std::size_t>(p * bins))];
  }
  double chi_square = 0;
  constexpr double expected = 1.0 * runs / bins;
  for (const int count : counts) chi_square += std::pow(count - expected, 2) / expected;
  EXPECT_LT(chi_square, chi_square_quantile(bins - 1, probability));
}

INSTANTIATE_TEST_SUITE_P(Payloads, NoVectorSpace,
                         testing::Values(Kind{"HeadingsAroundPi", pose, planar_truth},
                                         Kind{"RotationsInSpace",
                                              []() -> const PayloadDescriptor& {
                                                return descriptor<SpatialPose>();
                                              },
                                              spatial_truth}),
                         [](const auto& info) { return std::string(info.param.name); });

/// NEES over runs of an orientation with errors of unequal axes, made and judged in some way.
template <typename Make, typename Error>
ConsistencyStatistic orientations_judged(Make make, Error error) {
  RandomBits random(7);
  const Eigen::Vector3d deviations(0.2, 0.02, 0.05);
  const Eigen::MatrixXd covariance = deviations.cwiseAbs2().asDiagonal();
  ConsistencyStatistic statistic;
  for (int r = 0; r < runs; ++r) {
    const auto pose = spatial_truth(random);
    const RotationVector<double> truth = {pose[1], pose[2], pose[3]};
    RotationVector<double> e{};
    for (std::size_t i = 0; i < 3; ++i)
      e[i] = deviations[static_cast<Eigen::Index>(i)] * draw_normal(random);
    statistic.add(normalized_squared_error(error(make(truth, e), truth), covariance));
  }
  return statistic;
}
using Rotation = RotationVector<double>;
Eigen::VectorXd local_difference(const Rotation& a, const Rotation& b) {
  return difference(descriptor<Orientation>(), a, b);
}
Rotation with_local_error(const Rotation& truth, const Rotation& e) {
  return rotation_product(truth, e);
}

TEST(RotationErrors, ThatAreLocalAreJudgedRight) {
  EXPECT_TRUE(orientations_judged(with_local_error, local_difference).consistent(probability));
}

TEST(RotationErrors, OfTheWorldsAxesAreNotTakenForLocalOnes) {
  const auto in_world = [](const Rotation& truth, const Rotation& e) {
    return rotation_product(e, truth);
  };
  EXPECT_FALSE(orientations_judged(in_world, local_difference).consistent(probability));
}

TEST(RotationErrors, AreNotDifferencesOfComponents) {
  const auto subtracted = [](const Rotation& a, const Rotation& b) -> Eigen::VectorXd {
    return Eigen::Vector3d(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  };
  EXPECT_FALSE(orientations_judged(with_local_error, subtracted).consistent(probability));
}

TEST(RotationAverage, LineageIsWhatMovingEachReadingDoes) {
  // Readings far apart, so that tangents differ much.
  const PayloadDescriptor& type = descriptor<SpatialPose>();
  RandomBits random(9);
  for (const std::int64_t window : {0, 3}) {
    const auto truth = spatial_truth(random);
    std::vector<Estimate> readings;
    for (std::int64_t tick = 0; tick < 3; ++tick) {
      std::vector<double> e(6);
      for (double& component : e) component = draw_uniform(random, -0.6, 0.6);
      Estimate reading(type);
      reading.value = retract(type, truth, e);
      add_columns(reading.lineage, 5, Eigen::MatrixXd::Identity(6, 6), tick);
      readings.push_back(reading);
    }
    const auto average_of = [&](const std::vector<Estimate>& of) {
      Average average(Average::Options{window});
      ModuleRun result;
      for (std::size_t tick = 0; tick < of.size(); ++tick) {
        Output input;
        input.estimate = of[tick];
        result = run_on(average, {input}, static_cast<std::int64_t>(tick));
      }
      result.output.estimate.type = &type;
      return result.output.estimate;
    };
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(6, 6);
    for (std::size_t tick = 0; tick < 3; ++tick)
      for (std::size_t c = 0; c < 6; ++c) {
        constexpr double step = 1e-5;
        const auto moved = [&](double by) {
          std::vector<Estimate> some = readings;
          std::vector<double> e(6, 0.0);
          e[c] = by;
          some[tick].value = retract(type, some[tick].value, e);
          return average_of(some);
        };
        const Eigen::VectorXd column = difference(moved(step), moved(-step).value) / (2 * step);
        covariance += column * column.transpose();
      }
    EXPECT_LT((average_of(readings).lineage.covariance() - covariance).norm(), 1e-8)
        << "window " << window;
  }
}

}  // namespace
}  // namespace ilss::test
