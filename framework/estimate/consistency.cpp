#include "framework/estimate/consistency.h"

#include <Eigen/Eigenvalues>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace ilss {

NormalizedError normalized_squared_error(const Eigen::VectorXd& error,
                                         const Eigen::MatrixXd& covariance) {
  // A NaN anywhere would compare false below and so pass for a perfect estimate.
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (!error.allFinite() || !covariance.allFinite())
    return {infinity, static_cast<int>(error.size()), infinity};
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
    if (scale[i] == 0 && error[i] != 0) result.unexplained = infinity;
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
  // The lineage of a - b rather than P_a + P_b - P_ab - P_ba: errors that they share cancel exactly
  // there, and leave no rounding that would pass for variance.
  const Eigen::VectorXd apart = difference(a, b.value);
  const std::span<const double> components(apart.data(), a.dimension());
  const Eigen::MatrixXd by_a = difference_by_first(*a.type, components);
  const Eigen::MatrixXd by_b = difference_by_second(*a.type, components);
  const LineageTerm terms[] = {{by_a.data(), &a.lineage}, {by_b.data(), &b.lineage}};
  Lineage innovation;
  compose(terms, a.dimension(), innovation);
  return normalized_squared_error(apart, innovation.covariance());
}

Eigen::MatrixXd independent_covariance(const Estimate& a, const Estimate& b) {
  if (is_flat(*a.type)) return a.lineage.covariance() + b.lineage.covariance();
  const Eigen::VectorXd apart = difference(a, b.value);
  const std::span<const double> components(apart.data(), a.dimension());
  const Eigen::MatrixXd by_a = difference_by_first(*a.type, components);
  const Eigen::MatrixXd by_b = difference_by_second(*a.type, components);
  return by_a * a.lineage.covariance() * by_a.transpose() +
         by_b * b.lineage.covariance() * by_b.transpose();
}

Interval chi_square_interval(double degrees_of_freedom, double probability) {
  const double tail = (1 - probability) / 2;
  return {chi_square_quantile(degrees_of_freedom, tail),
          chi_square_quantile(degrees_of_freedom, 1 - tail)};
}

double coverage_factor(double degrees_of_freedom, double probability) {
  if (std::isinf(degrees_of_freedom)) return std::sqrt(chi_square_quantile(1, probability));
  return quantile(boost::math::students_t(degrees_of_freedom), (1 + probability) / 2);
}

double chi_square_quantile(double degrees_of_freedom, double probability) {
  if (!(degrees_of_freedom > 0) || !(probability > 0 && probability < 1))
    throw std::invalid_argument(
        "a chi-square quantile needs degrees of freedom above 0 and a "
        "probability between 0 and 1");
  return quantile(boost::math::chi_squared(degrees_of_freedom), probability);
}

}  // namespace ilss
