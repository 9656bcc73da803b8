// Decompositions of matrices whose size is known at run time only. Eigen has them as templates,
// which cost seconds of compiling in every file that uses one: they are compiled here.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "framework/estimate/fields.h"

namespace ilss {

/// Of as many rows and columns as a payload may have components, on the stack.
using ComponentMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, Fields::capacity, Fields::capacity>;
constexpr auto most_components = static_cast<Eigen::Index>(Fields::capacity);
using ComponentVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, Fields::capacity, 1>;

/// Eigenvalues, rising, and eigenvectors of a symmetric matrix.
Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> symmetric_eigen(const Eigen::MatrixXd& matrix);
Eigen::SelfAdjointEigenSolver<ComponentMatrix> symmetric_eigen(const ComponentMatrix& matrix);

/// The factor L of a positive definite matrix L Lᵀ; `info` says whether it is one.
Eigen::LLT<Eigen::MatrixXd> cholesky(const Eigen::MatrixXd& matrix);
Eigen::LLT<ComponentMatrix> cholesky(const ComponentMatrix& matrix);

/// The inverse of a positive definite matrix.
Eigen::MatrixXd inverse_of_positive(const Eigen::MatrixXd& matrix);

/// Q R with columns exchanged, which shows the rank.
using PivotedQr = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;
PivotedQr pivoted_qr(const Eigen::MatrixXd& matrix);

/// The least-squares solution X of A X = right, by A's factors.
Eigen::MatrixXd solve(const PivotedQr& qr, const Eigen::MatrixXd& right);

/// R (n x n, upper triangle) of A = Q R (m x n, m >= n).
Eigen::MatrixXd qr_triangle(const Eigen::MatrixXd& matrix);

/// U diag(singular values, falling) Vᵀ; `vectors` says which are wanted (Eigen::ComputeThinU, ...).
using Svd = Eigen::JacobiSVD<Eigen::MatrixXd>;
Svd singular_values(const Eigen::MatrixXd& matrix, unsigned vectors);

}  // namespace ilss
