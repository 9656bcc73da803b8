// Runs one module the way a plan would, for tests of sensors.
#pragma once

#include <vector>

#include "framework/module/module_type.h"

namespace ilss {

/// Everything that one tick of a module needs, with defaults.
struct Tick {
  Estimate parameters = Estimate(no_parameters());
  std::vector<const Output*> inputs = {};
  std::int64_t tick = 0;
  std::uint64_t seed = 1;
  std::uint32_t owner = 1;
  std::uint64_t run_seed = 1;

  Evaluation evaluation() const {
    return {
        tick,    time_at(0.1 * static_cast<double>(tick)), seed, owner, parameters, inputs, false,
        run_seed};
  }
};

/// What a module gave.
struct ModuleRun {
  Outcome<> outcome;
  Output output;
};

inline ModuleRun run(Module& module, const Tick& tick) {
  ModuleRun result;
  result.outcome = module.open();
  if (!result.outcome) return result;
  result.outcome = module.evaluate(tick.evaluation(), result.output);
  return result;
}

/// The kind of the fault; fails the calling test's comparison where there is none.
inline std::string fault_of(const Outcome<>& outcome) {
  if (!outcome.is_fault()) return outcome.is_pending() ? "pending" : "output";
  return std::string(fault_name(outcome.fault().kind));
}

/// An output of a payload with given values and, for each component, an independent random error
/// of the given standard deviation (of `owner` at tick 0).
template <template <typename> class Payload>
Output output_of(const Payload<double>& values, const std::vector<double>& standard_deviations = {},
                 std::uint32_t owner = 100) {
  Output output;
  output.estimate = Estimate(descriptor<Payload>());
  assign<Payload>(output.estimate, values);
  for (std::size_t i = 0; i < standard_deviations.size(); ++i)
    if (standard_deviations[i] > 0)
      output.estimate.lineage.add({owner, static_cast<std::uint32_t>(i), 0}, i,
                                  standard_deviations[i]);
  return output;
}

/// A module's options as read from YAML text; `diagnostics` takes what is wrong with it.
template <typename Options>
Options options_from(const std::string& yaml, Diagnostics& diagnostics,
                     const std::filesystem::path& directory = ".") {
  const Node map = parse_document(yaml, "test.yaml", diagnostics);
  check_keys(map, declare_options<Options>(), "test", diagnostics);
  return read_options<Options>(&map, directory, diagnostics, map.position);
}

}  // namespace ilss
