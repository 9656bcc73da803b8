#include "sensors/formula/tape.h"

#include <ceres/jet.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace ilss {
namespace {

struct Words {
  std::string_view name;
  std::string_view action;  ///< "takes the square root of"
};

constexpr std::array<Words, 27> words = {{{"argument", ""},
                                          {"constant", ""},
                                          {"rad", ""},
                                          {"+", "adds"},
                                          {"-", "subtracts"},
                                          {"*", "multiplies"},
                                          {"/", "divides"},
                                          {"^", "raises to a power"},
                                          {"-", "negates"},
                                          {"min", "takes the smaller of"},
                                          {"max", "takes the larger of"},
                                          {"hypot", "takes the hypotenuse of"},
                                          {"atan2", "takes the direction of"},
                                          {"sqrt", "takes the square root of"},
                                          {"exp", "takes the exponential of"},
                                          {"log", "takes the logarithm of"},
                                          {"log10", "takes the logarithm of"},
                                          {"sin", "takes the sine of"},
                                          {"cos", "takes the cosine of"},
                                          {"tan", "takes the tangent of"},
                                          {"asin", "takes the arc sine of"},
                                          {"acos", "takes the arc cosine of"},
                                          {"atan", "takes the arc tangent of"},
                                          {"sinh", "takes the hyperbolic sine of"},
                                          {"cosh", "takes the hyperbolic cosine of"},
                                          {"tanh", "takes the hyperbolic tangent of"},
                                          {"abs", "takes the absolute value of"}}};
static_assert(words.size() == static_cast<std::size_t>(Operation::abs) + 1);

std::string_view action(Operation operation) {
  return words[static_cast<std::size_t>(operation)].action;
}

/// One operation over numbers or dual numbers; the right operand is ignored where there is one.
template <typename T>
[[gnu::always_inline]] inline T apply(Operation operation, const T& a, const T& b) {
  using std::abs, std::acos, std::asin, std::atan, std::atan2, std::cos, std::cosh, std::exp,
      std::hypot, std::log, std::log10, std::pow, std::sin, std::sinh, std::sqrt, std::tan,
      std::tanh;
  switch (operation) {
    case Operation::add:
      return a + b;
    case Operation::subtract:
      return a - b;
    case Operation::multiply:
      return a * b;
    case Operation::divide:
      return a / b;
    case Operation::power:
      return pow(a, b);
    case Operation::negate:
      return -a;
    case Operation::minimum:
      return b < a ? b : a;
    case Operation::maximum:
      return a < b ? b : a;
    case Operation::hypot:
      return hypot(a, b);
    case Operation::atan2:
      return atan2(a, b);
    case Operation::sqrt:
      return sqrt(a);
    case Operation::exp:
      return exp(a);
    case Operation::log:
      return log(a);
    case Operation::log10:
      return log10(a);
    case Operation::sin:
      return sin(a);
    case Operation::cos:
      return cos(a);
    case Operation::tan:
      return tan(a);
    case Operation::asin:
      return asin(a);
    case Operation::acos:
      return acos(a);
    case Operation::atan:
      return atan(a);
    case Operation::sinh:
      return sinh(a);
    case Operation::cosh:
      return cosh(a);
    case Operation::tanh:
      return tanh(a);
    case Operation::abs:
      return abs(a);
    case Operation::argument:
    case Operation::constant:
    case Operation::radian:
      break;
  }
  return a;
}

}  // namespace

bool has_two_operands(Operation operation) {
  return operation >= Operation::add && operation <= Operation::atan2 &&
         operation != Operation::negate;
}

std::string_view operation_name(Operation operation) {
  return words[static_cast<std::size_t>(operation)].name;
}

Tape::Tape(std::size_t arguments) : arguments_(arguments) {
  for (Index i = 0; i < arguments; ++i) nodes_.push_back({Operation::argument, i, i, 0, true});
}

Tape::Index Tape::add_constant(double value) {
  nodes_.push_back({.operation = Operation::constant, .constant = value});
  return static_cast<Index>(nodes_.size() - 1);
}

Tape::Index Tape::add_radian() {
  nodes_.push_back({.operation = Operation::radian, .constant = 1});
  return static_cast<Index>(nodes_.size() - 1);
}

Tape::Index Tape::add(Operation operation, Index left, Index right) {
  const bool varies = nodes_[left].varies || nodes_[right].varies;
  const double constant =
      varies ? 0 : apply(operation, nodes_[left].constant, nodes_[right].constant);
  nodes_.push_back({operation, left, right, constant, varies});
  return static_cast<Index>(nodes_.size() - 1);
}

void Tape::end_formula(Index result) {
  const Index first = formulas_.empty() ? static_cast<Index>(arguments_) : formulas_.back().end;
  formulas_.push_back({first, static_cast<Index>(nodes_.size()), result});
}

bool Tape::uses(std::size_t argument) const {
  return std::any_of(nodes_.begin() + static_cast<std::ptrdiff_t>(arguments_), nodes_.end(),
                     [&](const Node& node) {
                       return node.operation >= Operation::add &&
                              (node.left == argument || node.right == argument);
                     }) ||
         std::any_of(formulas_.begin(), formulas_.end(),
                     [&](const Formula& formula) { return formula.result == argument; });
}

std::optional<Tape::Trouble> Tape::constant_trouble(std::size_t formula) const {
  for (Index i = formulas_[formula].first; i < formulas_[formula].end; ++i)
    if (!nodes_[i].varies && !std::isfinite(nodes_[i].constant)) return Trouble{formula, i, false};
  return std::nullopt;
}

