#include "framework/semantics/principal_axes.h"

#include <array>
#include <cmath>

#include "framework/estimate/consistency.h"
#include "framework/estimate/decompositions.h"

namespace ilss {
namespace {

constexpr double relative_rank_tolerance = 1e-10;

}  // namespace

template <typename Matrix>
void PrincipalAxes::decompose(const Matrix& covariance) {
  using Vector =
      Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1, 0, Matrix::MaxRowsAtCompileTime, 1>;
  const Vector inverse_scale = covariance.diagonal().unaryExpr(
      [](double variance) { return variance > 0 ? 1 / std::sqrt(variance) : 0.0; });
  Matrix correlation = Matrix::Zero(covariance.rows(), covariance.cols());
  correlation = inverse_scale.asDiagonal() * covariance * inverse_scale.asDiagonal();
  const auto eigen = symmetric_eigen(correlation);
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    const double eigenvalue = eigen.eigenvalues()[i];
    if (eigenvalue <= relative_rank_tolerance * static_cast<double>(dimension_)) continue;
    for (Eigen::Index c = 0; c < covariance.rows(); ++c)
      rows_.push_back(eigen.eigenvectors()(c, i) * inverse_scale[c] / std::sqrt(eigenvalue));
  }
}

void PrincipalAxes::take(const Lineage& lineage) {
  dimension_ = lineage.dimension();
  rows_.clear();
  const auto m = static_cast<Eigen::Index>(dimension_);
  constexpr std::size_t most = Fields::capacity;
  if (m == 0) return;
  if (m == 1) {
    if (const double variance = lineage.variance(0); variance > 0)
      rows_.push_back(1 / std::sqrt(variance));
    return;
  }
  if (dimension_ <= most) {
    std::array<double, most * most> buffer;
    const Eigen::Map<Eigen::MatrixXd> covariance(buffer.data(), m, m);
    lineage.covariance(covariance);
    return decompose(ComponentMatrix(covariance));
  }
  decompose(lineage.covariance());
}

double PrincipalAxes::squared_distance(std::span<const double> offset) const {
  double sum = 0;
  for (const double* row = rows_.data(); row != rows_.data() + rows_.size(); row += dimension_) {
    double x = 0;
    for (std::size_t c = 0; c < dimension_; ++c) x += row[c] * offset[c];
    sum += x * x;
  }
  return sum;
}

double PrincipalAxes::squared_radius_95() const {
  return chi_square_quantile(static_cast<double>(rank()), 0.95);
}

}  // namespace ilss
