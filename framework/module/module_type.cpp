#include "framework/module/module_type.h"

namespace ilss {

std::string_view kind_name(ModuleKind kind) {
  switch (kind) {
    case ModuleKind::sensor:
      return "sensor";
    case ModuleKind::function:
      return "function";
    case ModuleKind::estimator:
      return "estimator";
  }
  return "";
}

const PayloadDescriptor& no_parameters() {
  static const PayloadDescriptor none{"none", "", {}, {}, {}, {}};
  return none;
}

}  // namespace ilss
