// Folding: it must be exact within a tick in any graph, and so must correlation.
#include "framework/graph/folding.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <map>

#include "framework/estimate/budget.h"
#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

using test::estimate_of;
using test::output_of;
using test::plan_of;

std::size_t draw(RandomBits& random, std::size_t below) { return random() % below; }

// --- post-dominators

/// A plan of nodes that only have inputs and outputs.
Plan random_shape(RandomBits& random) {
  Plan plan;
  const std::size_t n = 1 + draw(random, 12);
  plan.nodes.resize(n);
  for (std::size_t i = 1; i < n; ++i)
    for (std::size_t k = draw(random, 3); k > 0; --k)
      plan.nodes[i].inputs.push_back({draw(random, i), {}});
  for (std::size_t k = 1 + draw(random, 3); k > 0; --k) plan.outputs.push_back(draw(random, n));
  return plan;
}

/// Whether an end (an output, or a node that feeds nothing) can be reached from `from` around
/// `avoided`.
bool escapes(const Plan& plan, std::size_t from, std::size_t avoided) {
  if (from == avoided) return false;
  bool feeds = false;
  for (std::size_t i = from + 1; i < plan.nodes.size(); ++i)
    for (const PlanInput& input : plan.nodes[i].inputs)
      if (input.node == from) {
        feeds = true;
        if (escapes(plan, i, avoided)) return true;
      }
  return !feeds || std::find(plan.outputs.begin(), plan.outputs.end(), from) != plan.outputs.end();
}

TEST(PostDominators, AgreeWithEveryPathOfRandomGraphs) {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    SCOPED_TRACE(seed);
    RandomBits random(seed);
    const Plan plan = random_shape(random);
    const PostDominators dominators(plan);
    for (std::size_t n = 0; n < plan.nodes.size(); ++n)
      for (std::size_t m = 0; m < plan.nodes.size(); ++m)
        ASSERT_EQ(dominators.post_dominates(n, m), !escapes(plan, m, n)) << n << " over " << m;
  }
}

// --- covariances of random graphs against dense Jacobians

/// A node's value and its derivatives by every elementary error (columns), worked out by hand.
struct Dense {
  std::vector<double> value;
  Eigen::MatrixXd factor;
};

/// A random graph as text, and what must come of it. Its constants are two, shared by all gains.
class RandomGraph {
 public:
  static constexpr Eigen::Index most_errors = 64;

  explicit RandomGraph(std::uint64_t seed) : random_(seed) {
    constant(0, "k0", "{value: 1.5, std: 0.02}");
    constant(1, "k1", "{value: 0.7, std: 0.01}");
    for (std::size_t n = 1 + draw(random_, 3); n > 0; --n) add_reading();
    for (std::size_t n = draw(random_, 2); n > 0; --n) add_pair_reading();
    for (std::size_t n = 2 + draw(random_, 10); n > 0; --n) add_function();
    for (std::size_t n = 1 + draw(random_, 3); n > 0; --n)
      outputs_.push_back(draw(random_, nodes_.size()));
  }

