// Samples as rows of named numbers: a scan's readings, a list of points.
#pragma once

#include <cstddef>
#include <span>
#include <type_traits>

#include "framework/module/output.h"

namespace ilss {

/// A struct of doubles only: one row of samples, a column a member.
template <typename Row>
concept SampleRow = std::is_trivially_copyable_v<Row> && std::is_standard_layout_v<Row> &&
                            sizeof(Row) %
                            sizeof(double) ==
                        0 &&
                    alignof(Row) == alignof(double);

template <SampleRow Row>
inline constexpr std::size_t columns_of = sizeof(Row) / sizeof(double);

/// The rows of an output's samples.
template <SampleRow Row>
std::span<const Row> rows_of(const Output& output) {
  return {reinterpret_cast<const Row*>(output.samples.values.data()),
          output.samples.values.size() / columns_of<Row>};
}

/// Room for `count` rows in an output's samples, to be written by the caller; rows that are there
/// already stay.
template <SampleRow Row>
std::span<Row> make_rows(Output& output, std::size_t count) {
  output.samples.shape.assign({count, columns_of<Row>});
  output.samples.values.resize(count * columns_of<Row>);
  return {reinterpret_cast<Row*>(output.samples.values.data()), count};
}

}  // namespace ilss
