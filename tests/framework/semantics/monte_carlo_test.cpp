// Monte Carlo over a graph: what it draws, that it repeats, and that it agrees with what is known.
#include "framework/semantics/monte_carlo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

using test::output_of;
using test::plan_of;

MonteCarloOutput run(const Plan& plan, const MonteCarloOptions& options = {.trials = 200'000}) {
  System system(plan, 1);
  system.expect();
  return run_monte_carlo(system, {}, options).at(0);
}

/// A sum of two readings' errors under a gain that carries an error of a given law.
Plan law_of(const std::string& error) {
  return plan_of("modules: {x: {type: reading, value: 0 m, bias: {value: 0 m, " + error +
                 "}}}\nnetwork: x\n");
}

TEST(MonteCarlo, OfALinearSumIsItsFirstOrder) {
  const Plan plan = plan_of(R"(
modules: {x: {type: reading, value: 1 m, value_std: 3 mm}, y: {type: reading, value: 2 m, value_std: 4 mm}, a: {type: add}}
network: {serial: [combine: [x, y], a]}
)");
  // The place of the shortest interval scatters with the cube root of the trials: as many as may
  // be, for two digits of it.
  const MonteCarloOutput result = run(plan, {.trials = most_trials});
  EXPECT_EQ(result.trials, most_trials);
  EXPECT_EQ(result.faults, 0U);
  EXPECT_NEAR(result.mean[0], 3, 5 * 5e-3 / std::sqrt(4e6));
  EXPECT_NEAR(std::sqrt(result.covariance(0, 0)), 5e-3, 5e-3 * 5 / std::sqrt(8e6));
  EXPECT_NEAR(result.coverage[0], 0.95, 0.0025);
  EXPECT_EQ(result.agreeing_digits[0], 2);
}

TEST(MonteCarlo, SharedSourcesCancelInEveryTrial) {
  const Plan plan = plan_of(R"(
modules: {x: {type: reading, value: 1 m, value_std: 1 m}, s: {type: subtract}}
network: {serial: [combine: [x, x], s]}
)");
  const MonteCarloOutput result = run(plan, {.trials = 1000});
  EXPECT_EQ(result.mean[0], 0);
  EXPECT_EQ(result.covariance(0, 0), 0);
}

TEST(MonteCarlo, DoesNotDependOnTheNumberOfThreads) {
  const Plan plan = plan_of(R"(
modules: {x: {type: reading, value: 1 m, value_std: 1 m, bias: {value: 0 m, std: 1 m, distribution: triangular}}, s: {type: sine}}
network: {serial: [x, s]}
)");
  const MonteCarloOutput one = run(plan, {.trials = 10'001, .seed = 7, .threads = 1});
  const MonteCarloOutput three = run(plan, {.trials = 10'001, .seed = 7, .threads = 3});
  const MonteCarloOutput other = run(plan, {.trials = 10'001, .seed = 8, .threads = 1});
  EXPECT_EQ(one.mean, three.mean);
  EXPECT_EQ(one.covariance, three.covariance);
  EXPECT_EQ(one.interval[0].low, three.interval[0].low);
  EXPECT_NE(one.mean, other.mean);
}

TEST(MonteCarlo, DrawsDoNotDependOnOtherModules) {
  const Plan alone = plan_of(R"(
modules: {x: {type: reading, value: 1 m, value_std: 1 m}}
network: x
)");
  const Plan among = plan_of(R"(
modules: {a: {type: reading, value: 1 m, value_std: 1 m}, x: {type: reading, value: 1 m, value_std: 1 m}}
network: {combine: [x, a]}
)");
  EXPECT_EQ(run(alone, {.trials = 1000}).mean, run(among, {.trials = 1000}).mean);
}

/// The shortest 95 % interval of unit variance, by the quantiles of each law.
TEST(MonteCarlo, DrawsEveryLawWithItsStandardDeviation) {
  struct Case {
    std::string error;
    double half_width;
  };
  const double uniform = 0.95 * std::sqrt(3.0);
  const double triangular = (1 - std::sqrt(0.05)) * std::sqrt(6.0);
  // t of 5 degrees of freedom: its 97.5 % quantile 2.5706 over sqrt(5 / 3) (JCGM 100, table G.2).
  const double t = 2.5706 / std::sqrt(5.0 / 3.0);
  for (const Case& law :
       {Case{"std: 1 m", 1.95996}, Case{"std: 1 m, distribution: uniform", uniform},
        Case{"std: 1 m, distribution: triangular", triangular},
        Case{"std: 1 m, distribution: t, degrees_of_freedom: 5", t}}) {
    SCOPED_TRACE(law.error);
    const MonteCarloOutput result = run(law_of(law.error), {.trials = 1'000'000});
    EXPECT_NEAR(result.covariance(0, 0), 1, 0.01);
    EXPECT_NEAR((result.interval[0].high - result.interval[0].low) / 2, law.half_width, 0.015);
  }
}

TEST(MonteCarlo, DrawsTheArcsineLawBetweenItsEnds) {
  const MonteCarloOutput result =
      run(law_of("half_width: 2 m, distribution: arcsine"), {.trials = 200'000});
  EXPECT_NEAR(result.covariance(0, 0), 2, 0.01);
  EXPECT_NEAR(result.interval[0].high, 2 * std::sin(0.95 * std::numbers::pi / 2), 0.03);
  EXPECT_LE(result.interval[0].high, 2);
}

TEST(MonteCarlo, DrawsWhatAFileHolds) {
  const test::Folder folder;
  folder.write("die.csv", "eyes\n1\n2\n3\n4\n5\n6\n1\n2\n3\n4\n5\n6\n");
  const Plan plan =
      law_of("std: 1 m, distribution: {samples: " + (folder.path() / "die.csv").string() +
             ", column: eyes}");
  System system(plan, 1);
  system.expect();
  const MonteCarloOutput result = run_monte_carlo(system, {}, {.trials = 10'000}).at(0);
  EXPECT_NEAR(result.covariance(0, 0), 1, 0.05);
  std::vector<double> faces = result.offsets[0];
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  EXPECT_EQ(faces.size(), 6U);
  EXPECT_NEAR(faces.back(), 2.5 / std::sqrt(35.0 / 12.0), 1e-12);  // a die's variance is 35 / 12
}

TEST(MonteCarlo, KeepsCorrelationOfAVectorConstant) {
  const Plan plan = plan_of(R"(
constants: {v: {value: {a: 0 m, b: 0 m}, covariance: [[1, 0.9], [0.9, 1]]}}
modules: {x: {type: reading, value: 0 m, bias: $v.a}, y: {type: reading, value: 0 m, bias: $v.b}, s: {type: subtract}}
network: {serial: [combine: [x, y], s]}
)");
  EXPECT_NEAR(run(plan).covariance(0, 0), 0.2, 0.005);
}

TEST(MonteCarlo, SourcesOfOneNameAreDrawnApart) {
  // The element `left.bias` of a vector, and the parameter `bias` of the module `left`.
  const Plan plan = plan_of(R"(
constants: {left: {value: {bias: {value: 0 m, std: 1 m}}}}
modules: {left: {type: reading, value: 0 m, bias: {value: 0 m, std: 1 m}}, y: {type: reading, value: 0 m, bias: $left.bias}, s: {type: subtract}}
network: {serial: [combine: [left, y], s]}
)");
  EXPECT_NEAR(run(plan).covariance(0, 0), 2, 0.05);
}

TEST(MonteCarlo, CountsTrialsWithoutAnAnswer) {
  const Plan plan = plan_of(R"(
modules: {x: {type: reading, value: 1 m, value_std: 1 m}, r: {type: root}}
network: {serial: [x, r]}
)");
  const MonteCarloOutput result = run(plan);
  // P(x < 0) = 0.1587 of a normal x with mean 1 and sd 1.
  EXPECT_NEAR(static_cast<double>(result.faults) / 200e3, 0.1587, 0.004);
  EXPECT_EQ(result.trials + result.faults, 200'000U);
  EXPECT_NE(result.fault.find("'r'"), std::string::npos) << result.fault;
}

TEST(MonteCarlo, RefusesNoTrialsAndTooMany) {
  const Plan plan = law_of("std: 1 m");
  EXPECT_THROW(run(plan, {.trials = 0}), std::invalid_argument);
  EXPECT_THROW(run(plan, {.trials = most_trials + 1}), std::invalid_argument);
}

TEST(MonteCarlo, TellsItsProgressInOrder) {
  double last = 0;
  bool ordered = true;
  run(law_of("std: 1 m"), {.trials = 5000, .threads = 1, .progress = [&](double done) {
                             ordered &= done >= last;
                             last = done;
                           }});
  EXPECT_TRUE(ordered);
  EXPECT_EQ(last, 1);
}

TEST(ShortestInterval, OfASkewedLawBeginsAtItsEdge) {
  // Of the values 1², 2², ... the smallest 95 % are the closest together.
  std::vector<double> values;
  for (int i = 1000; i > 0; --i) values.push_back(static_cast<double>(i) * i);
  const Interval interval = shortest_interval(values, 0.95);
  EXPECT_EQ(interval.low, 1);
  EXPECT_EQ(interval.high, 951.0 * 951.0);
}

TEST(ShortestInterval, OfOneValueIsThatValue) {
  std::vector<double> one = {3};
  EXPECT_EQ(shortest_interval(one, 0.95).low, 3);
  EXPECT_EQ(shortest_interval(one, 0.95).high, 3);
  std::vector<double> none;
  EXPECT_TRUE(std::isnan(shortest_interval(none, 0.95).low));
}

TEST(AgreeingDigits, FollowsTheTolerancesOfTheGuide) {
  // JCGM 101:2008, 7.9.2, example 1: u = 0.0352 to two digits is 35e-3, so delta = 0.0005; to one
  // digit 4e-2 and delta = 0.005.
  EXPECT_EQ(agreeing_digits(0, 0.07, 0.0352, {-0.0703, 0.0703}), 2);
  EXPECT_EQ(agreeing_digits(0, 0.07, 0.0352, {-0.0730, 0.0703}), 1);
  EXPECT_EQ(agreeing_digits(0, 0.07, 0.0352, {-0.0760, 0.0703}), 0);
  // An error of 0 agrees with nothing but itself.
  EXPECT_EQ(agreeing_digits(1, 0, 0, {1, 1}), 2);
  EXPECT_EQ(agreeing_digits(1, 0, 0, {1, 1.1}), 0);
}

}  // namespace
}  // namespace ilss
