// Averages of one sensor that meet again: the plan says so, and fusion stays honest.
#include <gtest/gtest.h>

#include "framework/estimate/consistency.h"
#include "framework/graph/correlation.h"
#include "framework/graph/system.h"
#include "sensors/register.h"
#include "tests/framework/graph/test_modules.h"

namespace ilss::test {
namespace {

const Registry& fusion_registry() {
  static const Registry* const all = [] {
    auto* made = new Registry;
    register_sensors(*made);
    made->add<Reading>();
    made->add<Add>();
    return made;
  }();
  return *all;
}

Plan plan_of(const std::string& text) {
  Diagnostics diagnostics;
  const Node graph = parse_document(text, "graph.yaml", diagnostics);
  auto plan = build_plan(graph, ".", fusion_registry(), {}, diagnostics);
  std::string errors;
  for (const Diagnostic& d : diagnostics.sorted()) errors += format_diagnostic(d) + "\n";
  if (!plan) throw std::runtime_error("no plan:\n" + errors);
  return std::move(*plan);
}

std::string errors_of(const std::string& text) {
  Diagnostics diagnostics;
  const Node graph = parse_document(text, "graph.yaml", diagnostics);
  build_plan(graph, ".", fusion_registry(), {}, diagnostics);
  std::string errors;
  for (const Diagnostic& d : diagnostics.sorted()) errors += format_diagnostic(d) + "\n";
  return errors;
}

std::vector<std::string> notes_of(const Plan& plan) {
  std::vector<std::string> notes;
  for (const UnknownCorrelation& unknown : plan.unknown_correlations)
    notes.push_back(describe(unknown, plan));
  return notes;
}

/// Two averages of one sensor, a third estimate that shares its systematic error, and their fusion.
std::string graph_of(const std::string& fusion) {
  return R"(
ilss: two_averages
constants:
  scale_offset: {value: 0 m, std: 10 mm}
modules:
  sensor: {type: reading, value: 1 m, value_std: 100 mm, noise: normal, bias: $scale_offset}
  slow: {type: average}
  quick: {type: average, window: 12}
  other: {type: reading, value: 1 m, value_std: 30 mm, noise: normal, bias: $scale_offset}
  fused: {type: )" +
         fusion + R"(}
network:
  serial:
    - combine: [{serial: [sensor, slow]}, {serial: [sensor, quick]}, other]
    - fused
)";
}

TEST(UnknownCorrelation, PlanNamesTheAveragesThatMeet) {
  EXPECT_EQ(notes_of(plan_of(graph_of("fuse"))),
            std::vector<std::string>{"inputs of 'fused' are of unknown correlation: 'slow' and "
                                     "'quick' both hold errors of 'sensor'"});
}

TEST(UnknownCorrelation, AveragesOfDifferentSensorsAreNoneAndFusedExactly) {
  const Plan plan = plan_of(R"(
ilss: apart
modules:
  a: {type: reading, value: 1 m, value_std: 30 mm}
  b: {type: reading, value: 1 m, value_std: 30 mm}
  of_a: {type: average}
  of_b: {type: average}
  fused: {type: fuse}
network: {serial: [{combine: [{serial: [a, of_a]}, {serial: [b, of_b]}]}, fused]}
)");
  EXPECT_TRUE(plan.unknown_correlations.empty());
  System system(plan, 1);
  for (int tick = 0; tick < 8; ++tick) system.evaluate(time_at(tick));
  const Estimate& fused = system.node(plan.find("fused").value()).output().estimate;
  EXPECT_FALSE(fused.correlation_unknown);
  EXPECT_NEAR(fused.lineage.standard_deviation(0), 0.03 / 4, 1e-12);
}

/// The normalised random errors of `fused`, and of the two averages fused as if they were
/// independent. A run's constants are as stated, so systematic errors are left out.
struct Errors {
  ConsistencyStatistic fused;
  ConsistencyStatistic naive;
};

Errors errors_over_runs(std::uint64_t seed, Folding folding) {
  const Plan plan = plan_of(graph_of("fuse"));
  const std::size_t fused = plan.find("fused").value();
  const std::size_t slow = plan.find("slow").value();
  const std::size_t quick = plan.find("quick").value();
  const std::vector<double> truth = {1.0};
  Errors result;
  for (int r = 0; r < 3000; ++r) {
    System system(plan, derive_seed(seed, static_cast<std::uint64_t>(r)), folding);
    for (int tick = 0; tick < 15; ++tick) system.evaluate(time_at(tick));
    const auto without_systematic = [&](std::size_t node) {
      Estimate estimate = system.node(node).output().estimate;
      Lineage random(1);
      for (std::size_t k = 0; k < estimate.lineage.size(); ++k)
        if (!estimate.lineage.sources()[k].persistent())
          random.add(estimate.lineage.sources()[k], estimate.lineage.column(k));
      estimate.lineage = random;
      return estimate;
    };
    EXPECT_TRUE(system.node(fused).output().estimate.correlation_unknown);
    result.fused.add(nees(without_systematic(fused), truth));
    const Estimate a = without_systematic(slow);
    const Estimate b = without_systematic(quick);
    const double weight = 1 / a.lineage.variance(0);
    const double other = 1 / b.lineage.variance(0);
    const double x = (weight * a.value[0] + other * b.value[0]) / (weight + other);
    result.naive.add({(x - 1) * (x - 1) * (weight + other), 1, 0});
  }
  return result;
}

TEST(UnknownCorrelation, FuseIsNotOverconfidentWhereNaiveFusionIs) {
  const std::uint64_t seed = 1;
  for (const Folding folding : {Folding::per_owner, Folding::all, Folding::none}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", folding " << int(folding));
    const Errors errors = errors_over_runs(seed, folding);
    EXPECT_LE(errors.fused.mean(), errors.fused.bounds(0.99).high);
    EXPECT_GT(errors.naive.mean(), 1.7);
    EXPECT_GT(errors.naive.mean(), errors.naive.bounds(0.99).high);
  }
}

