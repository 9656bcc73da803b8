// The examples of JCGM 100:2008 (GUM) and JCGM 101:2008 (its supplement 1) as graphs: every
// published first-order figure to its printed digits.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "framework/estimate/budget.h"
#include "framework/graph/system.h"
#include "framework/semantics/monte_carlo.h"
#include "framework/semantics/verdict.h"
#include "sensors/register.h"

namespace ilss {
namespace {

/// A graph of tests/data/gum, evaluated at its operating point.
class GumExample {
 public:
  explicit GumExample(const std::string& name, const std::vector<std::string>& sets = {})
      : plan_(read(name, sets)), system_(plan_, 1, Folding::none) {
    system_.expect();
  }
  const Plan& plan() const { return plan_; }
  const System& system() const { return system_; }
  const Estimate& estimate(std::size_t output = 0) const {
    const NodeState& state = system_.node(plan_.outputs.at(output));
    EXPECT_TRUE(state.outcome.has_output());
    return state.output().estimate;
  }
  double value(std::size_t component = 0) const { return estimate().value.at(component); }
  double deviation(std::size_t component = 0) const {
    return estimate().lineage.standard_deviation(component);
  }
  /// The part of the output's standard deviation that one constant or quantity is to blame for.
  double contribution(const std::string& owner) const {
    for (const BudgetEntry& entry : budget(estimate().lineage))
      if (plan_.owners.at(entry.owner).name == owner) return std::sqrt(entry.variance.at(0));
    ADD_FAILURE() << owner << " is not in the budget";
    return 0;
  }

 private:
  static Plan read(const std::string& name, const std::vector<std::string>& sets) {
    static const Registry& registry = *[] {  // which plans refer to
      auto* made = new Registry;
      register_sensors(*made);
      return made;
    }();
    Diagnostics diagnostics;
    std::vector<Override> overrides;
    for (const std::string& set : sets)
      overrides.push_back(parse_override(set, "test", diagnostics).value());
    auto plan = read_plan(fmt::format("{}/gum/{}.yaml", ILSS_TEST_DATA, name), registry, overrides,
                          diagnostics);
    for (const Diagnostic& d : diagnostics.sorted()) ADD_FAILURE() << format_diagnostic(d);
    return std::move(plan.value());
  }

