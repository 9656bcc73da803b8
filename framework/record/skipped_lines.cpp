#include "framework/record/skipped_lines.h"

#include <fmt/format.h>

namespace ilss {

void SkippedLines::add(const Fault& fault) {
  if (count_++ == 0) first_ = fault.message;
}

std::string SkippedLines::text() const {
  if (count_ == 0) return {};
  return fmt::format("{} bad line{} left out, the first: {}", count_, count_ == 1 ? "" : "s",
                     first_);
}

}  // namespace ilss
