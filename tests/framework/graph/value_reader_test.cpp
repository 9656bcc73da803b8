// Values as users write them: quantities, constants, covariances, estimates given by hand.
#include "framework/graph/value_reader.h"

#include <gtest/gtest.h>

#include <numbers>

#include "framework/graph/constants.h"
#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

using test::Folder;
using test::Pair;
using test::plan_of;
using test::read_text;
using test::Scalar;
using test::Turn;

/// What is read from a value, and what was said about it.
template <template <typename> class Payload>
struct Given {
  SourceOwners owners;
  std::optional<GivenEstimate> read;
  std::string errors;
  explicit Given(const std::string& text) {
    Diagnostics diagnostics;
    const Node node = parse_document(text, "value", diagnostics);
    read = read_estimate(node, descriptor<Payload>(), "name", owners, diagnostics);
    errors = test::messages(diagnostics);
  }
  double value(std::size_t i) const { return read.value().estimate.value[i]; }
  Eigen::MatrixXd covariance() const { return read.value().estimate.lineage.covariance(); }
};

TEST(ReadEstimate, TakesAMapOfQuantities) {
  const Given<Pair> given("{a: 3 mm, b: {value: 2 cm, std: 1 mm}}");
  EXPECT_EQ(given.errors, "");
  EXPECT_DOUBLE_EQ(given.value(0), 0.003);
  EXPECT_DOUBLE_EQ(given.value(1), 0.02);
  EXPECT_TRUE(given.read->has_error);
  EXPECT_NEAR(given.covariance()(1, 1), 1e-6, 1e-18);
  EXPECT_EQ(given.covariance()(0, 0), 0.0);
  EXPECT_EQ(given.owners.at(0).name, "name.b");
  EXPECT_FALSE(given.owners.at(0).persistent);
}

TEST(ReadEstimate, TakesABareQuantityForOneComponent) {
  EXPECT_DOUBLE_EQ(Given<Scalar>("5 mm").value(0), 0.005);
  EXPECT_FALSE(Given<Scalar>("5 mm").read->has_error);
  EXPECT_NEAR(Given<Scalar>("{value: 5 mm, std: 2 mm}").covariance()(0, 0), 4e-6, 1e-18);
  EXPECT_NE(Given<Pair>("5 mm").errors, "");
}

TEST(ReadEstimate, TakesValueAndCovarianceInTheUnitsOfTheValues) {
  const Given<Pair> given("{value: {a: 1 mm, b: 1 m}, covariance: [[4, 0.001], [0.001, 1e-6]]}");
  EXPECT_EQ(given.errors, "");
  EXPECT_NEAR(given.covariance()(0, 0), 4e-6, 1e-15);
  EXPECT_NEAR(given.covariance()(0, 1), 1e-6, 1e-15);
  EXPECT_NEAR(given.covariance()(1, 1), 1e-6, 1e-15);
  EXPECT_EQ(given.owners.at(0).name, "name");
}

TEST(ReadEstimate, CovarianceOfALeftOutComponentIsInSi) {
  const Given<Pair> given("{value: {a: 1 mm}, covariance: [[4, 0], [0, 9]]}");
  EXPECT_EQ(given.errors, "");
  EXPECT_DOUBLE_EQ(given.value(1), 2.0);
  EXPECT_NEAR(given.covariance()(1, 1), 9, 1e-12);
}

TEST(ReadEstimate, LeftOutComponentsTakeTheirDefaultsOrAreAsked) {
  EXPECT_DOUBLE_EQ(Given<Pair>("{a: 1 m}").value(1), 2.0);
  EXPECT_EQ(Given<Pair>("{b: 1 m}").errors,
            "value:1:1: pair needs its component 'a', a length (m)\n");
}

TEST(ReadEstimate, WrapsCircularComponentsAndReadsLabels) {
  const Given<Turn> given("{angle: {value: 270 deg, std: 1 deg}, side: right}");
  EXPECT_EQ(given.errors, "");
  EXPECT_NEAR(given.value(0), -std::numbers::pi / 2, 1e-12);
  EXPECT_DOUBLE_EQ(given.value(1), 1.0);
  EXPECT_EQ(given.read->estimate.labels, std::vector<int>{1});
  EXPECT_NE(Given<Turn>("{angle: 0, side: up}").errors, "");
}

