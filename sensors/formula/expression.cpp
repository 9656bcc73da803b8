#include "sensors/formula/expression.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "sensors/formula/formula_dimensions.h"
#include "sensors/formula/formula_interface.h"

namespace ilss {
namespace {

/// A formula as it stands in the graph.
struct FormulaText {
  std::string text;
  Position position;
  bool quoted;
};

/// What a graph says of an expression, and what becomes of it once it is connected.
struct ExpressionOptions {
  FormulaInterface interface = {};
  std::vector<FormulaText> formulas = {};  ///< of each output
  FormulaArguments arguments = {};
  Tape tape = Tape(0);
};

const ExpressionOptions& expression_options(const Settings& settings) {
  return *static_cast<const ExpressionOptions*>(settings.options.get());
}

std::vector<ParameterDeclaration> declare_expression() {
  using Kind = ParameterDeclaration::Kind;
  std::vector<ParameterDeclaration> declarations = interface_declarations();
  ParameterDeclaration unit;
  unit.name = "unit";
  unit.documentation = "what the formula gives; results are reported in the SI unit";
  unit.required = true;
  ParameterDeclaration formula;
  formula.name = "formula";
  formula.documentation = "over the inputs' components and the quantities, in SI units";
  formula.required = true;
  ParameterDeclaration circular;
  circular.name = "circular";
  circular.kind = Kind::boolean;
  circular.documentation = "an angle on the circle";
  circular.default_text = "false";
  ParameterDeclaration component;
  component.kind = Kind::group;
  component.children = {std::move(unit), std::move(formula), std::move(circular)};
  ParameterDeclaration output;
  output.name = "output";
  output.kind = Kind::map;
  output.documentation =
      "the output's components in order, each {unit, formula, circular: whether it is an angle on "
      "the circle}";
  output.required = true;
  output.children = {std::move(component)};
  declarations.push_back(std::move(output));
  return declarations;
}

bool read_circular(const Node& component, Diagnostics& diagnostics) {
  const Node* node = component.find("circular");
  if (node == nullptr || node->is_null()) return false;
  if (node->text != "true" && node->text != "false")
    diagnostics.add(node->position, "expected true or false, got " + node->description());
  return node->text == "true";
}

void read_component(const Node& name, const Node& component, ExpressionOptions& options,
                    Diagnostics& diagnostics) {
  if (!component.is_map())
    return diagnostics.add(component.is_null() ? name.position : component.position,
                           fmt::format("expected {{unit: ..., formula: ...}} of component '{}', "
                                       "got {}",
                                       name.text, component.description()));
  add_output(options.interface, name, component.find("unit"), read_circular(component, diagnostics),
             diagnostics);
  const Node* formula = component.find("formula");
  if (formula == nullptr || formula->is_null())
    diagnostics.add(name.position, fmt::format("component '{}' needs a formula", name.text));
  else if (!formula->is_scalar())
    diagnostics.add(formula->position, fmt::format("expected the formula of '{}', got {}",
                                                   name.text, formula->description()));
  const bool readable = formula != nullptr && formula->is_scalar();
  options.formulas.push_back(
      readable ? FormulaText{formula->text, formula->position, formula->quoted} : FormulaText{});
}

ExpressionOptions read_expression_options(const Node* module, Diagnostics& diagnostics,
                                          Position fallback) {
  ExpressionOptions options;
  options.interface = read_interface(module, diagnostics, fallback);
  const Node* output = module != nullptr ? module->find("output") : nullptr;
  if (output == nullptr || !output->is_map() || output->size() == 0) {
    diagnostics.add(output == nullptr || output->is_null() ? fallback : output->position,
                    "an expression needs its output: a map of components, each {unit: ..., "
                    "formula: ...}");
    return options;
  }
  for (std::size_t i = 0; i < output->size(); ++i)
    read_component(output->keys[i], output->values[i], options, diagnostics);
  return options;
}

/// Where a character of a formula stands. A formula that is folded over lines, or escapes
/// characters, is not in its file as it was read: then its beginning.
Position position_in(const FormulaText& formula, std::size_t offset) {
  Position position = formula.position;
  if (position.file == nullptr || formula.text.find('\n') != std::string::npos) return position;
  const int quote = formula.quoted ? 1 : 0;
  std::error_code no_file;
  if (std::filesystem::is_regular_file(*position.file, no_file)) {
    std::ifstream file(*position.file);
    std::string line;
    for (int i = 0; i < position.line; ++i) std::getline(file, line);
    const auto start = static_cast<std::size_t>(position.column) - 1 + (formula.quoted ? 1 : 0);
    if (start > line.size() || line.compare(start, formula.text.size(), formula.text) != 0)
      return position;
  }
  position.column += quote + static_cast<int>(offset);
  return position;
}

/// Reads all formulas onto the tape and checks their dimensions.
void compile(ExpressionOptions& options, Diagnostics& diagnostics) {
  std::vector<Dimension> dimensions;
  for (const auto& argument : options.arguments.list)
    dimensions.push_back(Dimension::of(argument.unit).value_or(Dimension()));
  options.tape = Tape(options.arguments.list.size());
  for (std::size_t i = 0; i < options.formulas.size(); ++i) {
    const FormulaText& formula = options.formulas[i];
    const OutputComponent& output = options.interface.outputs[i];
    Tape::Index result = 0;
    if (formula.position.line == 0) continue;  // there is none, which was said
    const auto errors = parse_formula(formula.text, options.arguments.names, options.tape, result);
    for (const FormulaError& error : errors)
      diagnostics.add(position_in(formula, error.offset),
                      fmt::format("formula of '{}': {}", output.name.text, error.message));
    if (!errors.empty()) continue;
    options.tape.end_formula(result);
    const std::size_t number = options.tape.formulas().size() - 1;
    if (const auto trouble = options.tape.constant_trouble(number))
      diagnostics.add(position_in(formula, 0),
                      fmt::format("formula of '{}' has no finite value: {}", output.name.text,
                                  options.tape.explain(*trouble, Tape::Workspace(options.tape))));
    for (const std::string& problem :
         check_dimensions(options.tape, number, dimensions, output.dimension))
      diagnostics.add(position_in(formula, 0),
                      fmt::format("formula of '{}' {}", output.name.text, problem));
  }
}

void resolve_expression(const Connections& connections, Settings& settings, Interface& interface) {
  auto options = std::make_shared<ExpressionOptions>(expression_options(settings));
  const std::size_t errors = connections.diagnostics->size();
  options->arguments = make_arguments(options->interface, connections, settings);
  compile(*options, *connections.diagnostics);
  if (connections.diagnostics->size() == errors)
    report_unused(
        options->interface, options->arguments,
        [&](std::size_t argument) { return options->tape.uses(argument); },
        *connections.diagnostics);
  if (const PayloadDescriptor* payload = output_payload(options->interface))
    interface.output = payload;
  settings.options = std::move(options);
}

class Expression final : public Module {
 public:
  explicit Expression(const ExpressionOptions& options)
      : tape_(options.tape),
        arguments_(options.arguments.list),
        reader_(options.arguments),
        workspace_(tape_),
        jacobian_(tape_.formulas().size() * tape_.arguments()) {
    for (const OutputComponent& output : options.interface.outputs)
      names_.push_back(output.name.text);
  }

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    Estimate& estimate = output.estimate;
    const std::size_t rows = tape_.formulas().size();
    const std::span<const double> values = reader_.values(evaluation);
    estimate.value.resize(rows);
    if (ArgumentReader::any_error(evaluation)) {
      if (const auto trouble = tape_.linearize(values, estimate.value, jacobian_, workspace_))
        return fault(*trouble);
      if (const auto trouble = settle_derivatives(evaluation)) return fault(*trouble);
      reader_.propagate(evaluation, jacobian_, rows, estimate.lineage);
    } else {
      if (const auto trouble = tape_.evaluate(values, estimate.value, workspace_))
        return fault(*trouble);
      estimate.lineage.reset(rows);
    }
    settle_result(estimate);
    return check_finite(estimate);
  }

