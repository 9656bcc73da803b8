#include "framework/graph/value_reader.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "framework/estimate/units.h"
#include "framework/graph/recording.h"

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

/// Scales values to zero mean and unit variance; tells what is wrong with them, or nothing.
std::string standardize(std::vector<double>& samples) {
  constexpr std::size_t fewest = 10;
  if (samples.size() < fewest)
    return fmt::format("{} values are too few for a distribution; expected at least {}",
                       samples.size(), fewest);
  const auto count = static_cast<double>(samples.size());
  const double mean = std::accumulate(samples.begin(), samples.end(), 0.0) / count;
  double squares = 0;
  for (double& x : samples) {
    x -= mean;
    squares += x * x;
  }
  const double deviation = std::sqrt(squares / count);
  if (!(deviation > 0) || !std::isfinite(deviation)) return "the values do not vary";
  for (double& x : samples) x /= deviation;
  return {};
}

/// The law of a file's column, whatever its mean and scale.
Distribution read_samples(const Node& node, Diagnostics& diagnostics) {
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
  const Recording recording = read_recording(directory / file->text, diagnostics);
  if (diagnostics.size() != errors) return result;
  const auto index = column != nullptr               ? recording.find(column->text)
                     : recording.columns.size() == 1 ? std::optional<std::size_t>(0)
                                                     : std::nullopt;
  if (!index) {
    diagnostics.add(
        column != nullptr ? column->position : node.position,
        fmt::format("expected one of the columns {}", fmt::join(recording.columns, ", ")));
    return result;
  }
  auto samples = std::make_shared<std::vector<double>>();
  for (const auto& row : recording.rows) {
    const auto number = parse_quantity(row[*index].text, "1");
    if (const auto* error = std::get_if<std::string>(&number))
      diagnostics.add(row[*index].position, *error);
    else
      samples->push_back(std::get<double>(number));
  }
  if (diagnostics.size() != errors) return result;
  const std::string wrong = standardize(*samples);
  if (!wrong.empty()) diagnostics.add(file->position, wrong);
  result.samples = std::move(samples);
  return result;
}

