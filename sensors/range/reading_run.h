// Some readings of a scan, one after another.
#pragma once

#include <cstddef>

namespace ilss {

/// Readings [begin, end) of a scan.
struct ReadingRun {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t size() const { return end - begin; }
  bool operator==(const ReadingRun&) const = default;
};

}  // namespace ilss
