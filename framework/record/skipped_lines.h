// What a sensor left out of its recording, for the user to know.
#pragma once

#include <cstdint>
#include <string>

#include "framework/module/outcome.h"

namespace ilss {

/// The bad lines of a recording that a sensor went past.
class SkippedLines {
 public:
  /// Counts a line; the fault's message says where it stands and what is wrong with it.
  void add(const Fault& fault);
  /// "3 bad lines left out, the first: a.log:12: expected a range, got 'x'"; empty where there is
  /// none.
  std::string text() const;

 private:
  std::uint64_t count_ = 0;
  std::string first_;
};

}  // namespace ilss
