// The module `expression`: what it computes, how errors go through it, and what is said of a wrong
// one.
#include "sensors/formula/expression.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

#include "framework/graph/given_outputs.h"
#include "tests/allocation_count.h"
#include "tests/sensors/formula/graph_of_formulas.h"

namespace ilss {
namespace {

using test::Evaluated;
using test::read_expression;
using test::read_formulas;

TEST(Expression, ComputesInSiAndReportsTheSiUnit) {
  const Evaluated sum(read_expression("a: 2 mm, b: {value: 3 cm, std: 1 mm}",
                                      "length: {unit: nm, formula: 2 * a + b}"));
  EXPECT_DOUBLE_EQ(sum.value(), 0.034);
  EXPECT_EQ(sum.estimate().type->components[0].unit, "m");
  EXPECT_EQ(sum.estimate().type->name, "length");
  EXPECT_DOUBLE_EQ(sum.estimate().lineage.standard_deviation(0), 0.001);
}

TEST(Expression, AngleIsMadeANumberByRad) {
  const Evaluated arc(
      read_expression("r: 2 m, phi: 90 deg", "arc: {unit: m, formula: r * phi / rad}"));
  EXPECT_DOUBLE_EQ(arc.value(), M_PI);
}

TEST(Expression, AffineUnitsAreOfTheirKelvins) {
  const Evaluated rise(
      read_expression("a: 30 degC, b: 293.15 K", "rise: {unit: K, formula: a - b}"));
  EXPECT_NEAR(rise.value(), 10, 1e-12);
}

TEST(Expression, OneConstantIsOneSourceThroughAllComponents) {
  const Evaluated both(read_formulas(R"(
constants: {k: {value: 3 m, std: 0.1 m}}
modules:
  f:
    type: expression
    quantities: {a: $k, b: $k}
    output: {zero: {unit: m, formula: a - b}, twice: {unit: m, formula: a + b}}
network: f
)"));
  EXPECT_EQ(both.estimate().type->name, "zero_twice");
  EXPECT_EQ(both.estimate().lineage.standard_deviation(0), 0);
  EXPECT_DOUBLE_EQ(both.estimate().lineage.standard_deviation(1), 0.2);
}

TEST(Expression, CircularComponentsWrap) {
  const std::string formula = "unit: deg, formula: a + 200 * pi / 180 * rad";
  const Evaluated wrapped(read_expression("a: 10 deg", "a2: {" + formula + ", circular: true}"));
  EXPECT_NEAR(wrapped.value(), -150 * M_PI / 180, 1e-12);
  const Evaluated plain(read_expression("a: 10 deg", "a2: {" + formula + "}"));
  EXPECT_NEAR(plain.value(), 210 * M_PI / 180, 1e-12);
}

/// The formulas of vision_line.h, its parameters as constants.
constexpr const char* vision_line = R"(
constants:
  focal_length: {value: 6 mm, std: 0.01 mm}
  target_height: {value: 200 mm, std: 0.2 mm}
  stripe_spacing: {value: 300 mm, std: 0.3 mm}
modules:
  camera: {type: camera, focal_length: $focal_length, pixel_pitch: 40 um, input: {scene: scenes/wall_target.yaml}}
  target_points: {type: target_points}
  own: {type: vision_line, target_height: $target_height, stripe_spacing: $stripe_spacing, focal_length: $focal_length}
  written:
    type: expression
    inputs: [rows]
    quantities: {Y0: $target_height, D0: $stripe_spacing, f: $focal_length, s: 1 m}
    payload: wall_points
    output:
      x1: {unit: m, formula: 0}
      z1: {unit: m, formula: f * Y0 / rows.y_c}
      x2: {unit: m, formula: s * sqrt(1 - ((f * Y0 / rows.y_l - f * Y0 / rows.y_r) / D0)^2)}
      z2: {unit: m, formula: f * Y0 / rows.y_c - s * (f * Y0 / rows.y_l - f * Y0 / rows.y_r) / D0}
  robot: {type: planar_transform}
network: {serial: [camera, target_points, {combine: [own, written, {serial: [written, robot]}]}]}
)";

/// The same values and lineage, to rounding.
void expect_same(const Estimate& a, const Estimate& b) {
  ASSERT_EQ(a.type, b.type);
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.labels, b.labels);
  for (std::size_t i = 0; i < a.dimension(); ++i)
    EXPECT_NEAR(a.value[i], b.value[i], 1e-12 * std::abs(b.value[i])) << i;
  ASSERT_TRUE(std::ranges::equal(a.lineage.sources(), b.lineage.sources()));
  EXPECT_LE((a.lineage.factor() - b.lineage.factor()).norm(), 1e-12 * b.lineage.factor().norm());
}

TEST(Expression, VisionLineWrittenAsFormulasIsTheModule) {
  Diagnostics diagnostics;
  const Node graph = parse_document(vision_line, "graph.yaml", diagnostics);
  const auto read = build_plan(graph, ILSS_SOURCE_DIR "/graphs", test::sensors(), {}, diagnostics);
  ASSERT_EQ(test::lines_of(diagnostics), "");
  const Plan& plan = read.value();
  const PayloadDescriptor& rows = *plan.nodes[*plan.find("target_points")].interface.output;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<> depth(0.7, 2.5);
    std::uniform_real_distribution<> tilt(-0.2, 0.2);
    const double z = depth(random);
    const double sine = tilt(random);
    Estimate given(rows, "camera");
    const double depths[] = {z + 0.15 * sine, z, z - 0.15 * sine};
    for (std::size_t i = 0; i < 3; ++i) given.value[i] = 0.006 * 0.2 / depths[i];
    Eigen::MatrixXd noise = Eigen::MatrixXd::Random(3, 3) * 1e-6;
    given.lineage.add_noise({100, 0, 0}, noise * noise.transpose());
    System system(
        plan, 1,
        {.folding = Folding::none,
         .stand_ins = given_outputs({{*plan.find("target_points"), {Output{given}, true}}})});
    system.expect();
    const Estimate& own = system.node(*plan.find("own")).output().estimate;
    const Estimate& written = system.node(*plan.find("written")).output().estimate;
    ASSERT_TRUE(system.node(*plan.find("written")).outcome.has_output());
    expect_same(written, own);
    EXPECT_TRUE(system.node(*plan.find("robot")).outcome.has_output());
  }
}

