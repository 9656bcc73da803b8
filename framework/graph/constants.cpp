#include "framework/graph/constants.h"

#include <fmt/format.h>

#include "framework/estimate/units.h"

namespace ilss {

void Constants::read(const Node& map, const std::string& prefix,
                     const std::filesystem::path& directory, const Constants* outer,
                     SourceOwners& owners, Diagnostics& diagnostics) {
  for (std::size_t i = 0; i < map.size(); ++i) {
    const std::string& name = map.keys[i].text;
    const Node* value = &map.values[i];
    Node file;
    if (value->is_scalar() && value->text.starts_with('$')) {
      const auto* target = outer != nullptr ? outer->find(value->text.substr(1)) : nullptr;
      if (target != nullptr)
        elements_[name] = *target;
      else if (outer != nullptr)
        outer->report_unknown(*value, diagnostics);
      else
        diagnostics.add(value->position, "a constant cannot refer to another constant");
      continue;
    }
    if (value->is_map() && value->size() == 1 && value->find("file") != nullptr) {
      const Node& path = value->values.front();
      if (!path.is_scalar()) {
        diagnostics.add(path.position, "expected a path, got " + path.description());
        continue;
      }
      file = read_document(directory / path.text, diagnostics);
      if (!file.is_map()) continue;
      value = &file;
    }
    if (value->is_map() && value->find("value") != nullptr && value->find("value")->is_map()) {
      read_vector(name, *value, prefix, owners, diagnostics);
      continue;
    }
    const auto quantity = read_quantity(*value, diagnostics);
    if (!quantity) continue;
    ConstantElement element{*quantity};
    if (quantity->standard_deviation) {
      element.owner = static_cast<std::uint32_t>(owners.size());
      element.factor = {*quantity->standard_deviation};
      owners.push_back({prefix + name, true});
    }
    elements_[name] = std::move(element);
  }
}

void Constants::read_vector(const std::string& name, const Node& map, const std::string& prefix,
                            SourceOwners& owners, Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.size();
  const Node& values = *map.find("value");
  for (const Node& key : map.keys)
    if (key.text != "value" && key.text != "covariance")
      diagnostics.add(
          key.position,
          fmt::format("a vector constant has value and covariance, not '{}'", key.text));
  std::vector<ConstantElement> elements;
  for (const Node& value : values.values) {
    const auto quantity = read_quantity(value, diagnostics);
    elements.push_back({quantity.value_or(WrittenQuantity{})});
  }
  const Node* covariance_node = map.find("covariance");
  std::optional<Eigen::MatrixXd> covariance;
  if (covariance_node != nullptr) {
    covariance = read_covariance(*covariance_node, values.size(), diagnostics);
    for (const ConstantElement& element : elements)
      if (element.quantity.standard_deviation)
        diagnostics.add(element.quantity.position, "give either a std or a covariance, not both");
  }
  if (diagnostics.size() != errors) return;
  Lineage lineage(values.size());
  if (covariance) {
    lineage.add_noise({0, 0, persistent_tick}, *covariance);
  } else {
    for (std::size_t i = 0; i < elements.size(); ++i)
      if (elements[i].quantity.standard_deviation)
        lineage.add({0, static_cast<std::uint32_t>(i), persistent_tick}, i,
                    *elements[i].quantity.standard_deviation);
  }
  const auto owner = static_cast<std::uint32_t>(owners.size());
  if (!lineage.empty()) owners.push_back({prefix + name, true});
  for (std::size_t i = 0; i < elements.size(); ++i) {
    elements[i].owner = owner;
    for (std::size_t k = 0; k < lineage.size(); ++k)
      elements[i].factor.push_back(lineage.column(k)[i]);
    elements_[name + "." + values.keys[i].text] = std::move(elements[i]);
  }
}

const ConstantElement* Constants::find(std::string_view name) const {
  const auto found = elements_.find(name);
  return found == elements_.end() ? nullptr : &found->second;
}

void Constants::report_unknown(const Node& reference, Diagnostics& diagnostics) const {
  std::vector<std::string> names;
  for (const auto& [name, element] : elements_) names.push_back(name);
  const std::string name = reference.text.substr(1);
  diagnostics.add(reference.position,
                  fmt::format("unknown constant '{}'{}", name, suggestion(name, names)));
}

}  // namespace ilss