  Plan plan_;
  System system_;
};

std::string printed(double value, int decimals) { return fmt::format("{:.{}f}", value, decimals); }

constexpr double nanometre = 1e-9;

TEST(GaugeBlock, LengthAndItsUncertainty) {  // H.1.6
  const GumExample gauge("gauge_block");
  EXPECT_EQ(printed(gauge.value() / nanometre, 0), "50000838");
  EXPECT_EQ(printed(gauge.deviation() / nanometre, 0), "32");
  EXPECT_EQ(printed(gauge.deviation() / nanometre, 2), "31.66");
}

TEST(GaugeBlock, ContributionsOfTable) {  // table H.1
  const GumExample gauge("gauge_block");
  const auto nanometres = [&](const std::string& owner) {
    return gauge.contribution(owner) / nanometre;
  };
  EXPECT_EQ(printed(nanometres("standard"), 0), "25");
  EXPECT_EQ(printed(nanometres("temperature_difference"), 1), "16.6");
  EXPECT_EQ(printed(nanometres("systematic_effects"), 1), "6.7");
  EXPECT_EQ(printed(nanometres("reading"), 1), "5.8");
  EXPECT_EQ(printed(nanometres("random_effects"), 1), "3.9");
  EXPECT_EQ(printed(nanometres("expansion_difference"), 1), "2.9");
  // Zero to first order: their sensitivities vanish.
  EXPECT_EQ(nanometres("expansion"), 0);
  EXPECT_EQ(nanometres("temperature"), 0);
  EXPECT_EQ(nanometres("temperature_cycle"), 0);
}

TEST(ThermometerCalibration, LineThroughTheReadings) {  // H.3.3
  const GumExample calibration("thermometer_calibration");
  EXPECT_EQ(printed(calibration.value(0), 4), "-0.1712");
  EXPECT_EQ(printed(calibration.deviation(0), 4), "0.0029");
  EXPECT_EQ(printed(calibration.value(1), 5), "0.00218");
  EXPECT_EQ(printed(calibration.deviation(1), 5), "0.00067");
  const Eigen::MatrixXd covariance = calibration.estimate().lineage.covariance();
  const double correlation =
      covariance(0, 1) / (calibration.deviation(0) * calibration.deviation(1));
  EXPECT_EQ(printed(correlation, 3), "-0.930");
}

TEST(ThermometerCalibration, CorrectionAt30Degrees) {  // H.3.4
  const GumExample calibration("thermometer_calibration");
  const Estimate& correction = calibration.estimate(1);
  EXPECT_EQ(printed(correction.value.at(0), 4), "-0.1494");
  EXPECT_EQ(printed(correction.lineage.standard_deviation(0), 4), "0.0041");
}

TEST(ThermometerCalibration, WithoutTheCovarianceTheErrorWouldBeWrong) {  // reference/gum.md
  const GumExample calibration("thermometer_without_covariance");
  EXPECT_EQ(printed(calibration.value(), 4), "-0.1494");
  EXPECT_EQ(printed(calibration.deviation(), 4), "0.0073");
}

TEST(Additive, StandardDeviationsAddInSquares) {  // JCGM 101, 9.2
  EXPECT_EQ(printed(GumExample("additive_normal").deviation(), 1), "2.0");
  EXPECT_EQ(printed(GumExample("additive_uniform").deviation(), 1), "2.0");
  EXPECT_EQ(printed(GumExample("additive_dominant").deviation(), 1), "10.1");
  // The 95 % interval of first order, k = 1.96.
  EXPECT_EQ(printed(1.96 * GumExample("additive_normal").deviation(), 2), "3.92");
  EXPECT_EQ(printed(1.96 * GumExample("additive_dominant").deviation(), 1), "19.9");
}

TEST(ComparisonLoss, FirstOrderOfIndependentInputs) {  // JCGM 101, table 6
  const double x1[] = {0, 0.010, 0.050};
  const char* y[] = {"0", "100", "2500"};
  const char* u[] = {"0", "100", "500"};
  for (std::size_t i = 0; i < 3; ++i) {
    const GumExample loss("comparison_loss", {fmt::format("constants.x.value.x1.value={}", x1[i])});
    EXPECT_EQ(printed(loss.value() / 1e-6, 0), y[i]) << x1[i];
    EXPECT_EQ(printed(loss.deviation() / 1e-6, 0), u[i]) << x1[i];
  }
}

TEST(ComparisonLoss, FirstOrderOfCorrelatedInputsIsTheSame) {  // x2 = 0: the covariance drops out
  for (const double x1 : {0.0, 0.010, 0.050}) {
    const GumExample loss("comparison_loss_correlated",
                          {fmt::format("constants.x.value.x1={}", x1)});
    EXPECT_NEAR(loss.deviation(), 2 * x1 * 0.005, 1e-15) << x1;
  }
}

/// Half the length of the shortest 95 % interval of the first output.
double half_interval(const GumExample& example, std::size_t trials) {
  const MonteCarloOutput drawn = run_monte_carlo(example.system(), {}, {.trials = trials}).at(0);
  return (drawn.interval.at(0).high - drawn.interval.at(0).low) / 2;
}

TEST(GaugeBlock, SecondOrderTermsAndDegreesOfFreedom) {  // H.1.6, H.1.7 and F.2 of JCGM 100
  const auto corrected = [](const GumExample& example) {
    const VerdictReport report = judge(example.system()).at(0);
    return std::sqrt(example.estimate().lineage.variance(0) + report.extra_variance.at(0)) /
           nanometre;
  };
  const GumExample gauge("gauge_block");
  EXPECT_EQ(printed(corrected(gauge), 0), "34");
  // With the guide's u(theta), rounded from 0.406 to 0.41 K, two more digits are its own.
  EXPECT_EQ(
      printed(corrected(GumExample("gauge_block", {"constants.temperature.std=0.20760 K"})), 2),
      "33.84");
  const double degrees =
      effective_degrees_of_freedom(budget(gauge.estimate().lineage), gauge.plan().owners, 0);
  EXPECT_EQ(std::floor(degrees), 16);                        // 16.7, which the guide truncates
  EXPECT_EQ(printed(coverage_factor(16, 0.99), 2), "2.92");  // t_99(16) of H.1.7
}

TEST(GaugeBlock, MonteCarloAgreesWithSecondOrder) {
  const GumExample gauge("gauge_block");
  const MonteCarloOutput drawn = run_monte_carlo(gauge.system(), {}, {.trials = 1'000'000}).at(0);
  EXPECT_EQ(printed(std::sqrt(drawn.covariance(0, 0)) / nanometre, 0), "34");
  EXPECT_EQ(printed(drawn.mean[0] / nanometre, 0), "50000838");
}

TEST(Additive, MonteCarloIntervals) {  // JCGM 101, tables 2 to 4
  EXPECT_EQ(printed(half_interval(GumExample("additive_normal"), 4'000'000), 2), "3.92");
  EXPECT_EQ(printed(half_interval(GumExample("additive_uniform"), 4'000'000), 2), "3.88");
  EXPECT_EQ(printed(half_interval(GumExample("additive_dominant"), 1'000'000), 1), "17.0");
}

TEST(Additive, OneUniformErrorThatDominatesIsNoNormalOne) {
  EXPECT_EQ(judge(GumExample("additive_normal").system()).at(0).verdict, Verdict::linear_ok);
  EXPECT_EQ(judge(GumExample("additive_uniform").system()).at(0).verdict, Verdict::linear_ok);
  const VerdictReport report = judge(GumExample("additive_dominant").system()).at(0);
  EXPECT_EQ(report.verdict, Verdict::monte_carlo_required);
  EXPECT_NE(report.reason.find("not a normal one"), std::string::npos) << report.reason;
}

/// Mean and standard deviation of the comparison loss in 1e-6. It is quadratic, so that the second
/// order is exact, and Monte Carlo must agree with it as its number of trials allows.
std::string loss_moments(const GumExample& loss) {
  const VerdictReport report = judge(loss.system()).at(0);
  const double mean = loss.value() + report.bias.at(0);
  const double variance = loss.deviation() * loss.deviation() + report.extra_variance.at(0);
  constexpr std::size_t trials = 1'000'000;
  const MonteCarloOutput drawn = run_monte_carlo(loss.system(), {}, {.trials = trials}).at(0);
  EXPECT_NEAR(drawn.mean[0], mean, 4 * std::sqrt(variance / trials));
  EXPECT_NEAR(drawn.covariance(0, 0), variance, 4 * variance * std::sqrt(8.0 / trials));
  return printed(mean / 1e-6, 0) + " " + printed(std::sqrt(variance) / 1e-6, 0);
}

TEST(ComparisonLoss, MonteCarloAndSecondOrder) {  // JCGM 101, tables 6 and 7
  const double x1[] = {0, 0.010, 0.050};
  const char* independent[] = {"50 50", "150 112", "2550 502"};
  const char* correlated[] = {"50 67", "150 121", "2550 505"};
  for (std::size_t i = 0; i < 3; ++i) {
    SCOPED_TRACE(x1[i]);
    EXPECT_EQ(loss_moments(GumExample("comparison_loss",
                                      {fmt::format("constants.x.value.x1.value={}", x1[i])})),
              independent[i]);
    EXPECT_EQ(loss_moments(GumExample("comparison_loss_correlated",
                                      {fmt::format("constants.x.value.x1={}", x1[i])})),
              correlated[i]);
  }
}

TEST(ComparisonLoss, AtZeroOnlyMonteCarloTellsTheError) {
  for (const char* name : {"comparison_loss", "comparison_loss_correlated"}) {
    const VerdictReport report = judge(GumExample(name).system()).at(0);
    EXPECT_EQ(report.verdict, Verdict::monte_carlo_required) << name;
    // Beside the first-order error of 0 stands one that is not.
    EXPECT_EQ(printed(report.bias.at(0) / 1e-6, 0), "50");
    EXPECT_EQ(printed(std::sqrt(report.extra_variance.at(0)) / 1e-6, 0),
              std::string(name) == "comparison_loss" ? "50" : "67");
  }
}

TEST(ComparisonLoss, FarFromZeroFirstOrderHolds) {
  const GumExample loss("comparison_loss", {"constants.x.value.x1.value=0.5"});
  EXPECT_EQ(judge(loss.system()).at(0).verdict, Verdict::linear_ok);
}

}  // namespace
}  // namespace ilss
