// Parameters, declared once: the same declaration is read from YAML, checked, listed by
// `ilss modules` and turned into JSON Schema.
//
// Quantities that may carry an uncertainty are a payload, `template <typename T> struct
// Parameters`. Everything else (paths, choices, switches, lists) is `struct Options` with `void
// declare(OptionVisitor&)`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "framework/estimate/payload.h"
#include "framework/module/document.h"

namespace ilss {

/// One parameter as users see it.
struct ParameterDeclaration {
  enum class Kind {
    quantity,
    number,
    integer,
    boolean,
    text,
    path,
    choice,
    list,
    group,
    map,  ///< names of the user's own, each with a value as the one child declares
  };

  std::string name;
  Kind kind = Kind::text;
  std::string unit = {};  ///< of a quantity
  std::string documentation = {};
  std::string default_text = {};  ///< as written in YAML; empty where there is none
  bool required = false;
  bool uncertain = false;  ///< may be {value, std}
  std::vector<std::string> choices = {};
  std::vector<ParameterDeclaration> children = {};  ///< of a group; of a list or map: its element
};

/// The kind's name: "quantity".
std::string_view kind_name(ParameterDeclaration::Kind kind);

/// The quantities of a Parameters payload as declarations; dots in names make groups.
std::vector<ParameterDeclaration> quantity_declarations(const PayloadDescriptor& parameters);

/// Adds `more` to `declarations`, joining groups of one name.
void merge_declarations(std::vector<ParameterDeclaration>& declarations,
                        std::vector<ParameterDeclaration> more);

/// A parameter that stands elsewhere today, and what to tell who still gives it.
struct MovedParameter {
  std::string_view name;
  std::string_view advice;  ///< follows "has no parameter 'mount': "
};

/// Reports keys of `map` that no declaration names, with the advice on those that were moved.
/// `owner` is for the message: "sonar".
void check_keys(const Node& map, const std::vector<ParameterDeclaration>& declarations,
                std::string_view owner, Diagnostics& diagnostics,
                const std::vector<MovedParameter>& moved = {});

/// What is special about an option.
struct OptionAttributes {
  std::string_view unit = {};  ///< of a double: makes it a quantity, held in this SI unit
  bool required = false;
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
};

/// Types whose YAML form is one of a few words: `constexpr auto choices(Contact)` gives the names
/// in the order of the enumerators, found by argument-dependent lookup.
template <typename T>
concept Choice = std::is_enum_v<T> && requires(T value) {
  choices(value).size();
};

/// An option that names another YAML file of declared structure, such as a scene; the file is read
/// and checked with the graph, its errors reported at their own positions.
template <typename T>
struct FileOf {
  std::filesystem::path path = {};
  T content = {};
};

/// Visits a module's options, either to declare them or to read them.
class OptionVisitor {
 public:
  /// Collects declarations.
  explicit OptionVisitor(std::vector<ParameterDeclaration>& declarations)
      : declarations_(&declarations) {}
  /// Reads from a map (may be null: nothing given). Relative paths are taken from `directory`.
  OptionVisitor(const Node* map, const std::filesystem::path& directory, Diagnostics& diagnostics,
                Position fallback)
      : map_(map), directory_(&directory), diagnostics_(&diagnostics), fallback_(fallback) {}

  /// Visits one option: a bool, integer, double, string, path, Choice, struct with `declare`, or a
  /// std::vector or std::optional of one of these. `value` holds the default.
  template <typename T>
  void operator()(std::string_view name, T& value, std::string_view documentation,
                  const OptionAttributes& attributes = {});

  /// Reports a problem of several options together; only heard while reading.
  void require(bool condition, std::string_view message);

 private:
  template <typename T>
  ParameterDeclaration declare(std::string_view name, const T& value,
                               std::string_view documentation, const OptionAttributes& attributes);
  template <typename T>
  void read(const Node& node, T& value, const OptionAttributes& attributes);
  template <typename T>
  void read_group(const Node* map, T& value);
  std::string full_name(std::string_view name) const;
  void read_scalar(const Node& node, bool& value);
  void read_scalar(const Node& node, std::int64_t& value, const OptionAttributes& attributes);
  void read_scalar(const Node& node, double& value, const OptionAttributes& attributes);
  void read_scalar(const Node& node, std::string& value);
  void read_scalar(const Node& node, std::filesystem::path& value);
  std::optional<std::size_t> read_choice(const Node& node, const std::vector<std::string>& choices);
  void complain(const Node& node, std::string message);

