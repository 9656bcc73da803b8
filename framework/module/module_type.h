// A module's type: what is declared of it once, for the check, the documentation and the schema.
#pragma once

#include <concepts>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "framework/module/command_declaration.h"
#include "framework/module/module.h"
#include "framework/module/parameters.h"

namespace ilss {

/// Sensors acquire, functions are closed formulas, estimators detect, fit or filter.
enum class ModuleKind { sensor, function, estimator };
std::string_view kind_name(ModuleKind kind);

/// One input: its payload by name (or `any_payload`), and the frame it must be in (empty: any).
struct InputDeclaration {
  std::string name;
  const PayloadDescriptor* payload;
  std::string frame = {};
  bool repeated = false;  ///< the last input only: one or more of these
};

/// What a module looks like from outside. The output's frame is `frame`, or that of an input.
struct Interface {
  std::vector<InputDeclaration> inputs;
  const PayloadDescriptor* output = nullptr;
  std::string frame = {};
  std::optional<std::size_t> frame_of_input = {};
  bool draws_readings = false;  ///< a simulated sensor: its noise follows from the tick's seed
  bool forgets = false;  ///< with these options nothing of earlier ticks lives on, if ever it does
};

/// A module's settings as read from a graph: its options and where relative paths start.
struct Settings {
  std::shared_ptr<const void> options;  ///< the type's Options; null where it has none
  std::filesystem::path directory;
  /// The values that the graph gives under `quantities:`, where the type takes any; then these are
  /// the module's parameters.
  const PayloadDescriptor* quantities = nullptr;
};

/// What is known of a module once it is connected: what its inputs bring. Faults in how the graph
/// uses it are reported at `position`, or where they are.
struct Connections {
  std::vector<const PayloadDescriptor*> inputs;
  Position position;
  Diagnostics* diagnostics;
};

/// Everything the framework knows of a type of module.
struct ModuleType {
  std::string name;
  ModuleKind kind = ModuleKind::function;
  std::string description;
  std::string reference;                          ///< paper and section
  const PayloadDescriptor* parameters = nullptr;  ///< quantities; never null once registered
  std::vector<ParameterDeclaration> options;
  std::vector<ParameterDeclaration> declarations;  ///< quantities and options; set by the registry
  std::vector<MovedParameter> moved_parameters;
  std::vector<FaultKind> faults;
  std::vector<CommandDeclaration> commands;
  bool takes_quantities = false;  ///< any named values of the graph, under `quantities:`
  /// Its output holds random errors of earlier ticks, joined in a block of its own: how that block
  /// goes with another of the same origin is not known.
  bool remembers = false;
  /// It gives its inputs' random errors as a block of its own: how these go with the inputs is
  /// lost.
  bool severs = false;
  /// Its values depend on the errors that its inputs state, as a weighted mean's do.
  bool weighs_errors = false;
  /// Its output is a statement about its inputs that has no error of its own, such as a test's.
  bool states_no_error = false;
  bool selects = false;  ///< a Selector: its inputs are branches, evaluated on demand
  /// Its estimates are checked where they are made: finite, with the components and labels of its
  /// payload.
  bool checked = false;

  /// The interface under given settings; with default settings for documentation.
  std::function<Interface(const Settings&)> interface;
  std::function<std::shared_ptr<const void>(const Node* map, const std::filesystem::path& directory,
                                            Diagnostics&, Position fallback)>
      read_options;
  std::function<std::unique_ptr<Module>(const Settings&)> create;
  /// Completes the interface and settings of a module that takes `any_payload`, once what feeds it
  /// is known. Null where there is nothing to complete.
  std::function<void(const Connections&, Settings&, Interface&)> resolve;
};

/// A payload without components, for modules without quantities.
const PayloadDescriptor& no_parameters();

namespace internal {

template <typename M>
concept HasParameters = requires {
  typename M::template Parameters<double>;
};
template <typename M>
concept HasOptions = requires {
  typename M::Options;
};

/// Fills in what functions, sensors and estimators declare alike as static members of M: `name`,
/// `description`, `reference`, `faults`, `moved_parameters`, `commands()`, Parameters and Options.
template <typename M>
void fill_declarations(ModuleType& type) {
  type.name = M::name;
  type.description = M::description;
  if constexpr (requires { M::reference; }) type.reference = M::reference;
  if constexpr (requires { M::faults; }) type.faults.assign(M::faults.begin(), M::faults.end());
  if constexpr (requires { M::moved_parameters; })
    type.moved_parameters.assign(M::moved_parameters.begin(), M::moved_parameters.end());
  if constexpr (requires { M::commands(); }) type.commands = M::commands();
  if constexpr (requires { M::remembers; }) type.remembers = M::remembers;
  if constexpr (requires { M::weighs_errors; }) type.weighs_errors = M::weighs_errors;
  if constexpr (requires { M::states_no_error; }) type.states_no_error = M::states_no_error;
  if constexpr (requires { M::checked; }) type.checked = M::checked;
  if constexpr (requires { M::severs; }) type.severs = M::severs;
  if constexpr (requires { &M::resolve; }) type.resolve = &M::resolve;
  if constexpr (HasParameters<M>)
    type.parameters = &descriptor<M::template Parameters>();
  else
    type.parameters = &no_parameters();
  if constexpr (HasOptions<M>) {
    type.options = declare_options<typename M::Options>();
    type.read_options = [](const Node* map, const std::filesystem::path& directory,
                           Diagnostics& diagnostics, Position fallback) {
      return std::shared_ptr<const void>(std::make_shared<const typename M::Options>(
          ilss::read_options<typename M::Options>(map, directory, diagnostics, fallback)));
    };
  }
}

/// The options in `settings`, or their defaults.
template <typename M>
typename M::Options options_of(const Settings& settings) {
  if (settings.options == nullptr) return {};
  return *static_cast<const typename M::Options*>(settings.options.get());
}

}  // namespace internal

/// The type of a sensor, an estimator, or a function of any payload: a class M derived from Module
/// with static `name`, `description`, `kind` and `Interface interface()` (or `interface(const
/// Options&)`), optionally `reference`, `faults`, `moved_parameters`, `commands()`, `remembers`,
/// `severs`, `checked`, `weighs_errors`, `states_no_error`, `resolve(const Connections&,
/// Settings&, Interface&)`, `template <typename T> struct Parameters` and `struct Options`;
/// constructed from its Options where it has them.
template <typename M>
requires std::derived_from<M, Module> ModuleType module_type() {
  ModuleType type;
  internal::fill_declarations<M>(type);
  type.kind = M::kind;
  type.selects = std::derived_from<M, Selector>;
  type.interface = []([[maybe_unused]] const Settings& settings) {
    if constexpr (requires { M::interface(); })
      return M::interface();
    else
      return M::interface(internal::options_of<M>(settings));
  };
  type.create = []([[maybe_unused]] const Settings& settings) -> std::unique_ptr<Module> {
    if constexpr (internal::HasOptions<M>)
      return std::make_unique<M>(internal::options_of<M>(settings));
    else
      return std::make_unique<M>();
  };
  return type;
}

}  // namespace ilss