TEST(ReadEstimate, SaysWhatIsWrong) {
  const std::pair<const char*, const char*> cases[] = {
      {"{a: 1 m, bb: 2 m}", "1:10: pair has no component 'bb'; did you mean 'b'?"},
      {"{a: 1 deg}", "1:5: 'deg' is not a length (m)"},
      {"{a: 1}", "1:5: '1' has no unit; expected a length (m)"},
      {"{a: {value: 1 m, std: -1 mm}}", "1:23: a std cannot be negative, got '-1 mm'"},
      {"{a: {value: 1 m, std: 1 deg}}", "1:23: std '1 deg' does not fit its value in 'm'"},
      {"{a: {value: 1 m, std: 1}}", "1:23: std '1' has no unit; expected a length (m)"},
      {"{a: {value: 0, std: 2}}", "1:13: the std '2' has no unit; expected a length (m)"},
      {"{a: {value: 1 m, std: 1e200 m}}", "1:13: '1 m' is too large, or its std is"},
      {"{a: {std: 1 m}}", "1:5: a quantity needs its value"},
      {"{a: {value: 1 m, sd: 1 m}}",
       "1:18: a quantity has value and std, not 'sd'; did you mean 'std'?"},
      {"{a: [1 m]}",
       "1:5: expected a quantity such as '11 deg', or {value: ..., std: ...}, got a list"},
      {"{a: nan m}",
       "1:5: 'nan m' is not a quantity; expected a finite number and a unit, such as '11 deg'"},
      {"[1 m, 2 m]", "1:1: expected a map of pair's components, got a list"},
      {"{value: {a: 1 m}, covariance: [[1]]}",
       "1:31: expected a covariance of 2 rows of 2 numbers"},
      {"{value: {a: 1 m}, covariance: [[1, 0], [0]]}", "1:40: expected a row of 2 numbers"},
      {"{value: {a: 1 m}, covariance: [[1, 0.5], [0, 1]]}", "1:31: a covariance must be symmetric"},
      {"{value: {a: 1 m}, covariance: [[1, 2], [2, 1]]}",
       "1:31: a covariance must be positive semidefinite"},
      {"{value: {a: 1 m}, covariance: [[-1, 0], [0, 1]]}",
       "1:31: a covariance must be positive semidefinite"},
      {"{value: {a: 1 m}, covariance: [[0, 1e-6], [1e-6, 1]]}",
       "1:31: a covariance must be positive semidefinite"},
      {"{value: {a: 1 m}, covariance: [[1e-300, 1e300], [1e300, 1e-300]]}",
       "1:31: a covariance must be positive semidefinite"},
      {"{value: {a: 1 km}, covariance: [[1e306, 0], [0, 1]]}", "1:32: the covariance is too large"},
      {"{value: {a: 1 m}, covariance: [[nan, 0], [0, 1]]}",
       "1:33: expected a number in the product of the values' units, got 'nan'"},
      {"{value: {a: 1 m}, covariance: [[1 m, 0], [0, 1]]}",
       "1:33: expected a number in the product of the values' units, got '1 m'"},
      {"{value: {a: 0}, covariance: [[1, 0], [0, 1]]}",
       "1:13: '0' has no unit, and so its variance has none; expected a length (m)"},
      {"{value: {a: {value: 1 m, std: 1 m}}, covariance: [[1, 0], [0, 1]]}",
       "1:21: give either a std or a covariance, not both"},
      {"{value: {a: 1 m}, std: 1 m}", "1:19: expected value and covariance, got 'std'"}};
  for (const auto& [text, error] : cases)
    EXPECT_EQ(Given<Pair>(text).errors, std::string("value:") + error + "\n") << text;
}

TEST(ReadEstimate, TakesSemidefiniteCovariances) {
  const Given<Pair> given("{value: {a: 1 m, b: 1 m}, covariance: [[4, 2], [2, 1]]}");
  EXPECT_EQ(given.errors, "");
  EXPECT_LT((given.covariance() - (Eigen::Matrix2d() << 4, 2, 2, 1).finished()).norm(), 1e-12);
}

