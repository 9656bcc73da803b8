// Function modules: which way a tick is evaluated, how errors go through, and what it costs.
#include "framework/module/function_module.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "framework/estimate/rotation.h"
#include "tests/allocation_count.h"
#include "tests/orientation.h"

namespace ilss {
namespace {

constexpr std::string_view sides[] = {"left", "right"};
constexpr LabelField side_label[] = {{"side", sides}};

template <typename T>
struct Pair {
  T a, b;
  std::array<int, 1> label{};
  static constexpr std::string_view name = "test_pair";
  static constexpr auto fields = Fields{{"a", "m"}, {"b", "m"}};
  static constexpr std::span<const LabelField> labels = side_label;
};
template <typename T>
struct Single {
  T x;
  static constexpr std::string_view name = "test_single";
  static constexpr auto fields = Fields{{"x", "m"}};
};

/// (sin a, a b + k x) with the label passed on; faults and exceptions on special values of b.
struct Mixture {
  static constexpr std::string_view name = "mixture", description = "for tests";
  static constexpr std::array<std::string_view, 2> inputs = {"pair", "single"};
  template <typename T>
  struct Parameters {
    T k;
    static constexpr std::string_view name = "mixture_parameters";
    static constexpr auto fields = Fields{{"k", "1", "", 3.0}};
  };
  template <typename T>
  Outcome<Pair<T>> operator()(const Parameters<T>& p, const Pair<T>& in, const Single<T>& s) const {
    using std::sin;
    using std::sqrt;
    if (in.b == -1.0) return Fault{FaultKind::degenerate, "b is -1"};
    if (in.b == -2.0) return Pending{};
    if (in.b == -3.0) throw std::runtime_error("thrown by the formula");
    if (in.b == -4.0) return Pair<T>{in.a / (in.b + 4.0), in.b};
    if (in.b == -5.0) return Pair<T>{sqrt(in.b + 5.0), in.b};
    return Pair<T>{sin(in.a), in.a * in.b + p.k * s.x, in.label};
  }
};

struct MixtureWithJacobian : Mixture {
  void jacobian(const Parameters<double>& p, const Pair<double>& in, const Single<double>& s,
                const Pair<double>& value, std::span<double> out) const {
    EXPECT_EQ(value.a, std::sin(in.a));
    const double columns[] = {0, s.x, std::cos(in.a), in.b, 0, in.a, 0, p.k};
    std::copy_n(columns, 8, out.begin());
  }
};

struct First {
  static constexpr std::string_view name = "first", description = "2 a";
  static constexpr std::array<std::string_view, 1> inputs = {"pair"};
  template <typename T>
  Outcome<Single<T>> operator()(const Pair<T>& in) const {
    return Single<T>{2.0 * in.a};
  }
};
struct Difference {
  static constexpr std::string_view name = "difference", description = "one minus the other";
  static constexpr std::array<std::string_view, 2> inputs = {"one", "other"};
  template <typename T>
  Outcome<Single<T>> operator()(const Single<T>& one, const Single<T>& other) const {
    return Single<T>{one.x - other.x};
  }
};

/// A module's surroundings for one tick.
struct Bench {
  Output pair, single, output;
  Estimate parameters{descriptor<Mixture::Parameters>()};
  std::array<const Output*, 2> inputs{&pair, &single};

