// Exact area coverage of pixels by polygons.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sensors/camera/lens_distortion.h"

namespace ilss {

/// Adds up weight times the share of each pixel's square that polygons cover, exact to rounding:
/// each edge writes the area to its right into differences along the row (as font renderers do),
/// and one running sum over a row gives its values. Cost: the edges' lengths plus the image.
class AreaCoverage {
 public:
  AreaCoverage(std::size_t rows, std::size_t columns);

  /// Adds a polygon without self-crossings; its corners are in pixels, pixel (i, j) being the
  /// square of side 1 around (i, j). Parts beyond the image are cut off.
  void add(std::span<const ImagePoint<double>> polygon, double weight);

  /// The sums over all polygons plus `base`, row-major.
  std::vector<double> values(double base) const;

 private:
  void add_edge(ImagePoint<double> from, ImagePoint<double> to, double weight);
  void add_in_row(std::size_t row, double left, double right, double signed_height);

  std::size_t rows_;
  std::size_t columns_;
  std::vector<double> differences_;  // rows x (columns + 1)
};

}  // namespace ilss