TEST(ReadQuantity, ZeroTakesTheUnitOfItsStd) {
  const Given<Turn> given("{angle: {value: 0, std: 1 deg}}");
  EXPECT_EQ(given.errors, "");
  EXPECT_NEAR(given.covariance()(0, 0), std::pow(std::numbers::pi / 180, 2), 1e-15);
}

// --- constants

/// The parameters of `g: {type: gain, gain: GAIN, offset: OFFSET}` under given constants.
Plan gain_plan(const std::string& constants, const std::string& gain, const std::string& offset,
               const std::filesystem::path& directory = ".") {
  return plan_of("constants: " + constants +
                     "\nmodules: {r: {type: reading}, g: {type: gain, gain: " + gain +
                     ", offset: " + offset + "}}\nnetwork: {serial: [r, g]}\n",
                 {}, directory);
}
const Estimate& gain_parameters(const Plan& plan) {
  return plan.nodes[plan.find("g").value()].parameters;
}

TEST(Constants, OneNameIsOneSource) {
  const Plan plan = plan_of(R"(
constants: {k: {value: 1 m, std: 1 mm}}
modules: {a: {type: reading, bias: $k}, b: {type: reading, mount: {x: $k}}, s: {type: subtract}}
network: {serial: [combine: [a, b], s]}
)");
  System system(plan, 1);
  system.evaluate(time_at(0));
  EXPECT_EQ(test::estimate_of(system, "a").lineage.size(), 1u);
  EXPECT_EQ(test::output_of(system).lineage.variance(0), 0.0);
}

TEST(Constants, InlineValuesAreSourcesOfTheirOwnEvenThroughAnAnchor) {
  const Plan plan = plan_of(R"(
modules:
  a: {type: reading, bias: &k {value: 1 m, std: 1 mm}}
  b: {type: reading, bias: *k}
  s: {type: subtract}
network: {serial: [combine: [a, b], s]}
)");
  System system(plan, 1);
  system.evaluate(time_at(0));
  EXPECT_NEAR(test::output_of(system).lineage.variance(0), 2e-6, 1e-15);
}

TEST(Constants, VectorWithCovarianceKeepsTheCorrelation) {
  const Plan plan = gain_plan(
      "{fit: {value: {g: 2, o: 5 mm}, covariance: [[0.04, 0.1], [0.1, 1]]}}", "$fit.g", "$fit.o");
  const Eigen::MatrixXd covariance = gain_parameters(plan).lineage.covariance();
  EXPECT_NEAR(covariance(0, 0), 0.04, 1e-12);
  EXPECT_NEAR(covariance(0, 1), 0.1e-3, 1e-12);
  EXPECT_NEAR(covariance(1, 1), 1e-6, 1e-15);
  EXPECT_EQ(plan.owners.at(2).name, "fit");
  EXPECT_TRUE(plan.owners.at(2).persistent);
}

TEST(Constants, VectorElementsMayHaveStds) {
  const Plan plan = gain_plan(
      "{fit: {value: {g: {value: 2, std: 0.1}, o: {value: 5 mm, std: 1 mm}}}}", "$fit.g", "$fit.o");
  const Eigen::MatrixXd covariance = gain_parameters(plan).lineage.covariance();
  EXPECT_NEAR(covariance(0, 0), 0.01, 1e-12);
  EXPECT_EQ(covariance(0, 1), 0);
}

TEST(Constants, ComeFromCalibrationFiles) {
  const Folder folder;
  folder.write("fit.yaml", "value: {g: 2, o: 5 mm}\ncovariance: [[0.04, 0], [0, 1]]\n");
  folder.write("one.yaml", "{value: 3, std: 0.5}\n");
  const Plan plan =
      gain_plan("{fit: {file: fit.yaml}, one: {file: one.yaml}}", "$one", "$fit.o", folder.path());
  EXPECT_DOUBLE_EQ(gain_parameters(plan).value[0], 3);
  EXPECT_DOUBLE_EQ(gain_parameters(plan).value[1], 0.005);
  EXPECT_NEAR(gain_parameters(plan).lineage.variance(0), 0.25, 1e-12);
}