TEST(UnknownCorrelation, SystematicErrorsComeThroughFusionInFull) {
  const Plan plan = plan_of(graph_of("fuse"));
  System system(plan, 1);
  for (int tick = 0; tick < 15; ++tick) system.evaluate(time_at(tick));
  const Estimate& fused = system.node(plan.find("fused").value()).output().estimate;
  double systematic = 0;
  for (std::size_t k = 0; k < fused.lineage.size(); ++k)
    if (fused.lineage.sources()[k].persistent())
      systematic += fused.lineage.column(k)[0] * fused.lineage.column(k)[0];
  EXPECT_NEAR(std::sqrt(systematic), 0.010, 1e-12);
}

TEST(UnknownCorrelation, AverageOfAnAverageSaysThatItCannotAverageOut) {
  const Plan plan = plan_of(R"(
ilss: again
modules:
  sensor: {type: reading, value: 1 m, value_std: 30 mm}
  once: {type: average}
  again: {type: average}
network: {serial: [sensor, once, again]}
)");
  EXPECT_EQ(notes_of(plan),
            std::vector<std::string>{"'again' takes its ticks for independent, but 'once' holds "
                                     "earlier errors of 'sensor' in each"});
  System system(plan, 1);
  double variance_of_once = 0;
  for (int tick = 0; tick < 5; ++tick) {
    system.evaluate(time_at(tick));
    variance_of_once += system.node(1).output().estimate.lineage.variance(0) / 5;
  }
  const Estimate& again = system.node(2).output().estimate;
  EXPECT_TRUE(again.correlation_unknown);
  EXPECT_NEAR(again.lineage.variance(0), variance_of_once, 1e-12);
}

TEST(UnknownCorrelation, MixedPayloadsAndFramesAreRefused) {
  EXPECT_EQ(errors_of(R"(
ilss: mixed
modules:
  a: {type: reading, value: 1 m, frame: here}
  b: {type: reading, value: 1 m, frame: there}
  c: {type: scene_wall, scene: )" ILSS_SOURCE_DIR R"(/graphs/scenes/wall_target.yaml}
  frames: {type: fuse}
  payloads: {type: consistency}
network:
  combine: [{serial: [{combine: [a, b]}, frames]}, {serial: [{combine: [a, c]}, payloads]}]
)"),
            "graph.yaml:10:42: 'a' is in frame 'here', but 'b' in frame 'there'; inputs of "
            "'frames' must share a frame\n"
            "graph.yaml:10:81: 'c' gives wall_pose, but input 'estimates' of 'payloads' takes "
            "scalar\n");
}

/// Mean squared error over its stated variance of the module `answer`, over runs of a graph of
/// readings of 1 m, at the last of some ticks.
double nees_of_answer(const std::string& graph, int ticks) {
  const Plan plan = plan_of(graph);
  const std::size_t answer = plan.find("answer").value();
  ConsistencyStatistic statistic;
  for (std::uint64_t run = 0; run < 1500; ++run) {
    System system(plan, derive_seed(11, run));
    for (int tick = 0; tick < ticks; ++tick) system.evaluate(time_at(tick));
    statistic.add(nees(system.node(answer).output().estimate, std::vector<double>{1.0}));
  }
  return statistic.mean();
}

const std::string averages = R"(modules:
  sensor: {type: reading, value: 1 m, value_std: 100 mm, noise: normal}
  other: {type: reading, value: 1 m, value_std: 30 mm, noise: normal}
  all: {type: average}
  latest: {type: average, window: 12}
)";
const std::string half_of_both =
    "{type: linear, inputs: [a, b], matrix: [[0.5, 0.5]], payload: scalar, output: {x: m}}\n";

// A function adds the errors that it is given; where their correlation is unknown, as a bound.
// Taken for independent, the same two averages are wrong by 1.8 times what they state.
TEST(UnknownCorrelation, FunctionOfAveragesOfOneSensorIsABound) {
  EXPECT_LT(nees_of_answer(averages + "  answer: " + half_of_both +
                               "network: {combine: [{serial: [sensor, combine: [all, latest], "
                               "answer]}, other]}\n",
                           12),
            1.1);
}

TEST(UnknownCorrelation, FusionBehindSuchAFunctionIsABoundToo) {
  EXPECT_LT(nees_of_answer(averages + "  answer: {type: fuse}\n  mean: " + half_of_both +
                               "network: {serial: [{combine: [{serial: [sensor, combine: [all, "
                               "latest], mean]}, other]}, answer]}\n",
                           12),
            1.1);
}

// What an intersection has taken up it shares with its inputs, in a way that is lost.
TEST(UnknownCorrelation, IntersectionMeetsItsOwnInputAgain) {
  const std::string graph = R"(modules:
  r: {type: reading, value: 1 m, value_std: 100 mm, noise: normal}
  o: {type: reading, value: 1 m, value_std: 400 mm, noise: normal}
  ci: {type: covariance_intersection}
  answer: )" + half_of_both +
                            "network: {serial: [{combine: [{serial: [combine: [r, o], ci]}, r]}, "
                            "answer]}\n";
  EXPECT_EQ(notes_of(plan_of(graph)),
            std::vector<std::string>{"inputs of 'answer' are of unknown correlation: 'ci' and 'r' "
                                     "both hold errors of 'r'"});
  EXPECT_LT(nees_of_answer(graph, 1), 1.1);
}

}  // namespace
}  // namespace ilss::test
