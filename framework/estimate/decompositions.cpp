#include "framework/estimate/decompositions.h"

namespace ilss {

Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> symmetric_eigen(const Eigen::MatrixXd& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix);
}

Eigen::SelfAdjointEigenSolver<ComponentMatrix> symmetric_eigen(const ComponentMatrix& matrix) {
  return Eigen::SelfAdjointEigenSolver<ComponentMatrix>(matrix);
}

Eigen::LLT<Eigen::MatrixXd> cholesky(const Eigen::MatrixXd& matrix) {
  return Eigen::LLT<Eigen::MatrixXd>(matrix);
}

Eigen::LLT<ComponentMatrix> cholesky(const ComponentMatrix& matrix) {
  return Eigen::LLT<ComponentMatrix>(matrix);
}

Eigen::MatrixXd inverse_of_positive(const Eigen::MatrixXd& matrix) {
  return cholesky(matrix).solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
}

PivotedQr pivoted_qr(const Eigen::MatrixXd& matrix) { return PivotedQr(matrix); }

Eigen::MatrixXd solve(const PivotedQr& qr, const Eigen::MatrixXd& right) { return qr.solve(right); }

Eigen::MatrixXd qr_triangle(const Eigen::MatrixXd& matrix) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(matrix);
  return qr.matrixQR().topRows(matrix.cols()).triangularView<Eigen::Upper>().toDenseMatrix();
}

Svd singular_values(const Eigen::MatrixXd& matrix, unsigned vectors) {
  return Svd(matrix, vectors);
}

}  // namespace ilss
