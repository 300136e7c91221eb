#include "core/symmetric_eigen.hpp"

#include <Eigen/Eigenvalues>

namespace recon::detail {

SymmetricEigen symmetric_eigen(int D, const double* matrix) {
  // The other axes have a value above all others: these are at most the norm of the matrix.
  Eigen::Matrix3d all = Eigen::Matrix3d::Zero();
  for (int i = 0; i < D; ++i)
    for (int j = 0; j < D; ++j) all(i, j) = matrix[i * D + j];
  const double beyond = 2 * all.norm();
  for (int i = D; i < 3; ++i) all(i, i) = beyond;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> parts(all);
  SymmetricEigen found;
  for (int d = 0; d < 3; ++d) {
    found.values[d] = parts.eigenvalues()[d];
    for (int c = 0; c < 3; ++c) found.direction[d][c] = parts.eigenvectors()(c, d);
  }
  return found;
}

}  // namespace recon::detail
