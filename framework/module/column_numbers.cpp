#include "framework/module/column_numbers.h"

#include <cstring>

namespace ilss {
namespace {

template <typename Number>
double read(const std::byte* place) {
  Number number;
  std::memcpy(&number, place, sizeof number);
  return static_cast<double>(number);
}

}  // namespace

std::optional<ColumnNumbers> ColumnNumbers::find(const Output& output, std::string_view column) {
  const auto& declared = output.estimate.type->samples;
  if (!declared) return std::nullopt;
  ColumnNumbers numbers;
  numbers.first_ = output.samples.bytes.data();
  numbers.step_ = declared->bytes();
  numbers.size_ = output.samples.bytes.size() / numbers.step_;
  for (const SampleColumn& candidate : declared->columns) {
    numbers.type_ = candidate.type;
    if (candidate.name == column) return numbers;
    numbers.first_ += candidate.bytes();
  }
  return std::nullopt;
}

double ColumnNumbers::operator[](std::size_t sample) const {
  const std::byte* place = first_ + sample * step_;
  switch (type_) {
    case SampleType::uint8:
      return read<std::uint8_t>(place);
    case SampleType::uint16:
      return read<std::uint16_t>(place);
    case SampleType::float32:
      return read<float>(place);
    case SampleType::float64:
      return read<double>(place);
  }
  return 0;
}

}  // namespace ilss
