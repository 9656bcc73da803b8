// Unknown correlation goes on from input to output, whatever the module in between says.
#pragma once

#include "framework/module/module_type.h"

namespace ilss {

/// Of an output, and of all elements of its set alike.
inline void set_correlation_unknown(Output& output, bool unknown) {
  output.estimate.correlation_unknown = unknown;
  for (Estimate& element : output.elements) element.correlation_unknown = unknown;
}

/// Evaluates a module (`evaluate()` gives its Outcome<>), whose output then says that its
/// correlation with others is unknown where the module says so, of the output or of an element,
/// where an input does, or where the plan cannot tell how two inputs go together; but for a type
/// that states no error. An output that is held keeps what it said.
template <typename Call>
Outcome<> carry_correlation(const ModuleType& type, const Evaluation& evaluation, Output& output,
                            Call evaluate) {
  const bool held = output.estimate.correlation_unknown;
  if (held) set_correlation_unknown(output, false);
  Outcome<> outcome = evaluate();
  if (!outcome.has_output()) {
    if (held) set_correlation_unknown(output, true);
    return outcome;
  }
  bool unknown = evaluation.correlation_unknown || output.estimate.correlation_unknown;
  for (const Output* input : evaluation.inputs) unknown |= input->estimate.correlation_unknown;
  for (const Estimate& element : output.elements) unknown |= element.correlation_unknown;
  if (unknown && !type.states_no_error) set_correlation_unknown(output, true);
  return outcome;
}

}  // namespace ilss
