// What `ilss predict` adds to an estimate for people: who is to blame, and what Monte Carlo says.
#pragma once

#include <string>

#include "framework/semantics/monte_carlo.h"

namespace ilss {

/// The budget of each component, largest share first: every owner's standard deviation and share,
/// random apart from systematic, and the standard deviation if that owner's errors were halved.
std::string budget_tables_text(const Estimate& estimate, const SourceOwners& owners);

/// The effective degrees of freedom of components that have any, with the 95 % interval that
/// follows from them; "" where every standard deviation is known.
std::string degrees_of_freedom_text(const Estimate& estimate, const SourceOwners& owners);

/// First order beside Monte Carlo, a line a component.
std::string monte_carlo_text(const Estimate& estimate, const MonteCarloOutput& result);

}  // namespace ilss
