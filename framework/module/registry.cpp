#include "framework/module/registry.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <stdexcept>

namespace ilss {

namespace {

ParameterDeclaration any_quantities() {
  ParameterDeclaration value;
  value.kind = ParameterDeclaration::Kind::quantity;
  value.uncertain = true;
  ParameterDeclaration map;
  map.name = "quantities";
  map.kind = ParameterDeclaration::Kind::map;
  map.documentation = "named values in any unit, each of which may carry an error";
  map.children = {std::move(value)};
  return map;
}

}  // namespace

void Registry::add(ModuleType type) {
  if (types_.contains(type.name))
    throw std::invalid_argument(fmt::format("module type '{}' is registered twice", type.name));
  if (const std::string wrong = mistake_in(type.commands); !wrong.empty())
    throw std::invalid_argument(fmt::format("module type '{}': {}", type.name, wrong));
  const Interface interface = type.interface(Settings{});
  for (const InputDeclaration& input : interface.inputs) add_payload(*input.payload);
  add_payload(*interface.output);
  type.declarations = quantity_declarations(*type.parameters);
  if (type.takes_quantities) type.declarations.push_back(any_quantities());
  merge_declarations(type.declarations, type.options);
  std::string name = type.name;
  types_.emplace(std::move(name), std::make_unique<ModuleType>(std::move(type)));
}

void Registry::add_payload(const PayloadDescriptor& payload) {
  if (&payload == &any_payload()) return;
  for (const PayloadDescriptor* element : payload.elements) add_payload(*element);
  const auto [place, fresh] = payloads_.emplace(payload.name, &payload);
  if (fresh) return;
  if (!same_payload(*place->second, payload))
    throw std::invalid_argument(fmt::format(
        "payload '{}' is declared twice, with different components, labels, samples or elements",
        payload.name));
}

const ModuleType* Registry::find(std::string_view name) const {
  const auto found = types_.find(name);
  return found == types_.end() ? nullptr : found->second.get();
}

const PayloadDescriptor* Registry::find_payload(std::string_view name) const {
  const auto found = payloads_.find(name);
  return found == payloads_.end() ? nullptr : found->second;
}

std::vector<const ModuleType*> Registry::types() const {
  std::vector<const ModuleType*> result;
  for (const auto& [name, type] : types_) result.push_back(type.get());
  return result;
}

std::vector<std::string> Registry::names() const {
  std::vector<std::string> result;
  for (const auto& [name, type] : types_) result.push_back(name);
  return result;
}

void load_plugin(const std::string& path, Registry& registry) {
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr)
    throw std::runtime_error(fmt::format("cannot load plug-in: {}", dlerror()));
  using Register = void (*)(Registry&);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): what dlsym is for
  const auto function = reinterpret_cast<Register>(dlsym(library, "ilss_register"));
  if (function == nullptr)
    throw std::runtime_error(
        fmt::format("'{}' is no module library: it has no function ilss_register", path));
  try {
    function(registry);
  } catch (const std::exception& error) {
    throw std::runtime_error(fmt::format("plug-in '{}': {}", path, error.what()));
  }
}

}  // namespace ilss