Tape::Workspace::Workspace(const Tape& tape)
    : value(tape.nodes_.size()),
      by_left(tape.nodes_.size()),
      by_right(tape.nodes_.size()),
      adjoint(tape.nodes_.size()),
      reached(tape.nodes_.size()) {
  for (std::size_t i = 0; i < value.size(); ++i) value[i] = tape.nodes_[i].constant;
}

std::optional<Tape::Trouble> Tape::evaluate(std::span<const double> arguments,
                                            std::span<double> results, Workspace& workspace) const {
  double* value = workspace.value.data();
  std::copy(arguments.begin(), arguments.end(), value);
  double zero = 0;  // NaN once anything is not finite
  for (std::size_t i = arguments_; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    if (!node.varies) continue;  // set already
    value[i] = apply(node.operation, value[node.left], value[node.right]);
    zero += 0 * value[i];
  }
  for (std::size_t f = 0; f < formulas_.size(); ++f) results[f] = value[formulas_[f].result];
  if (zero == 0) [[likely]]
    return std::nullopt;
  for (std::size_t f = 0; f < formulas_.size(); ++f)
    for (Index i = formulas_[f].first; i < formulas_[f].end; ++i)
      if (!std::isfinite(value[i])) return Trouble{f, i, false};
  return std::nullopt;
}

std::optional<Tape::Trouble> Tape::linearize(std::span<const double> arguments,
                                             std::span<double> results, std::span<double> jacobian,
                                             Workspace& workspace) const {
  if (const auto trouble = evaluate(arguments, results, workspace)) return trouble;
  using Dual = ceres::Jet<double, 2>;
  for (std::size_t i = arguments_; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    if (!node.varies) continue;
    // What does not vary has no derivative to be taken by, such as an exponent at a negative base.
    Dual a(workspace.value[node.left]);
    Dual b(workspace.value[node.right]);
    if (nodes_[node.left].varies) a.v[0] = 1;
    if (nodes_[node.right].varies) b.v[1] = 1;
    const Dual result = apply(node.operation, a, b);
    workspace.by_left[i] = result.v[0];
    workspace.by_right[i] = has_two_operands(node.operation) ? result.v[1] : 0;
  }
  for (std::size_t f = 0; f < formulas_.size(); ++f) {
    sweep_back(formulas_[f], workspace);
    for (std::size_t a = 0; a < arguments_; ++a)
      jacobian[a * formulas_.size() + f] = workspace.adjoint[a];
  }
  return std::nullopt;
}

void Tape::sweep_back(const Formula& formula, Workspace& workspace) const {
  double* adjoint = workspace.adjoint.data();
  std::fill_n(adjoint, arguments_, 0.0);
  std::fill(adjoint + formula.first, adjoint + formula.end, 0.0);
  char* reached = workspace.reached.data();
  std::fill(reached + formula.first, reached + formula.end, char{0});
  adjoint[formula.result] = 1;
  reached[formula.result] = 1;
  const auto propagate = [&](const Node& node, Index operand, double by_operand, double from) {
    // What a minimum or maximum did not choose takes no part, be its derivative as it may.
    const bool chooses =
        node.operation == Operation::minimum || node.operation == Operation::maximum;
    if (!nodes_[operand].varies || (chooses && by_operand == 0)) return;
    adjoint[operand] += from * by_operand;
    reached[operand] = 1;
  };
  for (Index i = formula.end; i-- > formula.first;) {
    const Node& node = nodes_[i];
    if (!node.varies || !reached[i]) continue;
    propagate(node, node.left, workspace.by_left[i], adjoint[i]);
    if (has_two_operands(node.operation))
      propagate(node, node.right, workspace.by_right[i], adjoint[i]);
  }
}

Tape::Trouble Tape::derivative_trouble(std::size_t formula, const Workspace& workspace) const {
  const auto [first, end, result] = formulas_[formula];
  for (Index i = first; i < end; ++i)
    if (nodes_[i].varies && workspace.reached[i] &&
        !(std::isfinite(workspace.by_left[i]) && std::isfinite(workspace.by_right[i])))
      return {formula, i, true};
  return {formula, result, true};  // finite ones, but their product is too large
}

std::string Tape::explain(const Trouble& trouble, const Workspace& workspace) const {
  const Node& node = nodes_[trouble.node];
  const double a = workspace.value[node.left];
  const double b = workspace.value[node.right];
  const double by_left = workspace.by_left[trouble.node];
  const double by_right = workspace.by_right[trouble.node];
  const bool overflows = trouble.derivative && std::isfinite(by_left) && std::isfinite(by_right);
  if (overflows || node.operation < Operation::add) return "it is too large for a number";
  if (node.operation == Operation::divide && b == 0) return "it divides by zero";
  if (node.operation == Operation::power && (a <= 0 || trouble.derivative))
    return fmt::format("it raises {:.6g} to the power {:.6g}", a, b);
  const bool undefined =
      trouble.derivative ||
      (node.operation >= Operation::sqrt && std::isnan(workspace.value[trouble.node])) ||
      (node.operation == Operation::log && a == 0) ||
      (node.operation == Operation::log10 && a == 0);
  if (!undefined) return "it is too large for a number";
  if (has_two_operands(node.operation))
    return fmt::format("it {} {:.6g} and {:.6g}", action(node.operation), a, b);
  return fmt::format("it {} {:.6g}", action(node.operation), a);
}

}  // namespace ilss
