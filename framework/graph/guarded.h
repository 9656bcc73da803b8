// Calls into modules: whatever one throws becomes a fault at the boundary.
#pragma once

#include <exception>
#include <string>

#include "framework/module/outcome.h"

namespace ilss {

/// What a call gives; what it throws becomes the fault `internal`.
template <typename Call>
Outcome<> guarded(const Call& call) {
  try {
    return call();
  } catch (const std::exception& error) {
    return Fault{FaultKind::internal, std::string("the module threw: ") + error.what()};
  } catch (...) {
    return Fault{FaultKind::internal, "the module threw"};
  }
}

}  // namespace ilss