TEST(Expression, AllocatesNothingOnceItRuns) {
  SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED();
  const test::FormulaGraph graph = read_expression(
      "x: {value: 3 m, std: 1 mm}, y: {value: 2 m, std: 1 mm}",
      "r: {unit: m, formula: 'hypot(x, y)'}, a: {unit: rad, formula: 'atan2(y, x)'}");
  System system(*graph.plan, 1, Folding::none);
  for (int tick = 0; tick < 3; ++tick) system.evaluate(time_at(tick));
  const std::size_t before = allocation_count;
  for (int tick = 3; tick < 100; ++tick) system.evaluate(time_at(tick));
  EXPECT_EQ(allocation_count, before);
  EXPECT_TRUE(test::only_output(system).outcome.has_output());
}

/// The fault of an expression that has no output.
std::string fault_of(const std::string& quantities, const std::string& output) {
  const Evaluated evaluated(read_expression(quantities, output));
  const Outcome<>& outcome = evaluated.state().outcome;
  if (!outcome.is_fault()) return "no fault";
  return fmt::format("{}: {}", fault_name(outcome.fault().kind), outcome.fault().message);
}

TEST(Expression, DivisionByZeroIsAFaultThatNamesTheOperatingPoint) {
  EXPECT_EQ(fault_of("x: 0 m, y: 2 m", "q: {unit: 1, formula: y / x}"),
            "not_finite: formula of 'q' has no finite value at y = 2 m, x = 0 m: it divides by "
            "zero");
  EXPECT_EQ(
      fault_of("x: {value: 0 m, std: 1 m}, y: 2 m", "q: {unit: 1, formula: atan(y / x) / rad}"),
      "not_finite: formula of 'q' has no finite value at y = 2 m, x = 0 m: it divides by "
      "zero");
}

TEST(Expression, FaultsNameTheFirstOperationWithoutAFiniteValue) {
  const std::string of = "not_finite: formula of 'q' has no finite value at x = ";
  EXPECT_EQ(fault_of("x: -1", "q: {unit: 1, formula: sqrt(x) + log(x)}"),
            of + "-1: it takes the square root of -1");
  EXPECT_EQ(fault_of("x: 0", "q: {unit: 1, formula: log(x)}"),
            of + "0: it takes the logarithm of 0");
  EXPECT_EQ(fault_of("x: 2", "q: {unit: rad, formula: asin(x)}"),
            of + "2: it takes the arc sine of 2");
  EXPECT_EQ(fault_of("x: -2", "q: {unit: 1, formula: x^0.5}"),
            of + "-2: it raises -2 to the power 0.5");
  EXPECT_EQ(fault_of("x: 1000", "q: {unit: 1, formula: exp(x)}"),
            of + "1000: it is too large for a number");
}

