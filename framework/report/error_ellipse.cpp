#include "framework/report/error_ellipse.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "framework/estimate/consistency.h"

namespace ilss {

ErrorEllipse error_ellipse(const Eigen::Matrix2d& covariance, double probability) {
  const double mean = (covariance(0, 0) + covariance(1, 1)) / 2;
  const double half_difference = (covariance(0, 0) - covariance(1, 1)) / 2;
  const double largest = mean + std::hypot(half_difference, covariance(0, 1));
  if (!(largest > 0)) return {};
  // By the determinant, since the difference would lose the smaller one of a thin ellipse.
  const double smallest = std::max(0.0, covariance.determinant() / largest);
  const double factor = std::sqrt(chi_square_quantile(2, probability));
  return {factor * std::sqrt(largest), factor * std::sqrt(smallest),
          std::atan2(covariance(0, 1), half_difference) / 2};
}

}  // namespace ilss
