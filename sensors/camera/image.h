// A grey image together with the camera that took it.
#pragma once

#include <cstdint>
#include <span>

#include "framework/estimate/payload.h"
#include "framework/module/sample_rows.h"

namespace ilss {

/// What later modules need of a camera to measure in its image, each with its own source of error,
/// and 8-bit grey levels as samples. Pixel (row i, column j) covers the square of side 1 around
/// (i, j), as in OpenCV; rows count downwards. Lens distortion is OpenCV's radial and tangential
/// model; all zeros: none.
template <typename T>
struct Image {
  T pixel_pitch, principal_row, principal_column, focal_length, k1, k2, p1, p2, k3, position_std;

  static constexpr std::string_view name = "image";
  static constexpr std::string_view documentation = "a grey image and the camera that took it";
  static constexpr auto fields =
      Fields{{"pixel_pitch", "m", "from pixel to pixel on the image sensor"},
             {"principal_row", "1", "row of the optical axis, in pixels"},
             {"principal_column", "1", "column of the optical axis, in pixels"},
             {"focal_length", "m", "of the lens"},
             {"k1", "1", "radial distortion by the radius squared", 0},
             {"k2", "1", "radial distortion by the radius to the fourth", 0},
             {"p1", "1", "tangential distortion", 0},
             {"p2", "1", "tangential distortion", 0},
             {"k3", "1", "radial distortion by the radius to the sixth", 0},
             {"position_std", "1",
              "error of a detected position beyond what the image shows, in pixels", 0}};
  static SamplesDescriptor samples() {
    return {{"row", "column"},
            {{"level", "1", "grey level, 0 black to 255 white", sample_type_of<std::uint8_t>}}};
  }

  /// Pixels per unit of tangent: the focal length in pixels.
  T magnification() const { return focal_length / pixel_pitch; }
};

/// The grey levels of an image's output, row after row.
inline std::span<const std::uint8_t> levels_of(const Output& image) {
  return rows_of<std::uint8_t>(image);
}

/// Room for an image's grey levels, to be written by the caller.
inline std::span<std::uint8_t> make_levels(Samples& samples, std::size_t rows,
                                           std::size_t columns) {
  return make_rows<std::uint8_t>(samples, {rows, columns});
}

}  // namespace ilss
