// A tick as JSON: the fields of the command's contract, SI units.
#pragma once

#include "framework/report/estimate_json.h"

namespace ilss {

/// {tick, time, outcome, fault?, output, modules: {NAME: {outcome, compute_ns, age_ns, acquired_ns,
/// fault?}}, commands?}. Of a module that has given nothing yet, or has a fault, the age and the
/// range of times at which its data were acquired are null.
Json tick_json(const TickView& tick);

}  // namespace ilss