 private:
  /// A derivative that is not finite matters only by an argument that has an error.
  std::optional<Tape::Trouble> settle_derivatives(const Evaluation& evaluation) {
    const std::size_t rows = tape_.formulas().size();
    for (std::size_t k = 0; k < jacobian_.size(); ++k) {
      if (std::isfinite(jacobian_[k])) [[likely]]
        continue;
      if (reader_.has_error(evaluation, k / rows))
        return tape_.derivative_trouble(k % rows, workspace_);
      jacobian_[k] = 0;
    }
    return std::nullopt;
  }

  /// "formula of 'y' has no finite value at x = 0 m: it divides by zero".
  Fault fault(const Tape::Trouble& trouble) const {
    const Tape::Formula& formula = tape_.formulas()[trouble.formula];
    constexpr std::size_t most = 8;
    std::vector<std::string> at;
    std::vector<char> seen(tape_.arguments(), 0);
    for (Tape::Index i = formula.first; i < formula.end; ++i)
      for (const Tape::Index operand : {tape_.nodes()[i].left, tape_.nodes()[i].right}) {
        const bool is_argument = tape_.nodes()[i].varies && operand < tape_.arguments();
        if (!is_argument || seen[operand] || at.size() == most) continue;
        seen[operand] = 1;
        const auto& [name, unit] = arguments_[operand];
        at.push_back(fmt::format("{} = {:.6g}{}", name, workspace_.value[operand],
                                 unit == "1" ? "" : " " + unit));
      }
    return {FaultKind::not_finite,
            fmt::format("formula of '{}' has no finite {}{}{}: {}", names_[trouble.formula],
                        trouble.derivative ? "derivative" : "value", at.empty() ? "" : " at ",
                        fmt::join(at, ", "), tape_.explain(trouble, workspace_))};
  }

  Tape tape_;
  std::vector<FormulaArguments::Argument> arguments_;
  std::vector<std::string> names_;
  ArgumentReader reader_;
  Tape::Workspace workspace_;
  std::vector<double> jacobian_;
};

}  // namespace

ModuleType expression_type() {
  ModuleType type;
  type.name = "expression";
  type.kind = ModuleKind::function;
  type.description = "formulas over the inputs' components and named quantities, as the graph says";
  type.parameters = &no_parameters();
  type.takes_quantities = true;
  type.checked = true;
  type.faults = {FaultKind::not_finite};
  type.options = declare_expression();
  type.interface = [](const Settings& settings) {
    return open_interface(settings.options == nullptr ? nullptr
                                                      : &expression_options(settings).interface);
  };
  type.read_options = [](const Node* map, const std::filesystem::path&, Diagnostics& diagnostics,
                         Position fallback) -> std::shared_ptr<const void> {
    return std::make_shared<const ExpressionOptions>(
        read_expression_options(map, diagnostics, fallback));
  };
  type.resolve = resolve_expression;
  type.create = [](const Settings& settings) {
    return std::make_unique<Expression>(expression_options(settings));
  };
  return type;
}

}  // namespace ilss
