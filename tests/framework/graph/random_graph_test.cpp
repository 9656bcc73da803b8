// Random graphs with shared ancestors: every covariance against a dense Jacobian by all sources,
// computed here without lineages, folding or automatic differentiation.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <map>

#include "framework/estimate/budget.h"
#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Eigen::Index most_sources = 160;
constexpr int pair_dimension = 2;

/// A node's value and its derivatives by every source of the graph; `size` is the same with every
/// term counted positive, which is what rounding is relative to.
struct Dense {
  VectorXd value;
  MatrixXd jacobian;
  MatrixXd size;

  explicit Dense(int dimension)
      : value(VectorXd::Zero(dimension)),
        jacobian(MatrixXd::Zero(dimension, most_sources)),
        size(MatrixXd::Zero(dimension, most_sources)) {}
  /// Row `i` += factor * row `j` of another node's.
  void chain(int i, double factor, const Dense& from, int j) {
    jacobian.row(i) += factor * from.jacobian.row(j);
    size.row(i) += std::abs(factor) * from.size.row(j);
  }
  void source(int i, Eigen::Index k, double sensitivity) {
    jacobian(i, k) += sensitivity;
    size(i, k) += std::abs(sensitivity);
  }
};

/// A graph that grows at random, as YAML and as dense Jacobians side by side.
class RandomGraph {
 public:
  explicit RandomGraph(std::uint64_t seed) : random_(seed) {
    const std::size_t constants = 1 + draw(3);
    for (std::size_t i = 0; i < constants; ++i) {
      const double deviation = uniform(0.001, 0.1);
      constants_.push_back({sources_++, deviation});
      constant_text_ += fmt::format("{}c{}: {{value: {} m, std: {} m}}", i == 0 ? "" : ", ", i,
                                    uniform(-1, 1), deviation);
    }
    const std::size_t modules = 5 + draw(56);
    while (nodes_.size() < modules) add_node();
  }

  std::string text() {
    wired_.assign(nodes_.size(), false);
    std::string outputs;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (!nodes_[i].feeds) {
        outputs_.push_back(i);
        outputs += (outputs.empty() ? "" : ", ") + expression(i);
      }
    std::string modules;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      modules += fmt::format("{}n{}: {{{}}}", i == 0 ? "" : ", ", i, nodes_[i].text);
    return fmt::format("constants: {{{}}}\nmodules: {{{}}}\nnetwork: {{combine: [{}]}}\n",
                       constant_text_, modules, outputs);
  }
  /// The outputs in the network's order.
  const std::vector<std::size_t>& outputs() const { return outputs_; }
  const Dense& dense(std::size_t node) const { return nodes_[node].dense; }

 private:
  struct Node {
    std::string text;
    Dense dense;
    std::vector<std::size_t> inputs;
    bool feeds = false;
  };
  struct Constant {
    Eigen::Index source;
    double deviation;
  };