  /// Nodes that no output follows from are left out: every module must be used.
  std::string text() const {
    std::string modules;
    std::string network;
    std::vector<char> used(nodes_.size(), 0);
    for (const std::size_t output : outputs_) used[output] = 1;
    for (std::size_t i = nodes_.size(); i-- > 0;)
      if (used[i])
        for (const std::size_t input : nodes_[i].inputs) used[input] = 1;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (!used[i]) continue;
      modules += "  " + name(i) + ": {" + nodes_[i].settings + "}\n";
      if (nodes_[i].inputs.empty()) continue;
      std::string feed;
      for (const std::size_t input : nodes_[i].inputs)
        feed += (feed.empty() ? "" : ", ") + name(input);
      network += "        - serial: [combine: [" + feed + "], " + name(i) + "]\n";
    }
    std::string ends;
    for (const std::size_t output : outputs_) ends += (ends.empty() ? "" : ", ") + name(output);
    return "constants:\n" + constants_ + "modules:\n" + modules + "network:\n  combine:\n" +
           network_of(network) + "    - combine: [" + ends + "]\n";
  }

  const std::vector<std::size_t>& outputs() const { return outputs_; }
  const Dense& dense(std::size_t node) const { return nodes_[node].dense; }
  /// Owner of each elementary error.
  const std::vector<std::string>& owners() const { return owners_; }

 private:
  struct GraphNode {
    std::string settings;
    std::vector<std::size_t> inputs;
    Dense dense;
  };

  static std::string name(std::size_t i) { return "n" + std::to_string(i); }
  static std::string network_of(const std::string& lines) {
    std::string result;
    std::size_t at = 0;
    while (at < lines.size()) {  // each line is a branch of the outer combine
      const std::size_t end = lines.find('\n', at) + 1;
      result += lines.substr(at + 4, end - at - 4);
      at = end;
    }
    return result;
  }
  Eigen::Index new_error(const std::string& owner) {
    owners_.push_back(owner);
    return static_cast<Eigen::Index>(owners_.size()) - 1;
  }
  void constant(std::size_t, const std::string& constant_name, const std::string& value) {
    constants_ += "  " + constant_name + ": " + value + "\n";
    new_error(constant_name);
  }
  double number(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  void add_reading() {
    const double value = number(0.5, 2);
    const double deviation = number(0.001, 0.01);
    const std::string own = name(nodes_.size());
    Dense dense{{value}, Eigen::MatrixXd::Zero(1, most_errors)};
    dense.factor(0, new_error(own)) = deviation;
    std::string settings =
        fmt_number("type: reading, value: ", value) + fmt_number(", value_std: ", deviation);
    if (draw(random_, 2) == 0) {
      dense.factor(0, new_error(own + ".bias")) = 0.003;
      settings += ", bias: {value: 0 mm, std: 3 mm}";
    }
    nodes_.push_back({settings, {}, dense});
  }
  void add_pair_reading() {
    const double a = number(0.5, 2);
    Dense dense{{a, 2.0}, Eigen::MatrixXd::Zero(2, most_errors)};
    const std::string own = name(nodes_.size());
    // Any factor of the same covariance serves.
    const Eigen::Matrix2d lower = Eigen::LLT<Eigen::Matrix2d>(test::PairReading::noise()).matrixL();
    for (Eigen::Index k = 0; k < 2; ++k) dense.factor.col(new_error(own)) = lower.col(k);
    nodes_.push_back({fmt_number("type: pair_reading, a: ", a), {}, dense});
  }
  static std::string fmt_number(const std::string& before, double x) {
    std::ostringstream text;
    text.precision(17);
    text << before << x << " m";
    return text.str();
  }
  std::size_t pick(std::size_t dimension) {
    for (;;) {
      const std::size_t i = draw(random_, nodes_.size());
      if (nodes_[i].dense.value.size() == dimension) return i;
    }
  }
  bool any_pair() const {
    return std::any_of(nodes_.begin(), nodes_.end(),
                       [](const GraphNode& n) { return n.dense.value.size() == 2; });
  }
  void add_function() {
    const std::size_t kind = draw(random_, any_pair() ? 8 : 6);
    if (kind >= 6) return add_pair_function(kind == 6);
    const std::size_t i = pick(1);
    const std::size_t j = pick(1);
    const Dense a = nodes_[i].dense;
    const Dense b = nodes_[j].dense;
    const double x = a.value[0];
    const double y = b.value[0];
    switch (kind) {
      case 0:
        return put("add", {i, j}, {x + y}, a.factor + b.factor);
      case 1:
        return put("subtract", {i, j}, {x - y}, a.factor - b.factor);
      case 2:
        return put("product", {i, j}, {x * y}, y * a.factor + x * b.factor);
      case 3:
        return put("sine", {i}, {std::sin(x)}, std::cos(x) * a.factor);
      case 4: {
        const bool first = draw(random_, 2) == 0;
        Eigen::MatrixXd factor = (first ? 1.5 : 0.7) * a.factor;
        factor(0, first ? 0 : 1) += x * (first ? 0.02 : 0.01);
        return put(first ? "gain, gain: $k0" : "gain, gain: $k1", {i}, {(first ? 1.5 : 0.7) * x},
                   factor);
      }
      default: {
        Eigen::MatrixXd factor(2, most_errors);
        factor << a.factor, b.factor;
        return put("join", {i, j}, {x, y}, factor);
      }
    }
  }
  void add_pair_function(bool mix) {
    const std::size_t i = pick(2);
    const std::size_t j = pick(2);
    const Dense p = nodes_[i].dense;
    const Dense q = nodes_[j].dense;
    if (!mix)
      return put("collapse", {i}, {p.value[0] + 0.5 * p.value[1]},
                 p.factor.row(0) + 0.5 * p.factor.row(1));
    Eigen::MatrixXd factor(2, most_errors);
    factor.row(0) = q.value[1] * p.factor.row(0) + p.value[0] * q.factor.row(1);
    factor.row(1) = p.factor.row(1) + std::cos(q.value[0]) * q.factor.row(0);
    put("mix", {i, j}, {p.value[0] * q.value[1], p.value[1] + std::sin(q.value[0])}, factor);
  }
  void put(const std::string& type, std::vector<std::size_t> inputs, std::vector<double> value,
           const Eigen::MatrixXd& factor) {
    nodes_.push_back({"type: " + type, std::move(inputs), {std::move(value), factor}});
  }

  RandomBits random_;
  std::vector<GraphNode> nodes_;
  std::vector<std::size_t> outputs_;
  std::vector<std::string> owners_;
  std::string constants_;
};

