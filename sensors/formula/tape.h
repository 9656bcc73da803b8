// A tape: formulas as a list of elementary operations, evaluated and differentiated one by one.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ilss {

/// What a node of a tape does with the nodes before it.
enum class Operation : std::uint8_t {
  argument,
  constant,
  radian,  ///< the constant 1 rad: an angle, where other constants are pure numbers
  add,
  subtract,
  multiply,
  divide,
  power,
  negate,
  minimum,
  maximum,
  hypot,
  atan2,
  sqrt,
  exp,
  log,
  log10,
  sin,
  cos,
  tan,
  asin,
  acos,
  atan,
  sinh,
  cosh,
  tanh,
  abs,
};

bool has_two_operands(Operation operation);
/// Its name in a formula: "+", "sqrt".
std::string_view operation_name(Operation operation);

/// Several formulas over common arguments. Its nodes stand in order of evaluation: the arguments
/// first, then each formula's own, which end with its result unless that is an argument.
class Tape {
 public:
  using Index = std::uint32_t;
  struct Node {
    Operation operation;
    Index left = 0;       ///< of an argument: which
    Index right = 0;      ///< the left one again where there is but one operand
    double constant = 0;  ///< the value of a node that does not vary
    bool varies = false;  ///< whether it depends on an argument
  };
  struct Formula {
    Index first;  ///< its own nodes: [first, end)
    Index end;
    Index result;
  };

  explicit Tape(std::size_t arguments);

  Index add_constant(double value);
  Index add_radian();
  Index add(Operation operation, Index left, Index right);
  Index add(Operation operation, Index operand) { return add(operation, operand, operand); }
  /// Makes a formula of the nodes added since the last one.
  void end_formula(Index result);

  std::size_t arguments() const { return arguments_; }
  std::span<const Node> nodes() const { return nodes_; }
  std::span<const Formula> formulas() const { return formulas_; }
  /// Whether a formula depends on the argument.
  bool uses(std::size_t argument) const;

  /// A node of a formula that has no finite value, or no finite derivative by an operand.
  struct Trouble {
    std::size_t formula;
    Index node;
    bool derivative;
  };
  /// What an evaluation needs beside the tape; made once, so that it costs no allocation.
  struct Workspace {
    explicit Workspace(const Tape& tape);
    std::vector<double> value;     ///< of each node
    std::vector<double> by_left;   ///< derivative of each node by its left operand
    std::vector<double> by_right;  ///< and by its right one
    std::vector<double> adjoint;   ///< derivative of a formula's result by each node
    std::vector<char> reached;     ///< whether a formula's result depends on a node of its own
  };

  /// The formulas' values. Trouble: the first node whose value is not finite.
  std::optional<Trouble> evaluate(std::span<const double> arguments, std::span<double> results,
                                  Workspace& workspace) const;
  /// The values and the Jacobian (formulas x arguments, column-major): exact derivatives of each
  /// operation, joined by a sweep back from each result. Derivatives that are not finite are left
  /// as they are; see `derivative_trouble`.
  std::optional<Trouble> linearize(std::span<const double> arguments, std::span<double> results,
                                   std::span<double> jacobian, Workspace& workspace) const;
  /// Of a formula without a finite derivative, after `linearize`: the first node to blame.
  Trouble derivative_trouble(std::size_t formula, const Workspace& workspace) const;
  /// Of a formula that has no finite value whatever its arguments.
  std::optional<Trouble> constant_trouble(std::size_t formula) const;
  /// In words, after an evaluation: "it divides by zero".
  std::string explain(const Trouble& trouble, const Workspace& workspace) const;

 private:
  void sweep_back(const Formula& formula, Workspace& workspace) const;

  std::size_t arguments_;
  std::vector<Node> nodes_;
  std::vector<Formula> formulas_;
};

}  // namespace ilss
