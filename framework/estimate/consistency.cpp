#include "framework/estimate/consistency.h"

#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "framework/estimate/decompositions.h"

namespace ilss {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double relative_rank_tolerance = 1e-10;

/// The part of normalized_squared_error that is a matter of the components that have an error;
/// `scaled` is the error in their standard deviations, and `dimension` counts all components.
/// Components may have different units, so the rank is judged on the correlation matrix.
template <typename Vector, typename Matrix>
void add_normalized(const Vector& scaled, const Matrix& correlation, Eigen::Index dimension,
                    NormalizedError& result) {
  // An eigenvalue is at least the determinant divided by e, since all together are n: where that is
  // well above the tolerance the rank is full, and Cholesky's factor is enough.
  constexpr double clearly_regular = 1e-6;
  const auto factors = cholesky(correlation);
  if (factors.info() == Eigen::Success) {
    const double root = factors.matrixLLT().diagonal().prod();
    if (root * root > clearly_regular) {
      const Vector white = factors.matrixL().solve(scaled);
      result.value = white.squaredNorm();
      result.rank = static_cast<int>(scaled.size());
      return;
    }
  }
  const auto eigen = symmetric_eigen(correlation);
  const Vector along = eigen.eigenvectors().transpose() * scaled;
  for (Eigen::Index i = 0; i < scaled.size(); ++i) {
    const double eigenvalue = eigen.eigenvalues()[i];
    if (eigenvalue > relative_rank_tolerance * static_cast<double>(dimension)) {
      result.value += along[i] * along[i] / eigenvalue;
      ++result.rank;
    } else {
      result.unexplained = std::max(result.unexplained, std::abs(along[i]));
    }
  }
}

/// As normalized_squared_error, with matrices of type Matrix to work with.
template <typename Matrix>
NormalizedError normalized(const Eigen::Ref<const Eigen::VectorXd>& error,
                           const Eigen::Ref<const Eigen::MatrixXd>& covariance) {
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, Matrix::MaxRowsAtCompileTime, 1>;
  NormalizedError result{0, 0, 0};
  Vector scale(error.size());   // of the components that have an error, which come first here, ...
  Vector scaled(error.size());  // ... and their errors
  Eigen::Matrix<Eigen::Index, Eigen::Dynamic, 1, 0, Matrix::MaxRowsAtCompileTime, 1> at(
      error.size());
  Eigen::Index n = 0;
  for (Eigen::Index i = 0; i < error.size(); ++i) {
    if (covariance(i, i) > 0) {
      scale[n] = std::sqrt(covariance(i, i));
      scaled[n] = error[i] / scale[n];
      at[n++] = i;
    } else if (error[i] != 0) {
      result.unexplained = infinity;
    }
  }
  if (n == 0) return result;
  Matrix correlation = Matrix::Identity(n, n);
  for (Eigen::Index c = 0; c < n; ++c)
    for (Eigen::Index r = c + 1; r < n; ++r)
      correlation(r, c) = correlation(c, r) = covariance(at[r], at[c]) / (scale[r] * scale[c]);
  add_normalized<Vector, Matrix>(scaled.head(n), correlation, error.size(), result);
  return result;
}

/// As nis, of payloads without rotations in space, on the stack. From the sources of both rather
/// than as P_a + P_b - P_ab - P_ba: errors that they share cancel exactly there, and leave no
/// rounding that would pass for variance.
NormalizedError flat_nis(const Estimate& a, const Estimate& b) {
  constexpr std::size_t most = Fields::capacity;
  const auto m = static_cast<Eigen::Index>(a.dimension());
  std::array<double, most> error;
  difference(*a.type, a.value, b.value, std::span(error).first(a.dimension()));
  std::array<double, most * most> buffer;
  Eigen::Map<Eigen::MatrixXd> covariance(buffer.data(), m, m);
  covariance.setZero();
  const auto column = [](const Lineage& lineage, std::size_t k) {
    return lineage.factor().col(static_cast<Eigen::Index>(k));
  };
  const std::span<const Source> of_a = a.lineage.sources();
  const std::span<const Source> of_b = b.lineage.sources();
  ComponentVector apart(m);
  for (std::size_t i = 0, j = 0; i < of_a.size() || j < of_b.size();) {
    const bool in_a = i < of_a.size() && (j == of_b.size() || of_a[i] <= of_b[j]);
    const bool in_b = j < of_b.size() && (i == of_a.size() || of_b[j] <= of_a[i]);
    if (in_a && in_b)
      apart = column(a.lineage, i) - column(b.lineage, j);
    else
      apart = in_a ? column(a.lineage, i) : column(b.lineage, j);
    i += in_a ? 1 : 0;
    j += in_b ? 1 : 0;
    for (Eigen::Index c = 0; c < m; ++c)
      for (Eigen::Index r = 0; r < m; ++r) covariance(r, c) += apart[r] * apart[c];
  }
  return normalized_squared_error(Eigen::Map<const Eigen::VectorXd>(error.data(), m), covariance);
}

}  // namespace

NormalizedError normalized_squared_error(const Eigen::Ref<const Eigen::VectorXd>& error,
                                         const Eigen::Ref<const Eigen::MatrixXd>& covariance) {
  // A NaN anywhere would compare false below and so pass for a perfect estimate.
  if (!error.allFinite() || !covariance.allFinite())
    return {infinity, static_cast<int>(error.size()), infinity};
  if (error.size() <= most_components) return normalized<ComponentMatrix>(error, covariance);
  return normalized<Eigen::MatrixXd>(error, covariance);
}

NormalizedError nees(const Estimate& estimate, std::span<const double> truth) {
  return normalized_squared_error(difference(estimate, truth), estimate.lineage.covariance());
}

NormalizedError nis(const Estimate& a, const Estimate& b) {
  if (is_flat(*a.type) && a.dimension() <= Fields::capacity) return flat_nis(a, b);
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
