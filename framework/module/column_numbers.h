// One column of an output's samples by its name: for whoever knows a payload by its descriptor
// alone.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "framework/module/output.h"

namespace ilss {

/// The numbers of a column, whatever they are stored as; valid as long as the output stays.
class ColumnNumbers {
 public:
  /// Nothing where the output's payload has no samples with such a column.
  static std::optional<ColumnNumbers> find(const Output& output, std::string_view column);

  /// How many samples there are.
  std::size_t size() const { return size_; }
  /// A sample's number; of a column of several numbers side by side the first.
  double operator[](std::size_t sample) const;

 private:
  const std::byte* first_ = nullptr;
  std::size_t step_ = 0;  ///< bytes from one sample to the next
  std::size_t size_ = 0;
  SampleType type_ = SampleType::float64;
};

}  // namespace ilss
