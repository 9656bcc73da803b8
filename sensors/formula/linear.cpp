#include "sensors/formula/linear.h"

#include <fmt/format.h>

#include "framework/estimate/decompositions.h"
#include "framework/estimate/units.h"
#include "sensors/formula/formula_interface.h"

namespace ilss {
namespace {

/// A list of numbers or of such lists as it stands in the graph.
struct WrittenMatrix {
  bool given = false;
  Eigen::MatrixXd numbers = {};
  Position position = {};
};

/// What a graph says of a linear map, and the map once it is connected.
struct LinearOptions {
  FormulaInterface interface = {};
  WrittenMatrix matrix = {};
  WrittenMatrix design = {};
  Eigen::VectorXd offset = {};  ///< of each output
  FormulaArguments arguments = {};
  Eigen::MatrixXd map = {};  ///< outputs x arguments
};

const LinearOptions& linear_options(const Settings& settings) {
  return *static_cast<const LinearOptions*>(settings.options.get());
}

std::vector<ParameterDeclaration> declare_linear() {
  using Kind = ParameterDeclaration::Kind;
  std::vector<ParameterDeclaration> declarations = interface_declarations();
  ParameterDeclaration number;
  number.kind = Kind::number;
  const auto add = [&](std::string name, std::string documentation, ParameterDeclaration element,
                       Kind kind) {
    ParameterDeclaration d;
    d.name = std::move(name);
    d.kind = kind;
    d.documentation = std::move(documentation);
    d.children = {std::move(element)};
    declarations.push_back(std::move(d));
  };
  ParameterDeclaration row;
  row.kind = Kind::list;
  row.children = {number};
  add("matrix", "a row for each output, a number for each x; in SI units", row, Kind::list);
  add("design", "instead: a row for each x, a number for each output; solved by least squares", row,
      Kind::list);
  add("offset", "added to the outputs, a number for each, in SI units; default 0", number,
      Kind::list);
  add("output", "the output's components in order, each with its unit", ParameterDeclaration{},
      Kind::map);
  declarations.back().required = true;
  return declarations;
}

std::optional<double> read_number(const Node& node, Diagnostics& diagnostics) {
  if (node.is_scalar()) {
    const auto number = parse_quantity(node.text, "1");
    if (const auto* value = std::get_if<double>(&number)) return *value;
  }
  diagnostics.add(node.position, "expected a number, in SI units, got " + node.description());
  return std::nullopt;
}

/// Rows of equal length, or one row where `flat`; empty where anything is wrong.
WrittenMatrix read_matrix(const Node* module, std::string_view key, bool flat,
                          Diagnostics& diagnostics) {
  const Node* node = module != nullptr ? module->find(key) : nullptr;
  WrittenMatrix result;
  if (node == nullptr || node->is_null()) return result;
  const std::size_t errors = diagnostics.size();
  result.given = true;
  result.position = node->position;
  const std::vector<Node> rows = flat ? std::vector<Node>{*node} : node->values;
  std::vector<double> numbers;
  for (const Node& row : rows) {
    if (!row.is_list() || row.size() == 0 || row.size() != rows.front().size())
      diagnostics.add(row.position, fmt::format("expected a list of {} numbers, got {}",
                                                std::max<std::size_t>(1, rows.front().size()),
                                                row.is_list() ? fmt::format("{}", row.size())
                                                              : row.description()));
    for (const Node& element : row.values)
      numbers.push_back(read_number(element, diagnostics).value_or(0));
  }
  if (rows.empty())
    diagnostics.add(node->position, "expected a list of rows, got " + node->description());
  if (diagnostics.size() != errors) return result;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  result.numbers =
      Eigen::Map<const RowMajor>(numbers.data(), static_cast<Eigen::Index>(rows.size()),
                                 static_cast<Eigen::Index>(rows.front().size()));
  return result;
}

LinearOptions read_linear_options(const Node* module, Diagnostics& diagnostics, Position fallback) {
  LinearOptions options;
  options.interface = read_interface(module, diagnostics, fallback);
  const Node* output = module != nullptr ? module->find("output") : nullptr;
  if (output == nullptr || !output->is_map() || output->size() == 0)
    diagnostics.add(output == nullptr || output->is_null() ? fallback : output->position,
                    "a linear map needs its output: a map of components to their units");
  else
    for (std::size_t i = 0; i < output->size(); ++i)
      add_output(options.interface, output->keys[i], &output->values[i], false, diagnostics);
  options.matrix = read_matrix(module, "matrix", false, diagnostics);
  options.design = read_matrix(module, "design", false, diagnostics);
  if (options.matrix.given == options.design.given)
    diagnostics.add(options.design.given ? options.design.position : fallback,
                    "a linear map needs either a matrix or a design");
  const WrittenMatrix offset = read_matrix(module, "offset", true, diagnostics);
  const auto outputs = static_cast<Eigen::Index>(options.interface.outputs.size());
  options.offset = Eigen::VectorXd::Zero(outputs);
  if (offset.numbers.size() == outputs)
    options.offset = offset.numbers.row(0);
  else if (offset.numbers.size() != 0)
    diagnostics.add(offset.position, fmt::format("expected {} numbers, one for each output, got {}",
                                                 outputs, offset.numbers.size()));
  return options;
}

/// "expected 2 rows (outputs) of 3 numbers (rows.y_l, rows.y_c, rows.y_r)".
bool has_size(const WrittenMatrix& matrix, Eigen::Index rows, Eigen::Index columns,
              std::string_view row_meaning, std::string_view column_meaning,
              Diagnostics& diagnostics) {
  if (matrix.numbers.size() == 0) return false;  // which was said
  if (matrix.numbers.rows() == rows && matrix.numbers.cols() == columns) return true;
  diagnostics.add(
      matrix.position,
      fmt::format("expected {} row{} of {} number{}, got {} of {}; rows are {}, columns "
                  "{}",
                  rows, rows == 1 ? "" : "s", columns, columns == 1 ? "" : "s",
                  matrix.numbers.rows(), matrix.numbers.cols(), row_meaning, column_meaning));
  return false;
}

void make_map(LinearOptions& options, Diagnostics& diagnostics) {
  const auto outputs = static_cast<Eigen::Index>(options.interface.outputs.size());
  const auto arguments = static_cast<Eigen::Index>(options.arguments.list.size());
  std::vector<std::string> names;
  for (const auto& argument : options.arguments.list) names.push_back(argument.name);
  const std::string x = fmt::format("{}", fmt::join(names, ", "));
  names.clear();
  for (const auto& output : options.interface.outputs) names.push_back(output.name.text);
  const std::string y = fmt::format("{}", fmt::join(names, ", "));
  if (has_size(options.matrix, outputs, arguments, y, x, diagnostics))
    options.map = options.matrix.numbers;
  if (options.matrix.given || !has_size(options.design, arguments, outputs, x, y, diagnostics))
    return;
  // Columns of equal length first, so that their units do not decide what counts as dependent.
  const Eigen::VectorXd length = options.design.numbers.colwise().stableNorm().transpose();
  const Eigen::VectorXd scale =
      length.unaryExpr([](double norm) { return norm > 0 ? 1 / norm : 1.0; });
  const PivotedQr qr = pivoted_qr(options.design.numbers * scale.asDiagonal());
  if (arguments < outputs || qr.rank() < outputs)
    return diagnostics.add(
        options.design.position,
        fmt::format("the design does not determine {}: {} rows of rank {}; it needs rank {}", y,
                    arguments, qr.rank(), outputs));
  options.map = scale.asDiagonal() * solve(qr, Eigen::MatrixXd::Identity(arguments, arguments));
}

void resolve_linear(const Connections& connections, Settings& settings, Interface& interface) {
  auto options = std::make_shared<LinearOptions>(linear_options(settings));
  options->arguments = make_arguments(options->interface, connections, settings);
  make_map(*options, *connections.diagnostics);
  if (options->map.size() != 0)
    report_unused(
        options->interface, options->arguments,
        [&](std::size_t argument) {
          return !options->map.col(static_cast<Eigen::Index>(argument)).isZero(0);
        },
        *connections.diagnostics);
  if (const PayloadDescriptor* payload = output_payload(options->interface))
    interface.output = payload;
  settings.options = std::move(options);
}

class Linear final : public Module {
 public:
  explicit Linear(const LinearOptions& options)
      : map_(options.map), offset_(options.offset), reader_(options.arguments) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    Estimate& estimate = output.estimate;
    const auto rows = static_cast<std::size_t>(map_.rows());
    const std::span<const double> values = reader_.values(evaluation);
    estimate.value.resize(rows);
    Eigen::Map<Eigen::VectorXd> result(estimate.value.data(), map_.rows());
    result = offset_;
    result.noalias() += map_ * Eigen::Map<const Eigen::VectorXd>(values.data(), map_.cols());
    reader_.propagate(evaluation, {map_.data(), static_cast<std::size_t>(map_.size())}, rows,
                      estimate.lineage);
    settle_result(estimate);
    return check_finite(estimate);
  }

 private:
  Eigen::MatrixXd map_;
  Eigen::VectorXd offset_;
  ArgumentReader reader_;
};

}  // namespace

ModuleType linear_type() {
  ModuleType type;
  type.name = "linear";
  type.kind = ModuleKind::function;
  type.description = "a matrix times the inputs' components and named quantities, or least squares";
  type.parameters = &no_parameters();
  type.takes_quantities = true;
  type.checked = true;
  type.faults = {FaultKind::not_finite};
  type.options = declare_linear();
  type.interface = [](const Settings& settings) {
    return open_interface(settings.options == nullptr ? nullptr
                                                      : &linear_options(settings).interface);
  };
  type.read_options = [](const Node* map, const std::filesystem::path&, Diagnostics& diagnostics,
                         Position fallback) -> std::shared_ptr<const void> {
    return std::make_shared<const LinearOptions>(read_linear_options(map, diagnostics, fallback));
  };
  type.resolve = resolve_linear;
  type.create = [](const Settings& settings) {
    return std::make_unique<Linear>(linear_options(settings));
  };
  return type;
}

}  // namespace ilss
