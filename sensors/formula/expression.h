// Modules that a graph defines by formulas.
#pragma once

#include "framework/module/module_type.h"

namespace ilss {

/// `expression`: each component of the output by a formula over the components of the inputs and
/// over quantities. Formulas are read and their dimensions checked with the graph; errors go
/// through exact derivatives. The formulas compute in SI units. Fault: `not_finite` where a formula
/// or its derivative by something uncertain has no finite value.
ModuleType expression_type();

}  // namespace ilss