/// What is said of a graph with these constants, `gain: GAIN` being the only use.
std::string constant_errors(const std::string& constants, const std::string& gain = "1",
                            const std::string& offset = "1 m") {
  return read_text("constants: " + constants +
                   "\nmodules: {r: {type: reading}, g: {type: gain, gain: " + gain +
                   ", offset: " + offset + "}}\nnetwork: {serial: [r, g]}\n")
      .errors;
}

TEST(Constants, SayWhatIsWrong) {
  const std::tuple<const char*, const char*, const char*> cases[] = {
      {"{k: 2}", "$kk", "2:53: unknown constant 'kk'; did you mean 'k'?"},
      {"{k: {value: {x: 1, y: 2}}}", "$k",
       "2:53: 'k' is a vector; name one of its elements: $k.x, $k.y"},
      {"{k: {value: {x: 1, y: 2}}}", "$k.z", "2:53: unknown constant 'k.z'; did you mean 'k.x'?"},
      {"{k: 2 m}", "$k", "2:53: 'm' is not a pure number"},
      {"{k: 2, l: $k}", "$k", "1:22: a constant cannot refer to another constant"},
      {"{k.x: 2}", "1", "1:13: 'k.x' cannot name a constant: names have no dots, spaces or $"},
      {"{k: {value: {x: 1}, std: 2}}", "1",
       "1:32: a vector constant has value and covariance, not 'std'"},
      {"{k: {value: {}}}", "1", "1:24: a vector needs an element"},
      {"{k: {value: {x: 1}, covariance: [[-1]]}}", "1",
       "1:44: a covariance must be positive semidefinite"},
      {"{k: {value: {x: 1, y: 1}, covariance: [[1, 0.2], [0.1, 1]]}}", "1",
       "1:50: a covariance must be symmetric"},
      {"{k: {value: {x: {value: 1, std: 1}}, covariance: [[1]]}}", "1",
       "1:36: give either a std or a covariance, not both"},
      {"{k: {file: [x]}}", "1", "1:23: expected a path, got a list"},
      {"[1]", "1", "1:12: expected a map of names to values, got a list"}};
  for (const auto& [constants, gain, error] : cases)
    EXPECT_EQ(constant_errors(constants, gain), std::string("graph.yaml:") + error + "\n")
        << constants;
}

TEST(Constants, ZeroWithAStdNeedsAUnit) {
  EXPECT_EQ(constant_errors("{k: {value: 0, std: 0.5}}", "1", "$k"),
            "graph.yaml:2:64: the std '0.5' has no unit; expected a length (m)\n");
  EXPECT_EQ(
      constant_errors("{k: {value: {x: 0, y: 1 m}, covariance: [[4, 0], [0, 4]]}}", "1", "$k.x"),
      "graph.yaml:2:64: the std '2' has no unit; expected a length (m)\n");
}

TEST(Constants, WhatIsWrongWithOneIsSaidOnce) {
  EXPECT_EQ(constant_errors("{k: {value: 1, std: -1}}", "$k"),
            "graph.yaml:1:32: a std cannot be negative, got '-1'\n");
}

TEST(Constants, ReferToTheirGraphOnly) {
  const Folder folder;
  folder.write("inner.yaml", "modules: {r: {type: reading, bias: $k}}\nnetwork: r\n");
  const auto read =
      read_text("constants: {k: 1 m}\nmodules: {in: {type: {ilss: inner.yaml}}}\nnetwork: in\n", {},
                folder.path());
  EXPECT_EQ(read.errors, (folder.path() / "inner.yaml").string() + ":1:36: unknown constant 'k'\n");
}

TEST(Parameters, AScalarInPlaceOfAGroupIsAnError) {
  EXPECT_EQ(read_text("modules: {r: {type: reading, mount: 3 mm}}\nnetwork: r\n").errors,
            "graph.yaml:1:37: expected a map, got '3 mm'\n");
}

TEST(Parameters, AnglesAreWrapped) {
  const Plan plan = plan_of("modules: {t: {type: turn_reading, angle: 350 deg}}\nnetwork: t\n");
  EXPECT_NEAR(plan.nodes[0].parameters.value[0], -std::numbers::pi / 18, 1e-12);
}

}  // namespace
}  // namespace ilss
