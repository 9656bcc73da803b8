// Estimates, outcomes and times as JSON: the fields of the command's contract, SI units.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "framework/semantics/monte_carlo.h"
#include "framework/semantics/time_prediction.h"
#include "framework/semantics/verdict.h"

namespace ilss {

using Json = nlohmann::ordered_json;

/// JSON as text, on lines of its own with an indent of 2 or on one; bytes of names that are no
/// UTF-8 are replaced.
std::string json_text(const Json& json, bool on_one_line = false);

/// One estimate: type, frame, components, covariance, budget, verdict with its reason, and the
/// second-order mean and std where they were looked at.
Json estimate_json(const Estimate& estimate, const SourceOwners& owners,
                   const VerdictReport& verdict);

/// What Monte Carlo found of an estimate; null for numbers that there are none of.
Json monte_carlo_json(const MonteCarloOutput& result);

/// A fault: kind, message, and the module it comes from.
Json fault_json(const Fault& fault, const std::string& module);

/// The outputs of a system after a tick: one ESTIMATE, or {"outputs", "cross_covariance"}; null
/// where there is none.
Json outputs_json(const System& system, const SourceOwners& owners,
                  const std::vector<VerdictReport>& verdicts);

Json time_json(const TimePrediction& time, const Plan& plan);

/// "output", "pending" or "fault".
std::string outcome_name(const Outcome<>& outcome);

/// The outcome of the whole system: a fault where any output has one, pending where any is, else an
/// output; and the output node that says so.
struct SystemOutcome {
  const Outcome<>* outcome;
  std::size_t node;
};
SystemOutcome system_outcome(const System& system);

}  // namespace ilss
