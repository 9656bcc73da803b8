// Samples as rows of named numbers: a scan's readings, an image's levels. What a row's struct
// declares of its columns is checked against its layout when it is compiled, and against the
// payload when rows are read or written: nothing else looks into the bytes.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <new>
#include <span>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "framework/module/output.h"

namespace ilss {

/// The type of samples that are plain numbers of type T.
template <typename T>
inline constexpr auto sample_type_of = nullptr;
template <>
inline constexpr SampleType sample_type_of<std::uint8_t> = SampleType::uint8;
template <>
inline constexpr SampleType sample_type_of<std::uint16_t> = SampleType::uint16;
template <>
inline constexpr SampleType sample_type_of<float> = SampleType::float32;
template <>
inline constexpr SampleType sample_type_of<double> = SampleType::float64;
template <typename T, std::size_t n>
inline constexpr SampleType sample_type_of<std::array<T, n>> = sample_type_of<T>;

/// A number, or several side by side.
template <typename T>
concept SampleNumber = std::is_same_v<decltype(sample_type_of<T>), const SampleType>;

template <SampleNumber T>
inline constexpr std::size_t count_of = sizeof(T) / bytes_of(sample_type_of<T>);

/// Whether a column may be NaN where a sample has no such number.
enum class Missing { never, allowed };

/// A member of a row's struct as a column.
template <typename Row, typename T>
struct RowColumn {
  T Row::*member;
  std::string_view name;
  std::string_view unit;
  std::string_view documentation;
  Missing missing;
};

template <typename Row, SampleNumber T>
constexpr RowColumn<Row, T> column(T Row::*member, std::string_view name, std::string_view unit,
                                   std::string_view documentation = {},
                                   Missing missing = Missing::never) {
  return {member, name, unit, documentation, missing};
}

/// The columns of a row, one for each of its members in their order:
/// `struct Beam { double bearing, range;
///    static constexpr auto columns = Columns{column(&Beam::bearing, "bearing", "rad"),
///                                            column(&Beam::range, "range", "m", "0: none")}; };`
template <typename Row, typename... T>
class Columns {
 public:
  constexpr explicit Columns(RowColumn<Row, T>... columns) : columns_(columns...) {}

  /// Whether these are all members of the struct, in their order and without gaps: each is written
  /// full of ones, and these are looked for where its column must be.
  constexpr bool match_layout() const {
    if ((sizeof(T) + ...) != sizeof(Row)) return false;
    return std::apply(
        [](const auto&... column) {
          std::size_t place = 0;
          return (lies_at(column, place) && ...);
        },
        columns_);
  }

  /// Whether a payload's samples have these columns, as far as their bytes go.
  bool match(const SamplesDescriptor& samples) const {
    static constexpr std::array<SampleType, sizeof...(T)> types = {sample_type_of<T>...};
    static constexpr std::array<std::size_t, sizeof...(T)> counts = {count_of<T>...};
    if (samples.columns.size() != types.size()) return false;
    for (std::size_t i = 0; i < types.size(); ++i)
      if (samples.columns[i].type != types[i] || samples.columns[i].count != counts[i])
        return false;
    return true;
  }

  std::vector<SampleColumn> describe() const {
    std::vector<SampleColumn> result;
    std::apply([&result](const auto&... column) { (result.push_back(described(column)), ...); },
               columns_);
    return result;
  }

 private:
  template <typename Number>
  static constexpr bool lies_at(const RowColumn<Row, Number>& column, std::size_t& place) {
    using RowBytes = std::array<std::uint8_t, sizeof(Row)>;
    std::array<std::uint8_t, sizeof(Number)> ones{};
    ones.fill(0xff);
    auto row = std::bit_cast<Row>(RowBytes{});
    row.*column.member = std::bit_cast<Number>(ones);
    const auto bytes = std::bit_cast<RowBytes>(row);
    const std::size_t begin = std::exchange(place, place + sizeof(Number));
    for (std::size_t i = 0; i < bytes.size(); ++i)
      if (bytes[i] != (i >= begin && i < place ? 0xff : 0)) return false;
    return true;
  }

  template <typename Number>
  static SampleColumn described(const RowColumn<Row, Number>& column) {
    return {std::string(column.name), std::string(column.unit), std::string(column.documentation),
            sample_type_of<Number>,   count_of<Number>,         column.missing == Missing::allowed};
  }

  std::tuple<RowColumn<Row, T>...> columns_;
};

/// One sample: a struct that declares its `columns`, or a plain number.
template <typename Row>
concept SampleRow = SampleNumber<Row> ||
    (std::is_trivially_copyable_v<Row>&& std::is_standard_layout_v<Row>&& Row::columns
         .match_layout());

/// The samples of a payload whose rows are of a struct; `axis` is what they are counted as.
template <SampleRow Row>
SamplesDescriptor samples_of_rows(std::string axis) {
  return {{std::move(axis)}, Row::columns.describe()};
}

namespace internal {

/// @throws std::logic_error: the samples of the output's payload are no such rows.
[[noreturn]] void refuse_rows(const Output& output, std::size_t row_bytes);

template <SampleRow Row>
void check_rows(const Output& output) {
  if (output.estimate.type == nullptr || !output.estimate.type->samples) return;
  const SamplesDescriptor& samples = *output.estimate.type->samples;
  bool match = false;
  if constexpr (SampleNumber<Row>)
    match = samples.columns.size() == 1 && samples.columns[0].type == sample_type_of<Row> &&
            samples.columns[0].count == count_of<Row>;
  else
    match = Row::columns.match(samples);
  if (!match) refuse_rows(output, sizeof(Row));
}

}  // namespace internal

/// The rows of samples, all of them in row-major order.
/// @throws std::logic_error where the samples of the output's payload are no such rows.
template <SampleRow Row>
std::span<const Row> rows_of(const Output& output) {
  internal::check_rows<Row>(output);
  const std::vector<std::byte>& bytes = output.samples.bytes;
  if (bytes.size() % sizeof(Row) != 0) internal::refuse_rows(output, sizeof(Row));
  if (bytes.empty()) return {};
  // Rows live where make_rows made them, or where their bytes were copied to.
  return {std::launder(reinterpret_cast<const Row*>(bytes.data())), bytes.size() / sizeof(Row)};
}

/// Room for samples of that shape, to be written by the caller; rows that are there already stay.
template <SampleRow Row>
std::span<Row> make_rows(Samples& samples, std::initializer_list<std::size_t> shape) {
  static_assert(alignof(Row) <= __STDCPP_DEFAULT_NEW_ALIGNMENT__);
  samples.shape.assign(shape);
  std::size_t count = 1;
  for (const std::size_t size : shape) count *= size;
  samples.bytes.resize(count * sizeof(Row));
  if (count == 0) return {};
  // Copying bytes onto themselves begins the rows' lives there, and compiles to nothing.
  void* const begin =
      std::memmove(samples.bytes.data(), samples.bytes.data(), samples.bytes.size());
  return {std::launder(static_cast<Row*>(begin)), count};
}

/// Room for `count` rows in an output's samples, to be written by the caller; rows that are there
/// already stay. @throws std::logic_error where the samples of its payload are no such rows.
template <SampleRow Row>
std::span<Row> make_rows(Output& output, std::size_t count) {
  internal::check_rows<Row>(output);
  return make_rows<Row>(output.samples, {count});
}

}  // namespace ilss