  std::size_t draw(std::size_t below) { return random_() % below; }
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }

  std::string expression(std::size_t i) {
    if (wired_[i] || nodes_[i].inputs.empty()) return fmt::format("n{}", i);
    wired_[i] = true;
    std::string inputs;
    for (const std::size_t input : nodes_[i].inputs)
      inputs += (inputs.empty() ? "" : ", ") + expression(input);
    return fmt::format("{{serial: [{{combine: [{}]}}, n{}]}}", inputs, i);
  }

  /// A node of the dimension, a recent one more often than not, so that chains grow long.
  std::optional<std::size_t> pick(int dimension) {
    std::vector<std::size_t> fit;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (nodes_[i].dense.value.size() == dimension) fit.push_back(i);
    if (fit.empty()) return std::nullopt;
    const std::size_t back = std::min(draw(fit.size()), draw(fit.size()));
    return fit[fit.size() - 1 - back];
  }

  void add_node() {
    const std::size_t kind = nodes_.empty() ? 0 : draw(12);
    if (kind <= 1) return add_reading();
    if (kind == 2) return add_pair_reading();
    if (kind >= 9) return add_of_pairs(kind);
    add_of_scalars(kind);
  }

  void add_reading() {
    Dense dense(1);
    const double deviation = uniform(0.001, 0.1);
    dense.value[0] = uniform(-1, 1);
    dense.source(0, sources_++, deviation);
    std::string text =
        fmt::format("type: reading, value: {} m, value_std: {} m", dense.value[0], deviation);
    const std::size_t bias = draw(3);
    if (bias == 1) {  // a constant that others share
      const std::size_t c = draw(constants_.size());
      shared_values_.push_back(c);
      text += fmt::format(", bias: $c{}", c);
      dense.source(0, constants_[c].source, constants_[c].deviation);
    } else if (bias == 2) {
      text += ", bias: {value: 0.25 m, std: 0.02 m}";
      dense.value[0] += 0.25;
      dense.source(0, sources_++, 0.02);
    }
    if (bias == 1) dense.value[0] = std::nan("");  // known once the plan is read
    nodes_.push_back({std::move(text), std::move(dense), {}});
  }

  void add_pair_reading() {
    Dense dense(pair_dimension);
    dense.value << uniform(-1, 1), uniform(-1, 1);
    // A Cholesky factor of test::PairReading::noise.
    dense.source(0, sources_, 1e-3);
    dense.source(1, sources_, 1.2e-3);
    dense.source(1, sources_ + 1, 1.6e-3);
    sources_ += 2;
    nodes_.push_back(
        {fmt::format("type: pair_reading, a: {} m, b: {} m", dense.value[0], dense.value[1]),
         std::move(dense),
         {}});
  }

  void add_of_scalars(std::size_t kind) {
    const auto a = pick(1);
    const auto b = pick(1);
    if (!a || !b) return add_reading();
    static constexpr const char* names[] = {"",     "",     "",     "add",    "subtract",
                                            "sine", "gain", "join", "product"};
    Node node{fmt::format("type: {}", names[kind]), Dense(kind == 7 ? 2 : 1), {*a, *b}};
    if (kind == 5 || kind == 6) node.inputs.pop_back();
    if (kind == 6) {
      node.text += ", gain: {value: 0.75, std: 0.05}, offset: 0.5 m";
      gain_sources_[nodes_.size()] = sources_++;
    }
    keep(std::move(node));
  }

  void add_of_pairs(std::size_t kind) {
    const auto p = pick(2);
    const auto q = pick(2);
    if (!p || !q) return add_pair_reading();
    if (kind == 9)
      keep({"type: collapse", Dense(1), {*p}});
    else
      keep({"type: mix", Dense(2), {*p, *q}});
  }

  void keep(Node node) {
    for (const std::size_t input : node.inputs) nodes_[input].feeds = true;
    nodes_.push_back(std::move(node));
  }

 public:
  /// Computes values and Jacobians in order, given the constants' values.
  void evaluate(const std::vector<double>& constants) {
    std::size_t shared = 0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      Node& node = nodes_[i];
      if (node.inputs.empty()) {
        if (std::isnan(node.dense.value[0])) {
          const std::size_t at = node.text.find("value: ") + 7;
          node.dense.value[0] =
              std::stod(node.text.substr(at)) + constants[shared_values_[shared++]];
        }
        continue;
      }
      evaluate(i, node, nodes_[node.inputs.front()].dense, nodes_[node.inputs.back()].dense);
    }
  }

 private:
  void evaluate(std::size_t i, Node& node, const Dense& a, const Dense& b) {
    Dense& out = node.dense;
    const std::string type = node.text.substr(6, node.text.find(',') - 6);
    if (type == "add" || type == "subtract") {
      const double sign = type == "add" ? 1 : -1;
      out.value[0] = a.value[0] + sign * b.value[0];
      out.chain(0, 1, a, 0);
      out.chain(0, sign, b, 0);
    } else if (type == "product") {
      out.value[0] = a.value[0] * b.value[0];
      out.chain(0, b.value[0], a, 0);
      out.chain(0, a.value[0], b, 0);
    } else if (type == "sine") {
      out.value[0] = std::sin(a.value[0]);
      out.chain(0, std::cos(a.value[0]), a, 0);
    } else if (type == "gain") {
      out.value[0] = 0.75 * a.value[0] + 0.5;
      out.chain(0, 0.75, a, 0);
      out.source(0, gain_sources_.at(i), 0.05 * a.value[0]);
    } else if (type == "join") {
      out.value << a.value[0], b.value[0];
      out.chain(0, 1, a, 0);
      out.chain(1, 1, b, 0);
    } else if (type == "collapse") {
      out.value[0] = a.value[0] + a.value[1] / 2;
      out.chain(0, 1, a, 0);
      out.chain(0, 0.5, a, 1);
    } else {  // mix
      out.value << a.value[0] * b.value[1], a.value[1] + std::sin(b.value[0]);
      out.chain(0, b.value[1], a, 0);
      out.chain(0, a.value[0], b, 1);
      out.chain(1, 1, a, 1);
      out.chain(1, std::cos(b.value[0]), b, 0);
    }
  }

  RandomBits random_;
  Eigen::Index sources_ = 0;
  std::vector<Constant> constants_;
  std::string constant_text_;
  std::vector<Node> nodes_;
  std::map<std::size_t, Eigen::Index> gain_sources_;
  std::vector<std::size_t> shared_values_;
  std::vector<bool> wired_;
  std::vector<std::size_t> outputs_;
};