TEST(Expression, InfiniteDerivativeIsAFaultWhereItMatters) {
  EXPECT_EQ(fault_of("x: {value: 0, std: 1}", "q: {unit: 1, formula: sqrt(x)}"),
            "not_finite: formula of 'q' has no finite derivative at x = 0: it takes the square "
            "root of 0");
  EXPECT_EQ(fault_of("x: {value: 0, std: 1}, y: {value: 0, std: 1}",
                     "q: {unit: 1, formula: 'hypot(x, y)'}"),
            "not_finite: formula of 'q' has no finite derivative at x = 0, y = 0: it takes the "
            "hypotenuse of 0 and 0");
}

TEST(Expression, InfiniteDerivativeByWhatIsExactIsNone) {
  const Evaluated exact(
      read_expression("x: 0, y: {value: 1, std: 1}", "q: {unit: 1, formula: sqrt(x) + y}"));
  ASSERT_TRUE(exact.state().outcome.has_output());
  EXPECT_EQ(exact.estimate().lineage.standard_deviation(0), 1);
}

TEST(Expression, MismatchedUnitsAreErrorsWithTheirPositions) {
  EXPECT_EQ(read_expression("x: 1 m, a: 1 rad, n: 2, t: 1 s", R"yaml(
      p: {unit: m, formula: x + a},
      q: {unit: m, formula: x * t},
      r: {unit: 1, formula: sin(n)},
      s: {unit: 1, formula: exp(x)},
      u: {unit: m, formula: x^n},
      v: {unit: m, formula: "max(x, t)"},
      w: {unit: 1, formula: a},
      z: {unit: m, formula: x + 1})yaml")
                .errors,
            "graph.yaml:6:29: formula of 'p' adds a length (m) and an angle (rad)\n"
            "graph.yaml:7:29: formula of 'q' gives a quantity in m.s, but its unit says a length "
            "(m)\n"
            "graph.yaml:8:29: formula of 'r' takes sin of a pure number, not of an angle (rad); "
            "write '* rad' to make it one\n"
            "graph.yaml:9:29: formula of 's' takes exp of a length (m), not of a pure number\n"
            "graph.yaml:10:29: formula of 'u' raises a length (m) to a power that varies; the "
            "exponent must be a number\n"
            "graph.yaml:11:30: formula of 'v' compares a length (m) with a time (s)\n"
            "graph.yaml:12:29: formula of 'w' gives an angle (rad), but its unit says a pure "
            "number; write '* rad' or '/ rad' where an angle stands for a number\n"
            "graph.yaml:13:29: formula of 'z' adds a length (m) and a pure number\n");
}

TEST(Expression, MistakesStandAtTheirColumns) {
  EXPECT_EQ(read_expression("x: 1 m", R"yaml(
      p: {unit: m, formula: x + yy},
      q: {unit: m, formula: "x + (x"},
      r: {unit: m, formula: x x})yaml")
                .errors,
            "graph.yaml:6:33: formula of 'p': unknown name 'yy'\n"
            "graph.yaml:7:36: formula of 'q': a ')' is missing\n"
            "graph.yaml:8:31: formula of 'r': unexpected 'x'; is an operator missing before it?\n");
}

TEST(Expression, ConstantPartWithoutAValueIsFoundByCheck) {
  EXPECT_EQ(read_expression("x: 1", "q: {unit: 1, formula: x + 1 / (2 - 2)}").errors,
            "graph.yaml:5:36: formula of 'q' has no finite value: it divides by zero\n");
}

TEST(Expression, UnusedQuantitiesAndInputsAreErrors) {
  EXPECT_EQ(read_expression("x: 1, spare: 2", "q: {unit: 1, formula: x}").errors,
            "graph.yaml:4:24: 'spare' is not used\n");
  EXPECT_EQ(read_formulas(R"(
modules:
  a: {type: expression, output: {x: {unit: m, formula: 0}}}
  f: {type: expression, inputs: [in], output: {q: {unit: 1, formula: 2}}}
network: {serial: [a, f]}
)")
                .errors,
            "graph.yaml:4:34: 'in' is not used\n");
}

TEST(Expression, NamesThatFormulasCannotUseAreErrors) {
  EXPECT_EQ(read_expression("2x: 1, pi: 2, a-b: 3", "q r: {unit: 1, formula: 1}").errors,
            "graph.yaml:4:18: '2x' cannot name a quantity: a name is of letters, digits and _, and "
            "does not begin with a digit\n"
            "graph.yaml:4:25: 'pi' cannot name a quantity: it means something in formulas already\n"
            "graph.yaml:4:32: 'a-b' cannot name a quantity: a name is of letters, digits and _, "
            "and does not begin with a digit\n"
            "graph.yaml:5:14: 'q r' cannot name a component: a name is of letters, digits and _, "
            "and does not begin with a digit\n");
}

