// The ellipse in which a point of the plane lies with a given probability.
#pragma once

#include <Eigen/Core>

namespace ilss {

/// Half axes in the unit of the point; the longer one runs at `angle` (rad) from the first
/// coordinate's axis towards the second's.
struct ErrorEllipse {
  double major = 0;
  double minor = 0;
  double angle = 0;
};

/// Of a normal error with this covariance, which may be singular: sqrt(chi² quantile · eigenvalue)
/// along each eigenvector.
ErrorEllipse error_ellipse(const Eigen::Matrix2d& covariance, double probability);

}  // namespace ilss