/// `actual` is `expected` but for 1e-9 of what it is made of.
void expect_close(const MatrixXd& actual, const MatrixXd& expected, const VectorXd& row_size,
                  const VectorXd& column_size) {
  constexpr double tolerance = 1e-9;
  for (Eigen::Index i = 0; i < actual.rows(); ++i)
    for (Eigen::Index j = 0; j < actual.cols(); ++j)
      ASSERT_LE(std::abs(actual(i, j) - expected(i, j)), tolerance * row_size[i] * column_size[j])
          << i << ", " << j << ": " << actual(i, j) << " for " << expected(i, j);
}

/// How many pairs of outputs have errors in common.
std::size_t compare(const RandomGraph& graph, const System& system) {
  std::size_t correlated = 0;
  for (std::size_t a = 0; a < graph.outputs().size(); ++a) {
    const Dense& first = graph.dense(graph.outputs()[a]);
    const Estimate& estimate = test::output_of(system, a);
    const VectorXd size = first.size.rowwise().norm();
    if (testing::Test::HasFatalFailure()) return correlated;
    expect_close(estimate.lineage.covariance(), first.jacobian * first.jacobian.transpose(), size,
                 size);
    for (std::size_t b = 0; b < a; ++b) {
      const Dense& second = graph.dense(graph.outputs()[b]);
      correlated += (first.jacobian * second.jacobian.transpose()).isZero(0) ? 0 : 1;
      expect_close(cross_covariance(estimate.lineage, test::output_of(system, b).lineage),
                   first.jacobian * second.jacobian.transpose(), size,
                   second.size.rowwise().norm());
    }
  }
  return correlated;
}

/// Shares of a budget add up to the variance.
void check_budgets(const System& system) {
  for (std::size_t o = 0; o < system.plan().outputs.size(); ++o) {
    const Lineage& lineage = test::output_of(system, o).lineage;
    for (std::size_t c = 0; c < lineage.dimension(); ++c) {
      double sum = 0;
      for (const BudgetEntry& entry : budget(lineage)) sum += entry.variance[c];
      ASSERT_NEAR(sum, lineage.variance(c), 1e-12 * lineage.variance(c));
    }
  }
}

TEST(RandomGraphs, HaveTheCovarianceOfADenseJacobianFoldedOrNot) {
  std::size_t largest = 0;
  std::size_t correlated = 0;
  for (std::uint64_t seed = 0; seed < 2500; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    RandomGraph graph(seed);
    const std::string text = graph.text();
    SCOPED_TRACE(text);
    const Plan plan = test::plan_of(text);
    largest = std::max(largest, plan.nodes.size());
    std::vector<double> constants;
    for (std::size_t at = text.find(": {value: "); at < text.find("\nmodules");
         at = text.find(": {value: ", at + 1))
      constants.push_back(std::stod(text.substr(at + 10)));
    graph.evaluate(constants);
    for (const Folding folding : {Folding::none, Folding::per_owner, Folding::all}) {
      System system(plan, 1, folding);
      system.evaluate(time_at(0));
      correlated += compare(graph, system);
      check_budgets(system);
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_EQ(largest, 60U);
  EXPECT_GT(correlated, 10'000U);  // or the cross-covariances were not tried
}

}  // namespace
}  // namespace ilss