  std::vector<ParameterDeclaration>* declarations_ = nullptr;
  const Node* map_ = nullptr;
  const std::filesystem::path* directory_ = nullptr;
  Diagnostics* diagnostics_ = nullptr;
  Position fallback_ = {};
  std::string group_ = {};      ///< the group being read: "mount"
  std::string_view name_ = {};  ///< the option being read
};

/// Reads a YAML file whose top level is a declared struct.
template <typename T>
T read_options_file(const std::filesystem::path& path, Diagnostics& diagnostics);

namespace internal {
template <typename T>
struct OptionalOf : std::false_type {};
template <typename T>
struct OptionalOf<std::optional<T>> : std::true_type {};
template <typename T>
struct VectorOf : std::false_type {};
template <typename T>
struct VectorOf<std::vector<T>> : std::true_type {};
template <typename T>
struct IsFileOf : std::false_type {};
template <typename T>
struct IsFileOf<FileOf<T>> : std::true_type {};
std::string format_number(double value);
}  // namespace internal

template <typename T>
void OptionVisitor::operator()(std::string_view name, T& value, std::string_view documentation,
                               const OptionAttributes& attributes) {
  if (declarations_ != nullptr) {
    declarations_->push_back(declare(name, value, documentation, attributes));
    return;
  }
  const Node* node = map_ != nullptr ? map_->find(name) : nullptr;
  name_ = name;
  if (node != nullptr && !node->is_null()) return read(*node, value, attributes);
  if (attributes.required) {
    diagnostics_->add(fallback_, "missing parameter '" + full_name(name) + "'");
  } else if constexpr (requires { value.declare(*this); }) {
    read_group(nullptr, value);  // what the group requires is missing, too
  }
}

template <typename T>
void OptionVisitor::read_group(const Node* map, T& value) {
  OptionVisitor visitor(map, *directory_, *diagnostics_,
                        map != nullptr ? map->position : fallback_);
  visitor.group_ = full_name(name_);
  value.declare(visitor);
}

template <typename T>
ParameterDeclaration OptionVisitor::declare(std::string_view name, const T& value,
                                            std::string_view documentation,
                                            const OptionAttributes& attributes) {
  using Kind = ParameterDeclaration::Kind;
  ParameterDeclaration d;
  if constexpr (internal::OptionalOf<T>::value) {
    d = declare(name, typename T::value_type{}, documentation, attributes);
    if (d.kind != Kind::group) d.default_text.clear();
    return d;
  }
  d.name = name;
  d.documentation = documentation;
  d.required = attributes.required;
  if constexpr (std::is_same_v<T, bool>) {
    d.kind = Kind::boolean;
    d.default_text = value ? "true" : "false";
  } else if constexpr (std::is_integral_v<T>) {
    d.kind = Kind::integer;
    d.default_text = std::to_string(value);
  } else if constexpr (std::is_same_v<T, double>) {
    d.kind = attributes.unit.empty() ? Kind::number : Kind::quantity;
    d.unit = attributes.unit;
    d.default_text = internal::format_number(value);
    if (!attributes.unit.empty() && attributes.unit != "1")
      d.default_text += " " + std::string(attributes.unit);
  } else if constexpr (std::is_same_v<T, std::string>) {
    d.kind = Kind::text;
    d.default_text = value;
  } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
    d.kind = Kind::path;
    d.default_text = value.string();
  } else if constexpr (internal::IsFileOf<T>::value) {
    d.kind = Kind::path;
  } else if constexpr (Choice<T>) {
    d.kind = Kind::choice;
    for (const auto& choice : choices(value)) d.choices.emplace_back(choice);
    d.default_text = d.choices[static_cast<std::size_t>(value)];
  } else if constexpr (internal::VectorOf<T>::value) {
    d.kind = Kind::list;
    d.children = {declare("", typename T::value_type{}, "", attributes)};
  } else if constexpr (!internal::OptionalOf<T>::value) {
    d.kind = Kind::group;
    OptionVisitor visitor(d.children);
    T copy = value;
    copy.declare(visitor);
  }
  if (attributes.required) d.default_text.clear();
  return d;
}

template <typename T>
void OptionVisitor::read(const Node& node, T& value, const OptionAttributes& attributes) {
  if constexpr (internal::OptionalOf<T>::value) {
    value.emplace();
    read(node, *value, attributes);
  } else if constexpr (internal::VectorOf<T>::value) {
    if (!node.is_list()) return complain(node, "expected a list, got " + node.description());
    value.clear();
    for (const Node& element : node.values) {
      value.emplace_back();
      read(element, value.back(), attributes);
    }
  } else if constexpr (std::is_same_v<T, std::int64_t> || std::is_same_v<T, double>) {
    read_scalar(node, value, attributes);
  } else if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>) {
    OptionAttributes bounds = attributes;
    bounds.minimum = std::max(bounds.minimum, static_cast<double>(std::numeric_limits<T>::min()));
    bounds.maximum = std::min(bounds.maximum, static_cast<double>(std::numeric_limits<T>::max()));
    auto wide = static_cast<std::int64_t>(value);
    read_scalar(node, wide, bounds);
    value = static_cast<T>(wide);
  } else if constexpr (Choice<T>) {
    std::vector<std::string> names;
    for (const auto& choice : choices(value)) names.emplace_back(choice);
    if (const auto index = read_choice(node, names)) value = static_cast<T>(*index);
  } else if constexpr (internal::IsFileOf<T>::value) {
    read_scalar(node, value.path);
    if (node.is_scalar())
      value.content = read_options_file<decltype(value.content)>(value.path, *diagnostics_);
  } else if constexpr (requires { value.declare(*this); }) {
    if (!node.is_map()) return complain(node, "expected a map, got " + node.description());
    read_group(&node, value);
  } else {
    read_scalar(node, value);
  }
}

/// The declarations of an Options struct.
template <typename Options>
std::vector<ParameterDeclaration> declare_options() {
  std::vector<ParameterDeclaration> declarations;
  OptionVisitor visitor(declarations);
  Options options;
  options.declare(visitor);
  return declarations;
}

/// Options read from a map (null: all defaults); what is wrong goes to `diagnostics`.
template <typename Options>
Options read_options(const Node* map, const std::filesystem::path& directory,
                     Diagnostics& diagnostics, Position fallback) {
  Options options;
  OptionVisitor visitor(map, directory, diagnostics, fallback);
  options.declare(visitor);
  return options;
}

template <typename T>
T read_options_file(const std::filesystem::path& path, Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.size();
  const Node root = read_document(path, diagnostics);
  if (diagnostics.size() != errors) return {};
  if (!root.is_map()) {
    diagnostics.add(root.position, "expected a map, got " + root.description());
    return {};
  }
  check_keys(root, declare_options<T>(), path.filename().string(), diagnostics);
  return read_options<T>(&root, path.parent_path(), diagnostics, root.position);
}

}  // namespace ilss
