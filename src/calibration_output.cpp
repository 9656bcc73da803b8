#include "src/calibration_output.h"

#include <fmt/format.h>

#include "src/output_file.h"
#include "src/session.h"

namespace ilss {

void refuse(const std::string& file, const Fault& fault) {
  fmt::print(stderr, "{}: {}: {}\n", file, fault_name(fault.kind), fault.message);
  throw Exit{exit_bad_input};
}

void write_file(const std::string& output, const std::string& text) {
  if (output.empty()) return;
  OutputFile file(output);
  file.stream() << text;
  file.commit();
}

}  // namespace ilss
