// Linear maps that a graph defines by a matrix.
#pragma once

#include "framework/module/module_type.h"

namespace ilss {

/// `linear`: y = A x + c, where x is every component of the inputs in order, then every quantity.
/// Either `matrix` is A (a row for each output, a column for each x), or `design` is D of the model
/// x = D y + e (a row for each x, a column for each output) and A is its pseudo-inverse: least
/// squares with equal weights (Householder QR). All in SI units. A design whose columns are not
/// independent is an error of the graph. Fault: `not_finite` where a result is too large.
ModuleType linear_type();

}  // namespace ilss
