// Estimates, outcomes and times as JSON: the fields of the command's contract, SI units.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "framework/runtime/characteristic_output.h"
#include "framework/semantics/monte_carlo.h"
#include "framework/semantics/time_prediction.h"

namespace ilss {

using Json = nlohmann::ordered_json;

/// JSON as text, on lines of its own with an indent of 2 or on one; bytes of names that are no
/// UTF-8 are replaced.
std::string json_text(const Json& json, bool on_one_line = false);

/// One estimate: type, frame, components, covariance, budget, verdict with its reason, and the
/// second-order mean and std where they were looked at. Without a verdict that is null.
Json estimate_json(const Estimate& estimate, const SourceOwners& owners,
                   const VerdictReport* verdict);

/// What Monte Carlo found of an estimate; null for numbers that there are none of.
Json monte_carlo_json(const MonteCarloOutput& result);

/// A fault: kind, message, and the module it comes from.
Json fault_json(const Fault& fault, const std::string& module);

/// The outputs of a system after a tick: one ESTIMATE, or {"outputs", "cross_covariance"}; null
/// where there is none. A set has "sources", and each of its "features" the "factor" over them.
Json outputs_json(const TickView& tick);

Json time_json(const TimePrediction& time, const Plan& plan);

}  // namespace ilss