TEST(Expression, OutputWithoutUnitOrFormulaIsAnError) {
  EXPECT_EQ(
      read_expression("", "q: {formula: 1}, r: {unit: 1}, s: 3, u: {unit: parrots, formula: 1}")
          .errors,
      "graph.yaml:5:14: component 'q' needs a unit ('1' for a pure number)\n"
      "graph.yaml:5:31: component 'r' needs a formula\n"
      "graph.yaml:5:48: expected {unit: ..., formula: ...} of component 's', got '3'\n"
      "graph.yaml:5:61: expected the unit of 'u' ('1' for a pure number), got 'parrots'\n");
  EXPECT_EQ(read_formulas("modules: {f: {type: expression}}\nnetwork: f\n").errors,
            "graph.yaml:1:11: an expression needs its output: a map of components, each {unit: "
            "..., formula: ...}\n");
}

TEST(Expression, InputOfOneComponentIsAlsoNamedByItself) {
  const Evaluated chain(read_formulas(R"(
modules:
  a: {type: expression, quantities: {k: {value: 2 m, std: 1 m}}, output: {x: {unit: m, formula: k}}}
  f: {type: expression, inputs: [in], output: {q: {unit: m2, formula: in * in.x}}}
network: {serial: [a, f]}
)"));
  EXPECT_EQ(chain.value(), 4);
  EXPECT_EQ(chain.estimate().lineage.standard_deviation(0), 4);
}

TEST(Expression, ComponentsOfSeveralMustBeNamed) {
  EXPECT_EQ(read_formulas(R"(
modules:
  a: {type: expression, output: {x: {unit: m, formula: 0}, y: {unit: m, formula: 0}}}
  f: {type: expression, inputs: [in], output: {q: {unit: m, formula: in + in.z}}}
network: {serial: [a, f]}
)")
                .errors,
            "graph.yaml:4:70: formula of 'q': 'in' has several components; expected one of in.x, "
            "in.y\n"
            "graph.yaml:4:75: formula of 'q': unknown name 'in.z'; did you mean 'in.x'?\n");
}

TEST(Expression, PayloadOfAKnownNameMustHaveItsComponents) {
  EXPECT_EQ(read_formulas(R"(
modules:
  f: {type: expression, payload: wall_points, output: {x1: {unit: m, formula: 0}}}
network: f
)")
                .errors,
            "graph.yaml:3:3: 'f' gives a payload 'wall_points' of other components than that has: "
            "x1 (m), z1 (m), x2 (m), z2 (m); name it otherwise\n");
}

TEST(Expression, FrameIsTheFirstInputsUnlessTheGraphNamesOne) {
  const std::string graph = R"(
modules:
  a: {type: expression, frame: table, output: {x: {unit: m, formula: 0}}}
  f: {type: expression, inputs: [in], FRAME output: {q: {unit: m, formula: in}}}
network: {serial: [a, f]}
)";
  const auto with = [&](const std::string& frame) {
    std::string text = graph;
    text.replace(text.find("FRAME"), 5, frame);
    return Evaluated(read_formulas(text)).estimate().frame;
  };
  EXPECT_EQ(with(""), "table");
  EXPECT_EQ(with("frame: shelf,"), "shelf");
}

/// The first message of `check` on a graph in a file, without the file's name.
std::string first_message(const std::string& text) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / "ilss_folded_formula.yaml";
  std::ofstream(file) << text;
  Diagnostics diagnostics;
  EXPECT_FALSE(read_plan(file, test::sensors(), {}, diagnostics));
  std::filesystem::remove(file);
  const std::string lines = test::lines_of(diagnostics);
  return lines.substr(file.string().size(), lines.find('\n') - file.string().size());
}

TEST(Expression, FoldedFormulaIsReportedWhereItBegins) {
  const std::string head =
      "modules:\n  f:\n    type: expression\n    output:\n      q:\n        unit: 1\n        ";
  const std::string message = "formula of 'q': unknown name 'zz'";
  EXPECT_EQ(first_message(head + "formula: >\n          1 +\n          zz\nnetwork: f\n"),
            ":7:18: " + message);
  EXPECT_EQ(first_message(head + "formula: 1 +\n          zz\nnetwork: f\n"), ":7:18: " + message);
  EXPECT_EQ(first_message(head + "formula: 1 + zz\nnetwork: f\n"), ":7:22: " + message);
  EXPECT_EQ(first_message(head + "formula: '1 + zz'\nnetwork: f\n"), ":7:23: " + message);
}

}  // namespace
}  // namespace ilss
