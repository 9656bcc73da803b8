// Estimates as users write them: components with errors of their own, or with a covariance.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "framework/estimate/estimate.h"
#include "framework/graph/quantity_reader.h"

namespace ilss {

/// A covariance in the product of the values' units, or in SI once scaled: square, finite,
/// symmetric and positive semidefinite; anything else goes to `diagnostics`.
std::optional<Eigen::MatrixXd> read_covariance(const Node& node, std::size_t dimension,
                                               Diagnostics& diagnostics);

/// An estimate as given by hand, and whether any error was given with it.
struct GivenEstimate {
  Estimate estimate;
  bool has_error = false;
};

/// What becomes of components that are left out but have a default.
enum class LeftOut {
  take_default,  ///< they take it
  stay_unknown,  ///< they are NaN: the module whose output this is knows better
};

/// Reads a payload's value: a map of its components (each a quantity or {value, std}), a bare
/// quantity for a payload of one component, or {value: {...}, covariance: [[...]]}. Components left
/// out are as `left_out` says; those without a default must be given.
/// With `stay_unknown`, all given components or none have a std, so that none is exact by
/// oversight. Sources are random ones of tick 0, appended to `owners` under `name.component` (or
/// `name` for a covariance).
std::optional<GivenEstimate> read_estimate(const Node& node, const PayloadDescriptor& payload,
                                           const std::string& name, SourceOwners& owners,
                                           Diagnostics& diagnostics,
                                           LeftOut left_out = LeftOut::take_default);

}  // namespace ilss
