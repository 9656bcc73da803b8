#include "framework/graph/value_reader.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "framework/estimate/decompositions.h"
#include "framework/estimate/units.h"

namespace ilss {
namespace {

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
  const auto eigen = symmetric_eigen(correlation);
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
    given.estimate.value[i] = si->value;
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
  normalize(payload, given.estimate.value);
  return given;
}

}  // namespace ilss
