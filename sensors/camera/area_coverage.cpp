#include "sensors/camera/area_coverage.h"

#include <algorithm>
#include <cmath>

namespace ilss {

AreaCoverage::AreaCoverage(std::size_t rows, std::size_t columns)
    : rows_(rows), columns_(columns), differences_(rows * (columns + 1), 0.0) {}

void AreaCoverage::add(std::span<const ImagePoint<double>> polygon, double weight) {
  if (polygon.size() < 3) return;
  double twice_area = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const ImagePoint<double>& p = polygon[i];
    const ImagePoint<double>& q = polygon[(i + 1) % polygon.size()];
    twice_area += (p.column - polygon[0].column) * (q.row - polygon[0].row) -
                  (q.column - polygon[0].column) * (p.row - polygon[0].row);
  }
  // With columns to the right and rows down, a positive area has its left side run upwards.
  const double signed_weight = twice_area > 0 ? -weight : weight;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    add_edge(polygon[i], polygon[(i + 1) % polygon.size()], signed_weight);
}

void AreaCoverage::add_edge(ImagePoint<double> from, ImagePoint<double> to, double weight) {
  if (from.row == to.row) return;
  if (from.row > to.row) {
    std::swap(from, to);
    weight = -weight;
  }
  // From here on rows and columns count from the image's top left corner.
  const double slope = (to.column - from.column) / (to.row - from.row);
  const double origin = from.column + 0.5 - slope * (from.row + 0.5);
  const double begin = std::max(from.row + 0.5, 0.0);
  const double end = std::min(to.row + 0.5, static_cast<double>(rows_));
  for (double top = begin; top < end;) {
    const double row = std::floor(top);
    const double bottom = std::min(row + 1, end);
    const double x_top = origin + slope * top;
    const double x_bottom = origin + slope * bottom;
    add_in_row(static_cast<std::size_t>(row), std::min(x_top, x_bottom), std::max(x_top, x_bottom),
               weight * (bottom - top));
    top = bottom;
  }
}

void AreaCoverage::add_in_row(std::size_t row, double left, double right, double signed_height) {
  double* differences = differences_.data() + row * (columns_ + 1);
  const auto width = static_cast<double>(columns_);
  if (left >= width) return;
  if (right <= 0) {
    differences[0] += signed_height;
    return;
  }
  const double per_column = right > left ? signed_height / (right - left) : 0;
  if (left < 0) {
    differences[0] -= left * per_column;
    left = 0;
  }
  right = std::min(right, width);
  double x = left;
  do {
    const double column = std::min(std::floor(x), width - 1);
    const double next = std::min(column + 1, right);
    const double height = per_column != 0 ? per_column * (next - x) : signed_height;
    const double inside = 0.5 * (x + next) - column;
    const auto j = static_cast<std::size_t>(column);
    differences[j] += height * (1 - inside);
    differences[j + 1] += height * inside;
    x = next;
  } while (x < right);
}

std::vector<double> AreaCoverage::values(double base) const {
  std::vector<double> result(rows_ * columns_);
  for (std::size_t i = 0; i < rows_; ++i) {
    double sum = base;
    for (std::size_t j = 0; j < columns_; ++j) {
      sum += differences_[i * (columns_ + 1) + j];
      result[i * columns_ + j] = sum;
    }
  }
  return result;
}

}  // namespace ilss
