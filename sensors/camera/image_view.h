// An image's grey levels, as they are or transposed.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ilss {

/// Grey levels by position along a band and across it: for a horizontal band, along counts columns
/// and across rows; transposed, for a vertical one, the other way round.
struct ImageView {
  const std::uint8_t* levels;
  int along_size;
  int across_size;
  std::ptrdiff_t along_stride;
  std::ptrdiff_t across_stride;

  double at(int along, int across) const {
    return levels[along * along_stride + across * across_stride];
  }
  ImageView transposed() const {
    return {levels, across_size, along_size, across_stride, along_stride};
  }
};

/// The view along columns of a row-major image.
inline ImageView horizontal_view(const std::uint8_t* levels, int rows, int columns) {
  return {levels, columns, rows, 1, columns};
}

}  // namespace ilss
