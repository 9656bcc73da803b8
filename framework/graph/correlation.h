// Where in a plan estimates of unknown correlation meet.
#pragma once

#include <vector>

#include "framework/graph/plan.h"

namespace ilss {

/// Finds every node where they meet. Within a tick lineages tell every correlation; what a module
/// with memory keeps of earlier ticks is one block of its own, whose correlation with another such
/// block of a common origin is lost (the reason for covariance intersection: Julier and Uhlmann
/// 1997). So is that of a bound, such as covariance intersection gives, with what it was made of.
/// O(nodes x blocks), where blocks are the modules that join errors.
std::vector<UnknownCorrelation> find_unknown_correlations(const Plan& plan);

/// "inputs of 'fused' are of unknown correlation: 'a' and 'b' both hold errors of 'sonar'".
std::string describe(const UnknownCorrelation& unknown, const Plan& plan);

}  // namespace ilss
