#include "framework/module/outcome.h"

namespace ilss {

std::string_view fault_name(FaultKind kind) {
  switch (kind) {
    case FaultKind::no_detection:
      return "no_detection";
    case FaultKind::out_of_range:
      return "out_of_range";
    case FaultKind::stale:
      return "stale";
    case FaultKind::degenerate:
      return "degenerate";
    case FaultKind::ambiguous:
      return "ambiguous";
    case FaultKind::not_finite:
      return "not_finite";
    case FaultKind::end_of_data:
      return "end_of_data";
    case FaultKind::bad_data:
      return "bad_data";
    case FaultKind::device_lost:
      return "device_lost";
    case FaultKind::no_error_known:
      return "no_error_known";
    case FaultKind::refused:
      return "refused";
    case FaultKind::internal:
      return "internal";
  }
  return "internal";
}

}  // namespace ilss
