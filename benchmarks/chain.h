// Graphs of trivial modules for the benchmarks: what is left to measure is the framework.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>

#include "framework/graph/plan.h"
#include "framework/module/registry.h"

namespace ilss::benchmarks {

template <typename T>
struct Number {
  T value;
  static constexpr std::string_view name = "number";
  static constexpr auto fields = Fields{{"value", "m"}};
};

/// Gives the tick's number, without error.
class TickNumber final : public Module {
 public:
  static constexpr std::string_view name = "tick_number";
  static constexpr std::string_view description = "The tick's number";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static Interface interface() { return {{}, &descriptor<Number>(), "robot", {}}; }
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    output.estimate.value[0] = static_cast<double>(evaluation.tick);
    return {};
  }
};

/// Adds one to its input, and knows nothing of errors.
class PlusOne final : public Module {
 public:
  static constexpr std::string_view name = "plus_one";
  static constexpr std::string_view description = "Adds one";
  static constexpr ModuleKind kind = ModuleKind::function;
  static constexpr bool checked = true;
  static Interface interface() {
    return {{{"number", &descriptor<Number>(), {}, false}}, &descriptor<Number>(), {}, 0};
  }
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    output.estimate.value[0] = evaluation.input(0).value[0] + 1;
    return {};
  }
};

/// Gives the tick's number, with one random source.
class NoisyNumber final : public Module {
 public:
  static constexpr std::string_view name = "noisy_number";
  static constexpr std::string_view description = "The tick's number, with an error";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static Interface interface() { return {{}, &descriptor<Number>(), "robot", {}}; }
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    assign<Number>(output.estimate, {static_cast<double>(evaluation.tick)});
    output.estimate.lineage.add(evaluation.fresh(0), 0, 0.1);
    return {};
  }
};

/// Adds a parameter as a function module: errors propagate by automatic differentiation.
struct Shift {
  static constexpr std::string_view name = "shift";
  static constexpr std::string_view description = "Adds a length";
  static constexpr std::array<std::string_view, 1> inputs = {"number"};
  template <typename T>
  struct Parameters {
    T by;
    T again;
    static constexpr std::string_view name = "shift_parameters";
    static constexpr auto fields =
        Fields{{"by", "m", "What to add", 1.0}, {"again", "m", "And again", 0.0}};
  };
  template <typename T>
  Outcome<Number<T>> operator()(const Parameters<T>& parameters, const Number<T>& x) const {
    return Number<T>{x.value + parameters.by + parameters.again};
  }
};

inline const Registry& registry() {
  static const Registry result = [] {
    Registry modules;
    modules.add<TickNumber>();
    modules.add<PlusOne>();
    modules.add<NoisyNumber>();
    modules.add<Shift>();
    return modules;
  }();
  return result;
}

/// A graph's text: `first`, then modules of type `then`, `size` in all, one after another.
inline std::string chain_text(std::size_t size, std::string_view first, std::string_view then) {
  std::string modules = fmt::format("ilss: chain\nmodules:\n  m0: {{type: {}}}\n", first);
  std::string network = "network:\n  serial:\n    - m0\n";
  for (std::size_t i = 1; i < size; ++i) {
    modules += fmt::format("  m{}: {{type: {}}}\n", i, then);
    network += fmt::format("    - m{}\n", i);
  }
  return modules + network;
}

/// The plan of a graph's text. @throws std::runtime_error with the first thing that is wrong
inline Plan plan_of(const std::string& text) {
  Diagnostics diagnostics;
  const Node graph = parse_document(text, "benchmark.yaml", diagnostics);
  auto plan = build_plan(graph, ".", registry(), {}, diagnostics);
  if (!plan) throw std::runtime_error(format_diagnostic(diagnostics.sorted().front()));
  return std::move(*plan);
}

}  // namespace ilss::benchmarks
