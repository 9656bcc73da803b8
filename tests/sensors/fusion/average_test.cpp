// The mean over time: what averages out, and what does not.
#include "sensors/fusion/average.h"

#include "tests/allocation_count.h"
#include "tests/sensors/fusion/fusion_run.h"

namespace ilss::test {
namespace {

/// A length with a random error of sd 0.2 of this tick and a systematic one of sd 0.03.
Lineage reading_lineage(std::int64_t tick) {
  Lineage lineage(1);
  lineage.add({5, 0, tick}, 0, 0.2);
  lineage.add({6, 0, persistent_tick}, 0, 0.03);
  return lineage;
}

double random_deviation(const Lineage& lineage) {
  double variance = 0;
  for (std::size_t k = 0; k < lineage.size(); ++k)
    if (!lineage.sources()[k].persistent()) variance += std::pow(lineage.column(k)[0], 2);
  return std::sqrt(variance);
}

double systematic_deviation(const Lineage& lineage) {
  return std::sqrt(lineage.variance(0) - std::pow(random_deviation(lineage), 2));
}

TEST(Average, RandomErrorsAverageOutAndSystematicOnesDoNot) {
  Average average(Average::Options{});
  Errors errors(1);
  double sum = 0;
  for (std::int64_t tick = 0; tick < 100; ++tick) {
    const Output reading = drawn(length(), {2.0}, reading_lineage(tick), errors);
    const ModuleRun result = run_on(average, {reading}, tick);
    ASSERT_TRUE(result.outcome);
    sum += reading.estimate.value[0];
    const auto n = static_cast<double>(tick + 1);
    EXPECT_NEAR(result.output.estimate.value[0], sum / n, 1e-12);
    EXPECT_NEAR(random_deviation(result.output.estimate.lineage), 0.2 / std::sqrt(n), 1e-12);
    EXPECT_NEAR(systematic_deviation(result.output.estimate.lineage), 0.03, 1e-12);
  }
}

TEST(Average, IsAsWrongAsItSays) {
  const std::uint64_t seed = 2;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  for (const std::int64_t window : {0, 4}) {
    ConsistencyStatistic statistic;
    for (int r = 0; r < 2000; ++r) {
      Errors errors(derive_seed(seed, static_cast<std::uint64_t>(r)));
      Average average(Average::Options{window});
      ModuleRun result;
      for (std::int64_t tick = 0; tick < 10; ++tick)
        result = run_on(average, {drawn(length(), {2.0}, reading_lineage(tick), errors)}, tick);
      result.output.estimate.type = &length();
      const std::vector<double> truth = {2.0};
      statistic.add(nees(result.output.estimate, truth));
    }
    EXPECT_TRUE(statistic.consistent(probability)) << statistic.mean();
  }
}

TEST(Average, KeepsThisTicksErrorByName) {
  Average average(Average::Options{});
  Errors errors(3);
  ModuleRun result;
  for (std::int64_t tick = 0; tick < 4; ++tick)
    result = run_on(average, {drawn(length(), {2.0}, reading_lineage(tick), errors)}, tick);
  Lineage this_tick(1);
  this_tick.add({5, 0, 3}, 0, 1.0);
  EXPECT_NEAR(cross_covariance(result.output.estimate.lineage, this_tick)(0, 0), 0.05, 1e-15);
}

TEST(Average, BlocksOfTwoAveragesAreNeverTakenForOne) {
  Errors errors(4);
  std::vector<Lineage> lineages;
  for (const std::uint32_t owner : {1u, 2u}) {
    Average average(Average::Options{});
    Output output;
    for (std::int64_t tick = 0; tick < 5; ++tick) {
      const Output reading = drawn(length(), {2.0}, reading_lineage(tick), errors);
      Tick at;
      at.tick = tick;
      at.owner = owner;
      at.inputs = {&reading};
      output = run(average, at).output;
    }
    lineages.push_back(output.estimate.lineage);
  }
  int shared_random = 0;
  for (const Source& a : lineages[0].sources())
    for (const Source& b : lineages[1].sources()) shared_random += a == b && !a.persistent();
  EXPECT_EQ(shared_random, 1);  // this tick's
}

TEST(Average, ErrorOfAValueThatIsHeldDoesNotAverageOut) {
  Average average(Average::Options{});
  ModuleRun result;
  for (std::int64_t tick = 0; tick < 9; ++tick) {
    Output reading = output_of<Length>({2.0});
    reading.estimate.lineage.add({5, 0, tick}, 0, 0.3);
    reading.estimate.lineage.add({7, 0, 0}, 0, 0.2);  // read at the first tick, held since
    result = run_on(average, {reading}, tick);
  }
  EXPECT_NEAR(result.output.estimate.lineage.variance(0), 0.1 * 0.1 + 0.2 * 0.2, 1e-12);
}

TEST(Average, WindowForgetsWhatIsOlder) {
  Average average(Average::Options{3});
  ModuleRun result;
  for (std::int64_t tick = 0; tick < 10; ++tick)
    result = run_on(average, {[&] {
                      Output reading = output_of<Length>({static_cast<double>(tick)});
                      reading.estimate.lineage.add({5, 0, tick}, 0, 0.3);
                      return reading;
                    }()},
                    tick);
  EXPECT_NEAR(result.output.estimate.value[0], 8, 1e-12);
  EXPECT_NEAR(result.output.estimate.lineage.variance(0), 0.03, 1e-12);
  EXPECT_EQ(result.output.estimate.lineage.sources().front(), (Source{5, 0, 7}));
}

TEST(Average, AnglesAreAveragedAcrossPi) {
  for (const std::int64_t window : {0, 10}) {
    Average average(Average::Options{window});
    ModuleRun result;
    for (std::int64_t tick = 0; tick < 4; ++tick)
      result =
          run_on(average, {output_of<Pose>({0, 0, tick % 2 == 0 ? pi - 0.02 : -pi + 0.04})}, tick);
    EXPECT_NEAR(result.output.estimate.value[2], -pi + 0.01, 1e-12);
  }
}

TEST(Average, StartsAnewAfterReset) {
  for (const std::int64_t window : {0, 10}) {
    Average average(Average::Options{window});
    (void)run_on(average, {length_of(1, 0.1, 5)}, 0);
    average.reset();
    const ModuleRun result = run_on(average, {length_of(3, 0.2, 5)}, 1);
    EXPECT_EQ(result.output.estimate.value[0], 3);
    EXPECT_NEAR(result.output.estimate.lineage.standard_deviation(0), 0.2, 1e-15);
  }
}

TEST(Average, IsExpectedToBeOneReadingAndKeepsNothingOfIt) {
  Average average(Average::Options{});
  (void)run_on(average, {length_of(1, 0.1, 5)}, 0);
  const Output reading = length_of(3, 0.2, 5);
  Tick tick;
  tick.inputs = {&reading};
  Output output;
  ASSERT_TRUE(average.expect(tick.evaluation(), nullptr, output));
  EXPECT_EQ(output.estimate.value[0], 3);
  EXPECT_EQ(output.estimate.lineage.standard_deviation(0), 0.2);
  EXPECT_EQ(fault_of(average.expect(tick.evaluation(), &reading, output)), "no_error_known");
  Output next = length_of(2, 0.1, 5);
  EXPECT_EQ(run_on(average, {next}, 1).output.estimate.value[0], 1.5);
}

TEST(Average, OfTicksOfUnknownCorrelationClaimsNoReduction) {
  for (const std::int64_t window : {0, 10}) {
    Average average(Average::Options{window});
    ModuleRun result;
    for (std::int64_t tick = 0; tick < 5; ++tick) {
      Output reading = output_of<Length>({2.0});
      reading.estimate.lineage = reading_lineage(tick);
      reading.estimate.correlation_unknown = true;
      result = run_on(average, {reading}, tick);
    }
    EXPECT_NEAR(random_deviation(result.output.estimate.lineage), 0.2, 1e-12);
    EXPECT_NEAR(systematic_deviation(result.output.estimate.lineage), 0.03, 1e-12);
  }
}

TEST(Average, AllocatesNothingOnceItsBuffersHaveGrown) {
  SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED();
  Average average(Average::Options{});
  Output reading = output_of<Pose>({1, 2, 3});
  Output output;
  Tick tick;
  tick.inputs = {&reading};
  std::size_t before = 0;
  for (tick.tick = 0; tick.tick < 1000; ++tick.tick) {
    if (tick.tick == 100) before = allocation_count;
    reading.estimate.lineage.reset(3);
    for (std::uint32_t k = 0; k < 3; ++k)
      reading.estimate.lineage.add({5, k, tick.tick}, std::size_t{k}, 0.1);
    const Outcome<> outcome = average.evaluate(tick.evaluation(), output);
    ASSERT_TRUE(outcome);
  }
  EXPECT_EQ(allocation_count - before, 0u);
  EXPECT_LE(output.estimate.lineage.size(), 6u);
}

TEST(Average, WindowIsACountOfTicks) {
  Diagnostics diagnostics;
  (void)options_from<Average::Options>("{window: -1}", diagnostics);
  EXPECT_EQ(diagnostics.size(), 1u);
}

}  // namespace
}  // namespace ilss::test
