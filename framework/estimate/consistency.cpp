#include "framework/estimate/consistency.h"

#include <Eigen/Eigenvalues>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace ilss {

NormalizedError normalized_squared_error(const Eigen::VectorXd& error,
                                         const Eigen::MatrixXd& covariance) {
  // Components may have different units, so the rank is judged on the correlation matrix.
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd inverse_scale =
      scale.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const Eigen::MatrixXd correlation =
      inverse_scale.asDiagonal() * covariance * inverse_scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  constexpr double relative_rank_tolerance = 1e-10;
  NormalizedError result{0, 0, 0};
  for (Eigen::Index i = 0; i < error.size(); ++i)
    if (scale[i] == 0 && error[i] != 0)
      result.unexplained = std::numeric_limits<double>::infinity();
  const Eigen::VectorXd normalized =
      eigen.eigenvectors().transpose() * inverse_scale.asDiagonal() * error;
  for (Eigen::Index i = 0; i < error.size(); ++i) {
    const double eigenvalue = eigen.eigenvalues()[i];
    if (eigenvalue > relative_rank_tolerance * static_cast<double>(error.size())) {
      result.value += normalized[i] * normalized[i] / eigenvalue;
      ++result.rank;
    } else {
      result.unexplained = std::max(result.unexplained, std::abs(normalized[i]));
    }
  }
  return result;
}

NormalizedError nees(const Estimate& estimate, std::span<const double> truth) {
  return normalized_squared_error(difference(estimate, truth), estimate.lineage.covariance());
}

NormalizedError nis(const Estimate& a, const Estimate& b) {
  const Eigen::MatrixXd cross = cross_covariance(a.lineage, b.lineage);
  return normalized_squared_error(
      difference(a, b.value),
      a.lineage.covariance() + b.lineage.covariance() - cross - cross.transpose());
}

Interval chi_square_interval(double degrees_of_freedom, double probability) {
  const double tail = (1 - probability) / 2;
  return {chi_square_quantile(degrees_of_freedom, tail),
          chi_square_quantile(degrees_of_freedom, 1 - tail)};
}

double chi_square_quantile(double degrees_of_freedom, double probability) {
  if (!(degrees_of_freedom > 0) || !(probability > 0 && probability < 1))
    throw std::invalid_argument(
        "a chi-square quantile needs degrees of freedom above 0 and a "
        "probability between 0 and 1");
  return quantile(boost::math::chi_squared(degrees_of_freedom), probability);
}

}  // namespace ilss
