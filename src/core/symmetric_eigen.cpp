#include "core/symmetric_eigen.hpp"

#include <Eigen/Eigenvalues>
#include <utility>

namespace recon::detail {
namespace {

// By one rotation, [c s; -s c] in Eigen's signs.
SymmetricEigen of_a_plane(double xx, double xy, double yy) {
  Eigen::JacobiRotation<double> turn;
  turn.makeJacobi(xx, xy, yy);
  const double c = turn.c(), s = turn.s(), change = s / c * xy;
  SymmetricEigen found{{xx - change, yy + change}, {{{c, -s}, {s, c}}}};
  if (found.values[1] < found.values[0]) {
    std::swap(found.values[0], found.values[1]);
    std::swap(found.direction[0], found.direction[1]);
  }
  return found;
}

}  // namespace

SymmetricEigen symmetric_eigen(int D, const double* matrix) {
  if (D == 1) return {{matrix[0]}, {{{1}}}};
  if (D == 2) return of_a_plane(matrix[0], matrix[1], matrix[3]);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> parts(
      Eigen::Map<const Eigen::Matrix3d>{matrix});
  SymmetricEigen found;
  for (int d = 0; d < 3; ++d) {
    found.values[d] = parts.eigenvalues()[d];
    for (int c = 0; c < 3; ++c) found.direction[d][c] = parts.eigenvectors()(c, d);
  }
  return found;
}

}  // namespace recon::detail
