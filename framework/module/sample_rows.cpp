#include "framework/module/sample_rows.h"

#include <fmt/format.h>

#include <stdexcept>

namespace ilss::internal {

void refuse_rows(const Output& output, std::size_t row_bytes) {
  const PayloadDescriptor* type = output.estimate.type;
  const bool has_samples = type != nullptr && type->samples.has_value();
  throw std::logic_error(fmt::format(
      "the samples of {} ({} bytes, {} each) are read as rows of another layout ({} bytes each)",
      type != nullptr ? type->name : "an output", output.samples.bytes.size(),
      has_samples ? type->samples->bytes() : 0, row_bytes));
}

}  // namespace ilss::internal