  Bench() {
    pair.estimate = Estimate(descriptor<Pair>());
    single.estimate = Estimate(descriptor<Single>());
    output.estimate = Estimate(descriptor<Pair>());
    pair.estimate.value = {0.5, 2};
    single.estimate.value = {7};
  }
  void add_errors() {
    pair.estimate.lineage.add_noise({0, 0, 0}, (Eigen::Matrix2d() << 2, 1, 1, 3).finished());
    single.estimate.lineage.add({0, 1, 0}, 0, 0.5);
    single.estimate.lineage.add({1, 0, 0}, 0, 0.25);
  }
  Evaluation evaluation() const { return {.parameters = parameters, .inputs = inputs}; }
  template <typename F = Mixture>
  Outcome<> evaluate() {
    return FunctionModule<F>(F{}).evaluate(evaluation(), output);
  }
};

TEST(FunctionModule, OfExactInputsGivesAnExactOutput) {
  Bench bench;
  bench.output.estimate.lineage.add({5, 5, 5}, 0, 1.0);  // of an earlier tick
  ASSERT_TRUE(bench.evaluate());
  EXPECT_EQ(bench.output.estimate.value, (std::vector{std::sin(0.5), 1.0 + 21.0}));
  EXPECT_TRUE(bench.output.estimate.lineage.empty());
  EXPECT_EQ(bench.output.estimate.lineage.dimension(), 2u);
}

/// Covariance by hand: J over (k, a, b, x), inputs correlated through source (0, 1, 0).
template <typename F>
void expect_propagated_covariance(bool uncertain_parameter) {
  Bench bench;
  bench.add_errors();
  if (uncertain_parameter) bench.parameters.lineage.add({2, 0, persistent_tick}, 0, 0.1);
  ASSERT_TRUE(bench.evaluate<F>());
  Eigen::MatrixXd j(2, 4);
  j << 0, std::cos(0.5), 0, 0, 7, 2, 0.5, 3;
  Eigen::MatrixXd p = Eigen::MatrixXd::Zero(4, 4);
  p.block(1, 1, 2, 2) << 2, 1, 1, 3;
  p(0, 0) = uncertain_parameter ? 0.01 : 0;
  p(3, 3) = 0.5 * 0.5 + 0.25 * 0.25;
  p.block(1, 3, 2, 1) =
      cross_covariance(bench.pair.estimate.lineage, bench.single.estimate.lineage);
  p.block(3, 1, 1, 2) = p.block(1, 3, 2, 1).transpose();
  const Eigen::MatrixXd expected = j * p * j.transpose();
  EXPECT_LT((bench.output.estimate.lineage.covariance() - expected).norm(),
            1e-13 * expected.norm());
}

TEST(FunctionModule, PropagatesCorrelatedErrorsOfInputs) {
  expect_propagated_covariance<Mixture>(false);
  expect_propagated_covariance<MixtureWithJacobian>(false);
}

TEST(FunctionModule, PropagatesErrorsOfParametersAndInputs) {
  expect_propagated_covariance<Mixture>(true);
  expect_propagated_covariance<MixtureWithJacobian>(true);
}

TEST(FunctionModule, PropagatesErrorsOfParametersAlone) {
  Bench bench;
  bench.parameters.lineage.add({2, 0, persistent_tick}, 0, 0.1);
  ASSERT_TRUE(bench.evaluate());
  ASSERT_EQ(bench.output.estimate.lineage.size(), 1u);
  EXPECT_TRUE(bench.output.estimate.lineage.sources()[0].persistent());
  EXPECT_NEAR(bench.output.estimate.lineage.standard_deviation(1), 0.7, 1e-15);
}

TEST(FunctionModule, GivesTheSameValueWithAndWithoutErrors) {
  Bench exact;
  ASSERT_TRUE(exact.evaluate());
  Bench uncertain;
  uncertain.add_errors();
  ASSERT_TRUE(uncertain.evaluate());
  EXPECT_EQ(exact.output.estimate.value, uncertain.output.estimate.value);
}

TEST(FunctionModule, ExactJacobianEqualsAutomaticDifferentiation) {
  RandomBits bits(3);
  const auto uniform = [](RandomBits& random) { return draw_uniform(random, 0.1, 3); };
  for (int i = 0; i < 100; ++i) {
    Bench bench;
    bench.parameters.value = {uniform(bits)};
    bench.pair.estimate.value = {uniform(bits), uniform(bits)};
    bench.single.estimate.value = {uniform(bits)};
    const auto automatic = FunctionModule(MixtureWithJacobian{}).differentiate(bench.evaluation());
    ASSERT_TRUE(automatic);
    Mixture::Parameters<double> p{bench.parameters.value[0]};
    const auto in = payload_of<Pair>(bench.pair.estimate);
    const auto s = payload_of<Single>(bench.single.estimate);
    std::array<double, 8> exact{};
    MixtureWithJacobian{}.jacobian(p, in, s, *MixtureWithJacobian{}(p, in, s), exact);
    for (std::size_t k = 0; k < 8; ++k) EXPECT_NEAR(exact[k], automatic->jacobian[k], 1e-14);
  }
}

TEST(FunctionModule, PassesLabelsThrough) {
  for (const bool with_errors : {false, true}) {
    Bench bench;
    bench.pair.estimate.labels = {1};
    if (with_errors) bench.add_errors();
    ASSERT_TRUE(bench.evaluate());
    EXPECT_EQ(bench.output.estimate.labels, std::vector<int>{1});
    ASSERT_TRUE(bench.evaluate<MixtureWithJacobian>());
    EXPECT_EQ(bench.output.estimate.labels, std::vector<int>{1});
  }
}

TEST(FunctionModule, TakesMissingLabelsForTheFirst) {
  Bench bench;
  bench.pair.estimate.labels.clear();
  ASSERT_TRUE(bench.evaluate());
  EXPECT_EQ(bench.output.estimate.labels, std::vector<int>{0});
}

TEST(FunctionModule, PassesTheFormulasFaultsOn) {
  for (const bool with_errors : {false, true}) {
    Bench bench;
    if (with_errors) bench.add_errors();
    bench.pair.estimate.value[1] = -1;
    const Outcome<> outcome = bench.evaluate();
    ASSERT_TRUE(outcome.is_fault());
    EXPECT_EQ(outcome.fault().kind, FaultKind::degenerate);
    EXPECT_EQ(outcome.fault().message, "b is -1");
    EXPECT_TRUE(bench.evaluate<MixtureWithJacobian>().is_fault());
  }
}

TEST(FunctionModule, LeavesTheOutputAloneWhenPending) {
  for (const bool with_errors : {false, true}) {
    Bench bench;
    ASSERT_TRUE(bench.evaluate());
    const Estimate before = bench.output.estimate;
    if (with_errors) bench.add_errors();
    bench.pair.estimate.value[1] = -2;
    EXPECT_TRUE(bench.evaluate().is_pending());
    EXPECT_TRUE(bench.evaluate<MixtureWithJacobian>().is_pending());
    EXPECT_TRUE(FunctionModule(Mixture{}).differentiate(bench.evaluation()).is_pending());
    EXPECT_EQ(bench.output.estimate.value, before.value);
    EXPECT_EQ(bench.output.estimate.lineage.size(), before.lineage.size());
  }
}

TEST(FunctionModule, LeavesExceptionsToItsCaller) {
  Bench bench;
  bench.pair.estimate.value[1] = -3;
  EXPECT_THROW((void)bench.evaluate(), std::runtime_error);
}

TEST(FunctionModule, FaultsWhereTheResultIsNotFinite) {
  for (const bool with_errors : {false, true}) {
    Bench bench;
    if (with_errors) bench.add_errors();
    bench.pair.estimate.value[1] = -4;
    const Outcome<> outcome = bench.evaluate();
    ASSERT_TRUE(outcome.is_fault());
    EXPECT_EQ(outcome.fault().kind, FaultKind::not_finite);
  }
  Bench bench;
  bench.single.estimate.value[0] = std::numeric_limits<double>::quiet_NaN();
  ASSERT_TRUE(bench.evaluate().is_fault());
}

TEST(FunctionModule, FaultsWhereADerivativeIsNotFinite) {
  Bench bench;
  bench.pair.estimate.value[1] = -5;  // the square root of 0
  EXPECT_TRUE(bench.evaluate());
  bench.add_errors();
  const Outcome<> outcome = bench.evaluate();
  ASSERT_TRUE(outcome.is_fault());
  EXPECT_EQ(outcome.fault().kind, FaultKind::not_finite);
  EXPECT_EQ(outcome.fault().message, "the formula has no finite derivative here");
}

TEST(FunctionModule, FaultsWhereTheErrorIsNotFinite) {
  Bench bench;
  bench.pair.estimate.value = {0.5, 1e200};
  bench.pair.estimate.lineage.add({0, 0, 0}, 0, 1e200);
  const Outcome<> outcome = bench.evaluate();
  ASSERT_TRUE(outcome.is_fault());
  EXPECT_EQ(outcome.fault().kind, FaultKind::not_finite);
  EXPECT_EQ(outcome.fault().message, "the result's error is not finite");
}

TEST(FunctionModule, SubtractingTwoBranchesOfOneSourceLeavesNoError) {
  Bench bench;
  bench.add_errors();
  Output left, right, difference;
  const Output* of_pair[] = {&bench.pair};
  const Evaluation branch{.parameters = bench.parameters, .inputs = of_pair};
  ASSERT_TRUE(FunctionModule(First{}).evaluate(branch, left));
  ASSERT_TRUE(FunctionModule(First{}).evaluate(branch, right));
  const Output* of_branches[] = {&left, &right};
  ASSERT_TRUE(FunctionModule(Difference{})
                  .evaluate({.parameters = bench.parameters, .inputs = of_branches}, difference));
  EXPECT_GT(left.estimate.lineage.variance(0), 0);
  EXPECT_EQ(difference.estimate.value[0], 0);
  EXPECT_EQ(difference.estimate.lineage.variance(0), 0);
}

TEST(FunctionModule, DoesNotAllocateInSteadyState) {
  Bench bench;
  bench.add_errors();
  bench.parameters.lineage.add({2, 0, persistent_tick}, 0, 0.1);
  FunctionModule<Mixture> automatic{Mixture{}};
  FunctionModule<MixtureWithJacobian> exact{MixtureWithJacobian{}};
  const Evaluation evaluation = bench.evaluation();
  ASSERT_TRUE(automatic.evaluate(evaluation, bench.output));
  const std::size_t before = allocation_count;
  for (int tick = 0; tick < 100; ++tick) {
    ASSERT_TRUE(automatic.evaluate(evaluation, bench.output));
    ASSERT_TRUE(exact.evaluate(evaluation, bench.output));
  }
  EXPECT_EQ(allocation_count, before);
}

TEST(Lineage, DoesNotAllocateInSteadyState) {
  RandomBits bits(1);
  const Eigen::MatrixXd jacobian =
      Eigen::MatrixXd::NullaryExpr(4, 4, [&] { return draw_normal(bits); });
  const Eigen::MatrixXd covariance = jacobian * jacobian.transpose();
  const Eigen::MatrixXd singular = jacobian.leftCols(2) * jacobian.leftCols(2).transpose();
  Lineage a(4);
  Lineage b(4);
  Lineage out(4);
  const auto tick = [&](std::int64_t t) {
    a.reset(4);
    b.reset(4);
    a.add_noise({0, 0, t}, covariance);
    a.add({2, 0, persistent_tick}, 1, 0.5);
    b.add_noise({1, 0, t}, singular);
    b.add({2, 0, persistent_tick}, 0, 0.5);
    const LineageTerm terms[] = {{jacobian.data(), &a}, {covariance.data(), &b}};
    compose(terms, 4, out);
    out.fold_together([t](const Source& s) { return s.tick == t; }, 1, 3);
    out.fold([](const Source&) { return true; }, 2);
  };
  tick(0);
  const std::size_t before = allocation_count;
  for (std::int64_t t = 1; t < 100; ++t) tick(t);
  EXPECT_EQ(allocation_count, before);
}

TEST(AllocationCount, Counts) {
  SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED();
  std::size_t before = allocation_count;
  const std::vector<int> some(100);
  EXPECT_GT(allocation_count, before) << some.size();
  before = allocation_count;
  const Eigen::VectorXd other(100);
  EXPECT_GT(allocation_count, before) << other.size();
}

/// Turned by `second` after `first`.
struct Turned {
  static constexpr std::string_view name = "turned", description = "one rotation after another";
  static constexpr std::array<std::string_view, 2> inputs = {"first", "second"};
  template <typename T>
  Outcome<test::Orientation<T>> operator()(const test::Orientation<T>& first,
                                           const test::Orientation<T>& second) const {
    const auto r =
        rotation_product<T>({first.rx, first.ry, first.rz}, {second.rx, second.ry, second.rz});
    return test::Orientation<T>{r[0], r[1], r[2]};
  }
};

TEST(FunctionModule, ErrorsOfRotationsAreThoseOfTheTangents) {
  // R(a) R(e_a) R(b) R(e_b) = R(a) R(b) R(R(b)ᵀ e_a) R(e_b)
  const PayloadDescriptor& type = descriptor<test::Orientation>();
  RandomBits random(5);
  for (int i = 0; i < 200; ++i) {
    Output first, second, output;
    for (Output* input : {&first, &second}) {
      input->estimate = Estimate(type);
      for (double& component : input->estimate.value) component = draw_uniform(random, -1.8, 1.8);
      normalize(type, input->estimate.value);
    }
    for (std::uint32_t c = 0; c < 3; ++c) {
      first.estimate.lineage.add({0, c, 0}, c, 1);
      second.estimate.lineage.add({1, c, 0}, c, 1);
    }
    output.estimate = Estimate(type);
    const Estimate none(no_parameters());
    const std::array<const Output*, 2> inputs{&first, &second};
    ASSERT_TRUE(
        FunctionModule<Turned>({}).evaluate({.parameters = none, .inputs = inputs}, output));
    const auto& b = second.estimate.value;
    const Eigen::MatrixXd factor = output.estimate.lineage.factor();
    EXPECT_LT((factor.leftCols(3) - rotation_matrix({-b[0], -b[1], -b[2]})).norm(), 1e-12);
    EXPECT_LT((factor.rightCols(3) - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace ilss
