// What modules have in common that a graph defines by formulas: the names and units of what goes in
// and comes out.
#pragma once

#include <string>
#include <vector>

#include "framework/estimate/dimension.h"
#include "framework/module/module_type.h"
#include "sensors/formula/formula_parser.h"

namespace ilss {

/// A name in a graph.
struct PlacedName {
  std::string text;
  Position position;
};

/// One component of the output; no dimension where its unit could not be read.
struct OutputComponent {
  PlacedName name;
  std::optional<Dimension> dimension;
  bool circular = false;
};

/// The keys `inputs`, `quantities` (their names), `payload`, `frame` and `output`.
struct FormulaInterface {
  std::vector<PlacedName> inputs = {};
  std::vector<PlacedName> quantities = {};
  std::vector<OutputComponent> outputs = {};
  std::string payload = {};  ///< the outputs' names, joined, unless the graph names it
  std::string frame = {};
  Position position = {};
};

/// The declarations of `inputs`, `payload` and `frame`.
std::vector<ParameterDeclaration> interface_declarations();

/// Reads `inputs`, `payload` and `frame`, and checks the names of the quantities.
FormulaInterface read_interface(const Node* module, Diagnostics& diagnostics, Position fallback);

/// Adds a component of the output, with its unit as written.
void add_output(FormulaInterface& interface, const Node& name, const Node* unit, bool circular,
                Diagnostics& diagnostics);

/// The module's interface before it is connected. Without settings, for documentation: any inputs.
Interface open_interface(const FormulaInterface* interface);

/// The output's payload; null where a unit could not be read.
const PayloadDescriptor* output_payload(const FormulaInterface& interface);

/// What formulas are over: every component of each input in order, then every quantity.
struct FormulaArguments {
  struct Argument {
    std::string name;  ///< "rows.y_l", "gain"
    std::string unit;  ///< SI
  };
  std::vector<Argument> list = {};
  std::vector<std::size_t> first = {};  ///< of each input, of the quantities, and the end
  ArgumentNames names = {};             ///< also an input's alone where it has one component
};
FormulaArguments make_arguments(const FormulaInterface& interface, const Connections& connections,
                                const Settings& settings);

/// Reports inputs and quantities of which no argument is `used`.
void report_unused(const FormulaInterface& interface, const FormulaArguments& arguments,
                   const std::function<bool(std::size_t)>& used, Diagnostics& diagnostics);

/// The inputs' components and the quantities, in order, over and over without allocation.
class ArgumentReader {
 public:
  explicit ArgumentReader(const FormulaArguments& arguments);

  /// Their values; valid until the next call.
  std::span<const double> values(const Evaluation& evaluation);
  /// Whether any of them has an error.
  static bool any_error(const Evaluation& evaluation);
  /// Whether one of them has an error.
  bool has_error(const Evaluation& evaluation, std::size_t argument) const;
  /// The lineage of results of the given Jacobian (rows x arguments, column-major).
  void propagate(const Evaluation& evaluation, std::span<const double> jacobian, std::size_t rows,
                 Lineage& lineage);

 private:
  const Estimate& group(const Evaluation& evaluation, std::size_t i) const;

  std::vector<std::size_t> first_;
  std::vector<double> values_;
  std::vector<LineageTerm> terms_;
  std::vector<Eigen::MatrixXd> in_tangent_;  ///< Jacobians by errors of rotations
};

/// Makes values and errors by components those of the estimate's payload: angles wrap, and errors
/// of rotations become local ones.
void settle_result(Estimate& estimate);

/// A fault where the estimate's values or errors are not finite.
Outcome<> check_finite(const Estimate& estimate);

}  // namespace ilss
