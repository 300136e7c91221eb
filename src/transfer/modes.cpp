#include "recon/transfer/modes.hpp"

#include "core/symmetric_eigen.hpp"

namespace recon::detail {

template <int D>
int invert_along(const SpaceMatrix<D>& matrix, double least, SpaceMatrix<D>& inverse) {
  const SymmetricEigen parts = symmetric_eigen(D, matrix.data());
  int rank = 0;
  inverse.setZero();
  for (int d = 0; d < D; ++d) {
    if (!(parts.values[d] > least)) continue;
    const Eigen::Map<const SpaceVector<D>> along(parts.direction[d].data());
    inverse += along * along.transpose() / parts.values[d];
    ++rank;
  }
  return rank;
}

template int invert_along<1>(const SpaceMatrix<1>&, double, SpaceMatrix<1>&);
template int invert_along<2>(const SpaceMatrix<2>&, double, SpaceMatrix<2>&);
template int invert_along<3>(const SpaceMatrix<3>&, double, SpaceMatrix<3>&);

}  // namespace recon::detail