void expect_near(const Eigen::MatrixXd& got, const Eigen::MatrixXd& wanted, double size) {
  ASSERT_EQ(got.rows(), wanted.rows());
  ASSERT_EQ(got.cols(), wanted.cols());
  ASSERT_LE((got - wanted).cwiseAbs().maxCoeff(), 1e-9 * size) << got << "\nwanted\n" << wanted;
}

/// Relative to the size of the factors, for what cancels.
double size_of(const Dense& a, const Dense& b) { return a.factor.norm() * b.factor.norm() + 1e-30; }

std::map<std::string, Eigen::VectorXd> budget_by_name(const Plan& plan, const Lineage& lineage) {
  std::map<std::string, Eigen::VectorXd> result;
  for (const BudgetEntry& entry : budget(lineage))
    result[plan.owners.at(entry.owner).name] = Eigen::Map<const Eigen::VectorXd>(
        entry.variance.data(), static_cast<Eigen::Index>(entry.variance.size()));
  return result;
}

class FoldingOfRandomGraphs : public testing::TestWithParam<Folding> {};

TEST_P(FoldingOfRandomGraphs, GivesTheCovarianceOfADenseJacobian) {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const RandomGraph graph(seed);
    const Plan plan = plan_of(graph.text());
    System system(plan, 1, GetParam());
    system.evaluate(time_at(0));
    system.evaluate(time_at(1));
    // The graph's last combine names the outputs.
    const std::size_t before = plan.outputs.size() - graph.outputs().size();
    for (std::size_t a = 0; a < graph.outputs().size(); ++a) {
      const Dense& wanted = graph.dense(graph.outputs()[a]);
      const Estimate& got = output_of(system, before + a);
      for (std::size_t c = 0; c < wanted.value.size(); ++c)
        ASSERT_NEAR(got.value[c], wanted.value[c], 1e-12 * (1 + std::abs(wanted.value[c])));
      for (std::size_t b = 0; b < graph.outputs().size(); ++b) {
        const Dense& other = graph.dense(graph.outputs()[b]);
        expect_near(cross_covariance(got.lineage, output_of(system, before + b).lineage),
                    wanted.factor * other.factor.transpose(), size_of(wanted, other));
      }
      if (GetParam() == Folding::all) continue;
      auto shares = budget_by_name(plan, got.lineage);
      for (std::size_t e = 0; e < graph.owners().size(); ++e) {
        Eigen::VectorXd share = Eigen::VectorXd::Zero(wanted.factor.rows());
        for (std::size_t k = 0; k < graph.owners().size(); ++k)
          if (graph.owners()[k] == graph.owners()[e])
            share += wanted.factor.col(static_cast<Eigen::Index>(k)).cwiseAbs2();
        Eigen::VectorXd got_share = Eigen::VectorXd::Zero(share.size());
        if (shares.contains(graph.owners()[e])) got_share = shares[graph.owners()[e]];
        expect_near(got_share, share, size_of(wanted, wanted));
      }
    }
    if (HasFatalFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(Folding, FoldingOfRandomGraphs,
                         testing::Values(Folding::none, Folding::per_owner, Folding::all));

TEST(FoldingOfAChain, LeavesAtMostOneColumnAnOwnerForAScalar) {
  const Plan plan = plan_of(R"(
modules: {a: {type: pair_reading}, b: {type: pair_reading}, m: {type: mix}, c: {type: collapse}}
network: {serial: [combine: [a, b], m, c]}
)");
  System whole(plan, 1, Folding::none);
  System system(plan, 1, Folding::per_owner);
  System least(plan, 1, Folding::all);
  whole.evaluate(time_at(0));
  system.evaluate(time_at(0));
  least.evaluate(time_at(0));
  EXPECT_EQ(output_of(whole).lineage.size(), 4u);
  EXPECT_EQ(output_of(system).lineage.size(), 2u);
  EXPECT_EQ(output_of(least).lineage.size(), 1u);
}

// --- correlation

TEST(Diamond, DifferenceOfTheSameIsExactlyZero) {
  const Plan plan = plan_of(R"(
modules: {a: {type: reading, value_std: 1 mm, bias: {value: 1 m, std: 1 cm}}, up: {type: sine}, down: {type: sine}, s: {type: subtract}}
network: {serial: [a, combine: [up, down], s]}
)");
  for (const Folding folding : {Folding::none, Folding::per_owner, Folding::all}) {
    System system(plan, 1, folding);
    system.evaluate(time_at(0));
    EXPECT_GT(estimate_of(system, "up").lineage.variance(0), 0);
    EXPECT_EQ(output_of(system).value[0], 0.0);
    EXPECT_EQ(output_of(system).lineage.variance(0), 0.0);
  }
}

TEST(Diamond, HeldValueOfASlowBranchIsFromAnotherTick) {
  const Plan plan = plan_of(R"(
modules: {a: {type: reading, value_std: 1 mm, noise: normal}, b: {type: reading, value_std: 1 mm, noise: normal, period: 3}, s: {type: subtract}}
network: {serial: [combine: [a, b], s]}
)");
  System system(plan, 1);
  system.evaluate(time_at(0));
  const std::vector<Source> first(estimate_of(system, "b").lineage.sources().begin(),
                                  estimate_of(system, "b").lineage.sources().end());
  system.evaluate(time_at(1));
  EXPECT_EQ(estimate_of(system, "b").lineage.sources()[0], first[0]);
  EXPECT_NEAR(output_of(system).lineage.variance(0), 2e-6, 1e-15);
}

/// Two wall-like lines, each a range divided by what a shared, uncertain target height says.
constexpr const char* shared_target = R"(
constants: {height: {value: 1.2, std: 0.05}}
modules:
  left: {type: reading, value: 1 m, value_std: 2 cm, noise: normal}
  right: {type: reading, value: 1.4 m, value_std: 2 cm, noise: normal}
  left_line: {type: gain, gain: $height}
  right_line: {type: gain, gain: $height}
network: {combine: [{serial: [left, left_line]}, {serial: [right, right_line]}]}
)";

TEST(SharedConstant, CrossCovarianceAgreesWithMonteCarloAndIndependenceDoesNot) {
  constexpr std::uint64_t seed = 20;
  constexpr int count = 40000;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Plan plan = plan_of(shared_target);
  System expected(plan, seed);
  expected.expect();
  const double stated =
      cross_covariance(output_of(expected, 0).lineage, output_of(expected, 1).lineage)(0, 0);
  const double left = output_of(expected, 0).value[0];
  const double right = output_of(expected, 1).value[0];

  // Every tick draws another true height; the modules go on believing in their constant's value.
  System system(plan, seed);
  RandomBits random(seed);
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < count; ++i) {
    const double drawn = 1.2 + 0.05 * draw_normal(random);
    for (const char* line : {"left_line", "right_line"})
      plan.nodes[plan.find(line).value()].parameters.value[0] = drawn;
    system.evaluate(time_at(i));
    const double product =
        (output_of(system, 0).value[0] - left) * (output_of(system, 1).value[0] - right);
    sum += product;
    squares += product * product;
  }
  const double sampled = sum / count;
  const double deviation = std::sqrt((squares / count - sampled * sampled) / count);
  EXPECT_LT(std::abs(sampled - stated), 4 * deviation);
  const double independent = 0;
  EXPECT_GT(std::abs(sampled - independent), 50 * deviation);
}