/// The law of an error, and how well its standard deviation is known.
void read_law(const Node& map, WrittenQuantity& quantity, Diagnostics& diagnostics) {
  const Node* law = map.find("distribution");
  const Node* degrees = map.find("degrees_of_freedom");
  if (degrees != nullptr) {
    const auto number = parse_quantity(degrees->text, "1");
    if (!degrees->is_scalar() || std::holds_alternative<std::string>(number) ||
        !(std::get<double>(number) > 0))
      diagnostics.add(degrees->position, "expected degrees of freedom, a number above 0, got " +
                                             degrees->description());
    else
      quantity.degrees_of_freedom = std::get<double>(number);
  }
  if (law == nullptr) return;
  if (law->is_map()) {
    quantity.distribution = read_samples(*law, diagnostics);
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
  quantity.distribution.degrees_of_freedom = quantity.degrees_of_freedom;
}

/// Reads what a quantity's map says of its error.
void read_error(const Node& map, WrittenQuantity& quantity, Diagnostics& diagnostics) {
  const Node* standard_deviation = map.find("std");
  const Node* half = map.find("half_width");
  const Node* width = standard_deviation != nullptr ? standard_deviation : half;
  read_law(map, quantity, diagnostics);
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

std::optional<int> read_label(const Node& value, const Label& label, Diagnostics& diagnostics) {
  for (std::size_t i = 0; i < label.values.size(); ++i)
    if (value.is_scalar() && value.text == label.values[i]) return static_cast<int>(i);
  diagnostics.add(value.position, fmt::format("expected one of {}, got {}",
                                              fmt::join(label.values, ", "), value.description()));
  return std::nullopt;
}

std::optional<std::vector<WrittenQuantity>> read_components(const Node& map,
                                                            const PayloadDescriptor& payload,
                                                            Estimate& estimate, LeftOut left_out,
                                                            Diagnostics& diagnostics) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  const std::size_t errors = diagnostics.size();
  std::vector<WrittenQuantity> written(payload.dimension());
  std::vector<char> given(payload.dimension(), 0);
  std::vector<std::string> names;
  for (const Component& component : payload.components) names.push_back(component.name);
  for (const Label& label : payload.labels) names.push_back(label.name);
  for (std::size_t k = 0; k < map.size(); ++k) {
    const Node& key = map.keys[k];
    if (const auto i = payload.find(key.text)) {
      given[*i] = 1;
      if (auto quantity = read_quantity(map.values[k], diagnostics)) written[*i] = *quantity;
      continue;
    }
    bool is_label = false;
    for (std::size_t l = 0; l < payload.labels.size(); ++l) {
      if (payload.labels[l].name != key.text) continue;
      is_label = true;
      if (const auto index = read_label(map.values[k], payload.labels[l], diagnostics))
        estimate.labels[l] = *index;
    }
    if (!is_label)
      diagnostics.add(key.position, fmt::format("{} has no component '{}'{}", payload.name,
                                                key.text, suggestion(key.text, names)));
  }
  for (std::size_t i = 0; i < payload.dimension(); ++i) {
    if (given[i]) continue;
    const Component& component = payload.components[i];
    if (component.default_value)
      written[i] = {
          .number = left_out == LeftOut::take_default ? *component.default_value : unknown,
          .unit = component.unit,
          .position = map.position};
    else
      diagnostics.add(map.position, fmt::format("{} needs its component '{}', {}", payload.name,
                                                component.name, dimension_name(component.unit)));
  }
  if (diagnostics.size() != errors) return std::nullopt;
  return written;
}

/// Beside a component that has a std, one without would count as exact by oversight.
void check_all_have_std(const std::vector<WrittenQuantity>& written,
                        const PayloadDescriptor& payload, Diagnostics& diagnostics) {
  for (std::size_t i = 0; i < written.size(); ++i)
    if (!written[i].standard_deviation && !std::isnan(written[i].number))
      diagnostics.add(written[i].position,
                      fmt::format("'{}' has no std beside components that have one; give it, 0 if "
                                  "exact",
                                  payload.components[i].name));
}

/// A zero without a unit gives its variance none.
void check_variance_units(const std::vector<WrittenQuantity>& written,
                          const PayloadDescriptor& payload, const Eigen::MatrixXd& covariance,
                          Diagnostics& diagnostics) {
  for (std::size_t i = 0; i < written.size(); ++i)
    if (written[i].unit.empty() && payload.components[i].unit != "1" &&
        covariance.row(static_cast<Eigen::Index>(i)).cwiseAbs().maxCoeff() > 0)
      diagnostics.add(written[i].position,
                      fmt::format("'0' has no unit, and so its variance has none; expected {}",
                                  dimension_name(payload.components[i].unit)));
}

void check_one_form(const Node& map, Diagnostics& diagnostics) {
  for (const Node& key : map.keys)
    if (key.text != "value" && key.text != "covariance")
      diagnostics.add(key.position,
                      fmt::format("expected value and covariance, got '{}'", key.text));
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

std::optional<Eigen::MatrixXd> read_covariance(const Node& node, std::size_t dimension,
                                               Diagnostics& diagnostics) {
  const auto complain = [&](const Node& where, std::string message) {
    diagnostics.add(where.position, std::move(message));
    return std::nullopt;
  };
  const auto n = static_cast<Eigen::Index>(dimension);
  if (!node.is_list() || node.size() != dimension)
    return complain(node, fmt::format("expected a covariance of {0} rows of {0} numbers", n));
  Eigen::MatrixXd covariance(n, n);
  for (std::size_t i = 0; i < dimension; ++i) {
    const Node& row = node.values[i];
    if (!row.is_list() || row.size() != dimension)
      return complain(row, fmt::format("expected a row of {} numbers", n));
    for (std::size_t j = 0; j < dimension; ++j) {
      const auto number = parse_quantity(row.values[j].text, "1");
      if (!row.values[j].is_scalar() || std::holds_alternative<std::string>(number))
        return complain(row.values[j],
                        "expected a number in the product of the values' units, got " +
                            row.values[j].description());
      covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          std::get<double>(number);
    }
  }
  if (n == 0) return covariance;
  // Judged as a correlation, so that components of different units count alike.
  constexpr double rounding = 1e-9;
  const Eigen::VectorXd scale = covariance.diagonal().unaryExpr(
      [](double variance) { return variance > 0 ? 1 / std::sqrt(variance) : 1.0; });
  const Eigen::MatrixXd correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  for (Eigen::Index i = 0; i < n; ++i)
    if (!(covariance(i, i) >= 0) ||
        (covariance(i, i) == 0 && covariance.row(i).cwiseAbs().maxCoeff() > 0))
      return complain(node, "a covariance must be positive semidefinite");
  if (!((correlation - correlation.transpose()).cwiseAbs().maxCoeff() <= rounding))
    return complain(node, "a covariance must be symmetric");
  if (!(correlation.cwiseAbs().maxCoeff() <= 1 + rounding))
    return complain(node, "a covariance must be positive semidefinite");
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  if (!(eigen.eigenvalues().minCoeff() >= -rounding))
    return complain(node, "a covariance must be positive semidefinite");
  return (covariance + covariance.transpose()) / 2;
}

std::optional<GivenEstimate> read_estimate(const Node& node, const PayloadDescriptor& payload,
                                           const std::string& name, SourceOwners& owners,
                                           Diagnostics& diagnostics, LeftOut left_out) {
  const std::size_t errors = diagnostics.size();
  GivenEstimate given{Estimate(payload)};
  const Node* covariance_node = nullptr;
  const Node* values = &node;
  Node single;
  const bool quantity_map = node.is_map() && node.find("value") != nullptr &&
                            !payload.find("value") && node.find("covariance") == nullptr &&
                            !node.find("value")->is_map();
  if (node.is_scalar() || quantity_map) {
    if (payload.dimension() != 1) {
      diagnostics.add(node.position, fmt::format("{} has {} components; expected a map of them",
                                                 payload.name, payload.dimension()));
      return std::nullopt;
    }
    single.kind = Node::Kind::map;
    single.position = node.position;
    single.keys.push_back(
        {Node::Kind::scalar, node.position, false, payload.components.front().name});
    single.values.push_back(node);
    values = &single;
  } else if (node.is_map() && node.find("value") != nullptr && !payload.find("value")) {
    check_one_form(node, diagnostics);
    values = node.find("value");
    covariance_node = node.find("covariance");
  }
  if (!values->is_map()) {
    diagnostics.add(values->position, fmt::format("expected a map of {}'s components, got {}",
                                                  payload.name, values->description()));
    return std::nullopt;
  }
  // A covariance is over all components, so none of them can stay unknown beside it.
  if (covariance_node != nullptr) left_out = LeftOut::take_default;
  const auto written = read_components(*values, payload, given.estimate, left_out, diagnostics);
  if (!written) return std::nullopt;
  Eigen::VectorXd scale(static_cast<Eigen::Index>(written->size()));
  for (std::size_t i = 0; i < written->size(); ++i) {
    const Component& component = payload.components[i];
    if (std::isnan((*written)[i].number)) {
      given.estimate.value[i] = (*written)[i].number;
      continue;
    }
    const auto si = to_si((*written)[i], component.unit, diagnostics);
    if (!si) continue;
    given.estimate.value[i] = component.circular ? wrap_angle(si->value) : si->value;
    scale[static_cast<Eigen::Index>(i)] = si->scale;
    const auto& standard_deviation = (*written)[i].standard_deviation;
    if (!standard_deviation) continue;
    given.has_error = true;
    if (covariance_node != nullptr) {
      diagnostics.add((*written)[i].position, "give either a std or a covariance, not both");
      continue;
    }
    const auto owner = static_cast<std::uint32_t>(owners.size());
    owners.push_back({name + "." + component.name, false, (*written)[i].distribution,
                      (*written)[i].degrees_of_freedom});
    given.estimate.lineage.add({owner, 0, 0}, i, si->scale * *standard_deviation);
  }
  if (given.has_error && left_out == LeftOut::stay_unknown)
    check_all_have_std(*written, payload, diagnostics);
  if (covariance_node != nullptr) {
    given.has_error = true;
    const auto covariance = read_covariance(*covariance_node, written->size(), diagnostics);
    if (covariance && diagnostics.size() == errors) {
      const auto owner = static_cast<std::uint32_t>(owners.size());
      const Eigen::MatrixXd si = scale.asDiagonal() * *covariance * scale.asDiagonal();
      if (!si.allFinite())
        diagnostics.add(covariance_node->position, "the covariance is too large");
      check_variance_units(*written, payload, si, diagnostics);
      if (diagnostics.size() != errors) return std::nullopt;
      owners.push_back({name, false});
      given.estimate.lineage.add_noise({owner, 0, 0}, si);
    }
  }
  if (diagnostics.size() != errors) return std::nullopt;
  return given;
}

}  // namespace ilss
