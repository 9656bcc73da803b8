#include "framework/graph/constants.h"

#include <fmt/format.h>

#include "framework/estimate/units.h"

namespace ilss {
namespace {

/// A constant that nothing uses may be of any dimension, but not of none.
void check_unit(const WrittenQuantity& quantity, Diagnostics& diagnostics) {
  if (quantity.unit.empty() || si_unit(quantity.unit)) return;
  const bool error_behind = quantity.unit.find("+-") != std::string::npos ||
                            quantity.unit.find("\u00b1") != std::string::npos;
  diagnostics.add(quantity.position,
                  fmt::format("unknown unit '{}'{}", quantity.unit,
                              error_behind ? "; an error is written {value: ..., std: ...}" : ""));
}

bool is_name(std::string_view name) {
  return !name.empty() && name.find_first_of(". $") == std::string_view::npos;
}

}  // namespace

void Constants::read(const Node& map, const std::string& prefix,
                     const std::filesystem::path& directory, const Constants* outer,
                     SourceOwners& owners, Diagnostics& diagnostics) {
  for (std::size_t i = 0; i < map.size(); ++i) {
    const std::size_t errors = diagnostics.size();
    const std::string& name = map.keys[i].text;
    const Node& value = map.values[i];
    const Node* path = value.is_map() && value.size() == 1 ? value.find("file") : nullptr;
    std::error_code no_file;  // a name that is too long for one, say
    if (!is_name(name)) {
      diagnostics.add(
          map.keys[i].position,
          fmt::format("'{}' cannot name a constant: names have no dots, spaces or $", name));
    } else if (value.is_null()) {
      diagnostics.add(map.keys[i].position, fmt::format("constant '{}' needs a value", name));
    } else if (value.is_scalar() && value.text.starts_with('$')) {
      refer(name, value, outer, diagnostics);
    } else if (path != nullptr && !path->is_scalar()) {
      diagnostics.add(path->position, "expected a path, got " + path->description());
    } else if (path != nullptr &&
               !std::filesystem::is_regular_file(directory / path->text, no_file)) {
      diagnostics.add(path->position,
                      fmt::format("there is no file '{}'", (directory / path->text).string()));
    } else if (path != nullptr) {
      const Node file = read_document(directory / path->text, diagnostics);
      if (diagnostics.size() == errors) read_one(name, file, prefix, owners, diagnostics);
    } else {
      read_one(name, value, prefix, owners, diagnostics);
    }
    if (diagnostics.size() != errors) unread_.insert(name);
  }
}

void Constants::read_one(const std::string& name, const Node& value, const std::string& prefix,
                         SourceOwners& owners, Diagnostics& diagnostics) {
  const Node* inner = value.is_map() ? value.find("value") : nullptr;
  if (inner != nullptr && inner->is_map())
    return read_vector(name, value, prefix, owners, diagnostics);
  const auto quantity = read_quantity(value, diagnostics);
  if (!quantity) return;
  keep(name, *quantity, prefix, owners, diagnostics);
}

void Constants::keep(const std::string& name, WrittenQuantity quantity, const std::string& prefix,
                     SourceOwners& owners, Diagnostics& diagnostics) {
  check_unit(quantity, diagnostics);
  ConstantElement element;
  if (quantity.standard_deviation) {
    element.owner = static_cast<std::uint32_t>(owners.size());
    element.factor = {*quantity.standard_deviation};
    owners.push_back({prefix + name, true, quantity.distribution, quantity.degrees_of_freedom});
  }
  element.quantity = std::move(quantity);
  elements_[name] = std::move(element);
}

void Constants::refer(const std::string& name, const Node& reference, const Constants* outer,
                      Diagnostics& diagnostics) {
  if (outer == nullptr)
    return diagnostics.add(reference.position, "a constant cannot refer to another constant");
  const std::string target = reference.text.substr(1);
  bool found = false;
  for (auto element = outer->elements_.lower_bound(target);
       element != outer->elements_.end() && element->first.starts_with(target); ++element) {
    const std::string_view rest = std::string_view(element->first).substr(target.size());
    if (!rest.empty() && rest.front() != '.') continue;
    elements_[name + std::string(rest)] = element->second;
    found = true;
  }
  if (!found) outer->report_unknown(reference, diagnostics);
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
  if (values.size() == 0) diagnostics.add(values.position, "a vector needs an element");
  std::vector<ConstantElement> elements;
  for (const Node& key : values.keys)
    if (!is_name(key.text))
      diagnostics.add(key.position, fmt::format("'{}' cannot name an element: names have no dots, "
                                                "spaces or $",
                                                key.text));
  for (const Node& value : values.values) {
    const auto quantity = read_quantity(value, diagnostics);
    elements.push_back({quantity.value_or(WrittenQuantity{})});
  }
  const Node* covariance_node = map.find("covariance");
  std::optional<Eigen::MatrixXd> covariance;
  if (covariance_node != nullptr && values.size() != 0) {
    covariance = read_covariance(*covariance_node, values.size(), diagnostics);
    for (const ConstantElement& element : elements)
      if (element.quantity.standard_deviation)
        diagnostics.add(element.quantity.position, "give either a std or a covariance, not both");
  }
  if (diagnostics.size() != errors) return;
  if (!covariance) {  // errors of their own, each to be blamed by itself
    for (std::size_t i = 0; i < elements.size(); ++i) {
      const std::string full_name = name + "." + values.keys[i].text;
      keep(full_name, std::move(elements[i].quantity), prefix, owners, diagnostics);
    }
    return;
  }
  Lineage lineage(values.size());
  lineage.add_noise({0, 0, persistent_tick}, *covariance);
  for (const ConstantElement& element : elements) check_unit(element.quantity, diagnostics);
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
  const std::string name = reference.text.substr(1);
  if (unread_.contains(name.substr(0, name.find('.')))) return;
  std::vector<std::string> names;
  for (const auto& [other, element] : elements_) names.push_back(other);
  const std::string elements = name + ".";
  std::erase_if(names, [&](const std::string& other) { return !other.starts_with(elements); });
  if (!names.empty())
    return diagnostics.add(reference.position,
                           fmt::format("'{}' is a vector; name one of its elements: ${}", name,
                                       fmt::join(names, ", $")));
  for (const auto& [other, element] : elements_) names.push_back(other);
  diagnostics.add(reference.position,
                  fmt::format("unknown constant '{}'{}", name, suggestion(name, names)));
}

}  // namespace ilss
