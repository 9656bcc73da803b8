// Graphs of formula modules out of tests' texts.
#pragma once

#include <gtest/gtest.h>

#include "framework/graph/system.h"
#include "sensors/register.h"

namespace ilss::test {

inline const Registry& sensors() {
  static const Registry& registry = *[] {
    auto* made = new Registry;
    register_sensors(*made);
    return made;
  }();
  return registry;
}

inline std::string lines_of(const Diagnostics& diagnostics) {
  std::string text;
  for (const Diagnostic& d : diagnostics.sorted()) text += format_diagnostic(d) + "\n";
  return text;
}

/// A plan, or what is wrong with the graph, a line each.
struct FormulaGraph {
  std::optional<Plan> plan;
  std::string errors;
};

inline FormulaGraph read_formulas(const std::string& text) {
  Diagnostics diagnostics;
  const Node graph = parse_document(text, "graph.yaml", diagnostics);
  FormulaGraph read;
  read.plan = build_plan(graph, ".", sensors(), {}, diagnostics);
  read.errors = lines_of(diagnostics);
  return read;
}

/// A graph of one expression without inputs, its quantities and output as given.
inline FormulaGraph read_expression(const std::string& quantities, const std::string& output) {
  return read_formulas("modules:\n  f:\n    type: expression\n    quantities: {" + quantities +
                       "}\n    output: {" + output + "}\nnetwork: f\n");
}

/// The output of a system's only output module.
inline const NodeState& only_output(const System& system) {
  return system.node(system.plan().outputs.at(0));
}

/// One evaluation of a graph that must be right.
class Evaluated {
 public:
  explicit Evaluated(FormulaGraph graph) : graph_(std::move(graph)) {
    EXPECT_EQ(graph_.errors, "");
    if (!graph_.plan) throw std::runtime_error("no plan:\n" + graph_.errors);
    system_.emplace(*graph_.plan, 1, Folding::none);
    system_->expect();
  }
  const Plan& plan() const { return *graph_.plan; }
  const NodeState& state() const { return only_output(*system_); }
  const Estimate& estimate() const { return state().output().estimate; }
  double value() const { return estimate().value.at(0); }

 private:
  FormulaGraph graph_;
  std::optional<System> system_;
};

}  // namespace ilss::test
