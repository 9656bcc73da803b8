// The registry: every module type and payload that graphs can name.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "framework/module/function_module.h"
#include "framework/module/module_type.h"

namespace ilss {

class Registry {
 public:
  /// Adds a function, sensor or estimator class: `registry.add<VisionLine>();`
  template <typename M>
  void add() {
    if constexpr (std::derived_from<M, Module>)
      add(module_type<M>());
    else
      add(function_type<M>());
  }
  /// @throws std::invalid_argument if the name is taken, a payload of one of the type's names has
  ///         other components, labels, samples or elements, or its commands cannot be declared so.
  void add(ModuleType type);

  const ModuleType* find(std::string_view name) const;
  const PayloadDescriptor* find_payload(std::string_view name) const;
  /// In order of name.
  std::vector<const ModuleType*> types() const;
  std::vector<std::string> names() const;

 private:
  void add_payload(const PayloadDescriptor& payload);

  std::map<std::string, std::unique_ptr<ModuleType>, std::less<>> types_;
  std::map<std::string, const PayloadDescriptor*, std::less<>> payloads_;
};

/// Loads a shared library of modules and calls its `extern "C" void
/// ilss_register(ilss::Registry&)`. The library stays loaded. @throws std::runtime_error with the
/// loader's reason.
void load_plugin(const std::string& path, Registry& registry);

}  // namespace ilss
