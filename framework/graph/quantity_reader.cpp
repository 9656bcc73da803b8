#include "framework/graph/quantity_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <utility>
#include <vector>

#include "framework/estimate/units.h"
#include "framework/record/table.h"

namespace ilss {
namespace {

/// A std or half width in its value's unit.
std::optional<double> read_width(const Node& node, std::string_view name,
                                 const WrittenQuantity& quantity, Diagnostics& diagnostics) {
  if (!node.is_scalar()) {
    diagnostics.add(node.position, fmt::format("expected a {}, got {}", name, node.description()));
    return std::nullopt;
  }
  const auto split = split_quantity(node.text);
  if (const auto* error = std::get_if<std::string>(&split)) {
    diagnostics.add(node.position, *error);
    return std::nullopt;
  }
  const auto [number, unit] = std::get<QuantityText>(split);
  if (unit.empty() && number != 0 && !quantity.unit.empty()) {
    diagnostics.add(node.position,
                    fmt::format("{} '{}' has no unit; expected {}", name, node.text,
                                dimension_name(si_unit(quantity.unit).value_or(quantity.unit))));
    return std::nullopt;
  }
  double scale = 1;
  if (unit != quantity.unit && !(unit.empty() && number == 0)) {
    const auto conversion =
        unit_conversion(unit.empty() ? "1" : unit, quantity.unit.empty() ? "1" : quantity.unit);
    if (std::holds_alternative<std::string>(conversion)) {
      diagnostics.add(node.position,
                      fmt::format("{} '{}' does not fit its value in '{}'", name, node.text,
                                  quantity.unit.empty() ? "1" : quantity.unit));
      return std::nullopt;
    }
    scale = std::get<UnitConversion>(conversion).scale;
  }
  if (number < 0) {
    diagnostics.add(node.position,
                    fmt::format("a {} cannot be negative, got '{}'", name, node.text));
    return std::nullopt;
  }
  return number * scale;
}

/// A standard deviation of so many degrees of freedom counts as known.
constexpr double practically_infinite_degrees = 1e6;

/// Scales values to zero mean and unit variance, which were `deviation` before; tells what is wrong
/// with them, or nothing.
std::string standardize(std::vector<double>& samples, double& deviation) {
  constexpr std::size_t fewest = 10;
  if (samples.size() < fewest)
    return fmt::format("a distribution needs at least {} values, got {}", fewest, samples.size());
  const auto count = static_cast<double>(samples.size());
  const double mean = std::accumulate(samples.begin(), samples.end(), 0.0) / count;
  double squares = 0;
  for (double& x : samples) {
    x -= mean;
    squares += x * x;
  }
  deviation = std::sqrt(squares / count);
  const double size =
      std::accumulate(samples.begin(), samples.end(), std::abs(mean),
                      [](double most, double x) { return std::max(most, std::abs(x)); });
  constexpr double rounding = 1e-12;
  if (!(deviation > rounding * size) || !std::isfinite(deviation)) return "the values do not vary";
  for (double& x : samples) x /= deviation;
  return {};
}

/// The law of a file's column, whatever its mean and scale; `deviation` is the scale.
Distribution read_samples(const Node& node, double& deviation, Diagnostics& diagnostics) {
  Distribution result{Shape::empirical, 0, nullptr};
  const std::size_t errors = diagnostics.size();
  const Node* file = node.find("samples");
  const Node* column = node.find("column");
  for (const Node& key : node.keys)
    if (key.text != "samples" && key.text != "column")
      diagnostics.add(key.position,
                      fmt::format("samples have a file and a column, not '{}'{}", key.text,
                                  suggestion(key.text, {"samples", "column"})));
  if (file == nullptr || !file->is_scalar() || (column != nullptr && !column->is_scalar()))
    diagnostics.add(node.position, "expected {samples: FILE, column: NAME}");
  if (diagnostics.size() != errors) return result;
  std::filesystem::path directory =
      node.position.file != nullptr ? std::filesystem::path(*node.position.file).parent_path() : "";
  std::error_code no_directory;
  if (!std::filesystem::is_directory(directory, no_directory)) directory.clear();
  const std::filesystem::path path = directory / file->text;
  if (!std::filesystem::is_regular_file(path, no_directory)) {
    diagnostics.add(file->position, fmt::format("there is no file '{}'", path.string()));
    return result;
  }
  const Table table = read_table(path, diagnostics);
  if (diagnostics.size() != errors) return result;
  const auto index = column != nullptr           ? table.find(column->text)
                     : table.columns.size() == 1 ? std::optional<std::size_t>(0)
                                                 : std::nullopt;
  if (!index) {
    diagnostics.add(column != nullptr ? column->position : node.position,
                    column != nullptr ? fmt::format("there is no column '{}'{}", column->text,
                                                    suggestion(column->text, table.columns))
                                      : fmt::format("samples need a column: one of {}",
                                                    fmt::join(table.columns, ", ")));
    return result;
  }
  auto samples = std::make_shared<std::vector<double>>();
  for (const auto& row : table.rows) {
    const auto number = parse_quantity(row[*index].text, "1");
    if (const auto* error = std::get_if<std::string>(&number))
      diagnostics.add(row[*index].position, *error);
    else
      samples->push_back(std::get<double>(number));
  }
  if (diagnostics.size() != errors) return result;
  const std::string wrong = standardize(*samples, deviation);
  if (!wrong.empty()) diagnostics.add(file->position, wrong);
  result.samples = std::move(samples);
  return result;
}

/// The law of an error, and how well its standard deviation is known. Samples bring one, in the
/// value's unit, for where none is given.
void read_law(const Node& map, WrittenQuantity& quantity, Diagnostics& diagnostics) {
  const Node* law = map.find("distribution");
  const Node* degrees = map.find("degrees_of_freedom");
  if (degrees != nullptr) {
    const auto number = parse_quantity(degrees->text, "1");
    if (!degrees->is_scalar() || std::holds_alternative<std::string>(number) ||
        !(std::get<double>(number) >= 1))
      diagnostics.add(degrees->position, "expected degrees of freedom, a number from 1 up, got " +
                                             degrees->description());
    else if (std::get<double>(number) < practically_infinite_degrees)
      quantity.degrees_of_freedom = std::get<double>(number);
  }
  if (law == nullptr) return;
  if (law->is_map()) {
    double deviation = 0;
    quantity.distribution = read_samples(*law, deviation, diagnostics);
    if (quantity.distribution.samples != nullptr) quantity.standard_deviation = deviation;
    return;
  }
  static constexpr Shape named[] = {Shape::normal, Shape::uniform, Shape::triangular,
                                    Shape::arcsine, Shape::student_t};
  const auto* found = std::find_if(std::begin(named), std::end(named), [&](Shape shape) {
    return law->is_scalar() && law->text == shape_name(shape);
  });
  if (found == std::end(named)) {
    std::vector<std::string> names;
    for (const Shape shape : named) names.emplace_back(shape_name(shape));
    return diagnostics.add(
        law->position,
        fmt::format("expected one of {}, or {{samples: FILE}}, got {}{}", fmt::join(names, ", "),
                    law->description(), suggestion(law->text, names)));
  }
  quantity.distribution.shape = *found;
  if (*found != Shape::student_t) return;
  if (!(quantity.degrees_of_freedom > 2) || std::isinf(quantity.degrees_of_freedom))
    diagnostics.add(law->position,
                    "a t distribution needs degrees_of_freedom above 2, or it has no std");
  // They shape the law; its standard deviation is known all the same.
  quantity.distribution.degrees_of_freedom =
      std::exchange(quantity.degrees_of_freedom, std::numeric_limits<double>::infinity());
}

/// Reads what a quantity's map says of its error.
void read_error(const Node& map, WrittenQuantity& quantity, Diagnostics& diagnostics) {
  const Node* standard_deviation = map.find("std");
  const Node* half = map.find("half_width");
  const Node* width = standard_deviation != nullptr ? standard_deviation : half;
  read_law(map, quantity, diagnostics);
  if (width == nullptr && quantity.standard_deviation) return;
  if (width == nullptr) {
    for (const char* of_error : {"distribution", "degrees_of_freedom"})
      if (const Node* node = map.find(of_error))
        diagnostics.add(node->position,
                        fmt::format("a {} is that of an error; give its std, too", of_error));
    return;
  }
  if (standard_deviation != nullptr && half != nullptr)
    diagnostics.add(half->position, "give either a std or a half_width, not both");
  // 0 may stand without a unit; then the error says which.
  if (quantity.unit.empty() && quantity.number == 0 && width->is_scalar()) {
    const auto split = split_quantity(width->text);
    if (const auto* text = std::get_if<QuantityText>(&split)) quantity.unit = text->unit;
  }
  quantity.standard_deviation = read_width(
      *width, standard_deviation != nullptr ? "std" : "half_width", quantity, diagnostics);
  if (standard_deviation != nullptr || !quantity.standard_deviation) return;
  const double deviations = half_width(quantity.distribution.shape);
  if (deviations == 0)
    diagnostics.add(half->position,
                    "a half_width needs a distribution that has one: uniform, "
                    "triangular or arcsine");
  else
    *quantity.standard_deviation /= deviations;
}

}  // namespace

std::optional<WrittenQuantity> read_quantity(const Node& node, Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.size();
  const Node* value = &node;
  if (node.is_map()) {
    static const std::vector<std::string> known = {"value", "std", "half_width", "distribution",
                                                   "degrees_of_freedom"};
    value = node.find("value");
    for (const Node& key : node.keys)
      if (std::find(known.begin(), known.end(), key.text) == known.end())
        diagnostics.add(key.position, fmt::format("a quantity has value and std, not '{}'{}",
                                                  key.text, suggestion(key.text, known)));
    if (value == nullptr) diagnostics.add(node.position, "a quantity needs its value");
    if (diagnostics.size() != errors) return std::nullopt;
  }
  if (!value->is_scalar()) {
    diagnostics.add(value->position,
                    "expected a quantity such as '11 deg', or {value: ..., std: ...}, got " +
                        value->description());
    return std::nullopt;
  }
  const auto split = split_quantity(value->text);
  if (const auto* error = std::get_if<std::string>(&split)) {
    diagnostics.add(value->position, *error);
    return std::nullopt;
  }
  WrittenQuantity quantity;
  quantity.number = std::get<QuantityText>(split).number;
  quantity.unit = std::get<QuantityText>(split).unit;
  quantity.position = value->position;
  if (node.is_map()) read_error(node, quantity, diagnostics);
  if (diagnostics.size() != errors) return std::nullopt;
  return quantity;
}

std::optional<SiQuantity> to_si(const WrittenQuantity& quantity, std::string_view si_unit,
                                Diagnostics& diagnostics) {
  if (quantity.unit.empty() && si_unit != "1" &&
      (quantity.number != 0 || quantity.standard_deviation.value_or(0) != 0)) {
    const bool of_std = quantity.number == 0;
    diagnostics.add(quantity.position,
                    fmt::format("{}'{}' has no unit; expected {}", of_std ? "the std " : "",
                                of_std ? *quantity.standard_deviation : quantity.number,
                                dimension_name(si_unit)));
    return std::nullopt;
  }
  const auto conversion = quantity.unit.empty()
                              ? std::variant<UnitConversion, std::string>(UnitConversion{})
                              : unit_conversion(quantity.unit, si_unit);
  if (const auto* error = std::get_if<std::string>(&conversion)) {
    diagnostics.add(quantity.position, *error);
    return std::nullopt;
  }
  const auto [scale, offset] = std::get<UnitConversion>(conversion);
  const double value = scale * quantity.number + offset;
  const double deviation = scale * quantity.standard_deviation.value_or(0);
  if (!std::isfinite(value) || !std::isfinite(deviation * deviation)) {
    diagnostics.add(quantity.position, fmt::format("'{} {}' is too large, or its std is",
                                                   quantity.number, quantity.unit));
    return std::nullopt;
  }
  return SiQuantity{value, scale};
}

}  // namespace ilss
