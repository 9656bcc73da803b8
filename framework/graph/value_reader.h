// Values with errors as users write them: quantities, vectors with a covariance, given estimates.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "framework/estimate/estimate.h"
#include "framework/module/document.h"

namespace ilss {

/// A number in the unit it was written in, and its standard deviation in that unit.
struct WrittenQuantity {
  double number = 0;
  std::string unit = {};
  std::optional<double> standard_deviation = {};
  Position position = {};
  Distribution distribution = {};
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
};

/// Reads `11 deg` or `{value: 11 deg, std: 0.3 deg}`. A std without a unit is refused unless the
/// value has none either. The error may have a `distribution` (normal, uniform, triangular,
/// arcsine, t, or `{samples: FILE, column: NAME}`, a CSV file, relative to where the value stands),
/// a `half_width` instead of the std where the law is bounded, and `degrees_of_freedom`.
std::optional<WrittenQuantity> read_quantity(const Node& node, Diagnostics& diagnostics);

/// Its value and the scale of its errors in an SI unit; a wrong dimension goes to `diagnostics`.
struct SiQuantity {
  double value;
  double scale;
};
std::optional<SiQuantity> to_si(const WrittenQuantity& quantity, std::string_view si_unit,
                                Diagnostics& diagnostics);

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