TEST(MeanOfTicks, PersistentErrorStaysAndRandomErrorFallsAsTheRoot) {
  const Plan plan = plan_of(R"(
constants: {height: {value: 0 mm, std: 3 mm}}
modules: {a: {type: reading, value_std: 1 cm, noise: normal, bias: $height}, g: {type: gain, gain: 2}}
network: {serial: [a, g]}
)");
  for (const Folding folding : {Folding::none, Folding::per_owner, Folding::all}) {
    System system(plan, 7, folding);
    std::vector<Estimate> estimates;
    for (const std::size_t n : {10u, 100u, 1000u}) {
      while (estimates.size() < n) {
        system.evaluate(time_at(static_cast<double>(estimates.size())));
        estimates.push_back(output_of(system));
      }
      const std::vector<double> weights(n, 1.0 / static_cast<double>(n));
      const Estimate mean = linear_combination(estimates, weights);
      double random = 0;
      double persistent = 0;
      for (const BudgetEntry& entry : budget(mean.lineage))
        (entry.persistent ? persistent : random) += entry.variance[0];
      EXPECT_NEAR(std::sqrt(persistent), 0.006, 1e-12);
      EXPECT_NEAR(std::sqrt(random), 0.02 / std::sqrt(static_cast<double>(n)), 1e-12);
    }
  }
}

}  // namespace
}  // namespace ilss
