// What every output is held to, whoever made it: the shape that its payload declares, and finite
// numbers, in its components, its samples and its elements.
#pragma once

#include "framework/module/outcome.h"
#include "framework/module/output.h"

namespace ilss {

/// How an output breaks its contract.
enum class Breach {
  none,
  not_finite,   ///< a value, a sensitivity, a sample or a standard deviation of samples
  other_shape,  ///< not the components, labels, samples or elements that its payload declares
};

/// The first breach of an output; samples may be absent altogether, as they are in a prediction.
/// Costs a few ns for an estimate, and a pass over what else there is.
Breach find_breach(const Output& output, const PayloadDescriptor& payload);

/// The same of the samples and elements alone, where the estimate was checked as it was made.
Breach find_breach_in_parts(const Output& output, const PayloadDescriptor& payload);

/// The fault of an output that has a breach: `not_finite` or `internal`, saying where.
Fault describe_breach(const Output& output, const PayloadDescriptor& payload);

}  // namespace ilss
