// Inverses of symmetric matrices on a GPU, as those of transfer/modes.hpp on the processor.
#pragma once

#include "gpu/matrix.hpp"
#include "recon/core/lanes.hpp"
#include "recon/transfer/modes.hpp"

namespace recon::mpm {

// Turns a symmetric matrix into a diagonal one by rotations of two axes at a time (Jacobi 1846);
// the columns of the result are the directions of its diagonal.
template <int D>
RECON_DEVICE SmallMatrix<D> turn_to_axes(SmallMatrix<D>& matrix) {
  auto directions = SmallMatrix<D>::Identity();
  for (int sweep = 0; sweep < 30; ++sweep)
    for (int a = 0; a < D; ++a)
      for (int b = a + 1; b < D; ++b) {
        const double off = matrix(a, b);
        if (off == 0) continue;
        const double zeta = (matrix(b, b) - matrix(a, a)) / (2 * off);
        const double size = zeta < 0 ? -zeta : zeta;
        const double t = (zeta < 0 ? -1 : 1) / (size + recon::detail::square_root(1 + zeta * zeta));
        const double c = 1 / recon::detail::square_root(1 + t * t), s = c * t;
        for (int k = 0; k < D; ++k) {
          const double one = matrix(k, a), two = matrix(k, b);
          matrix(k, a) = c * one - s * two;
          matrix(k, b) = s * one + c * two;
        }
        for (int k = 0; k < D; ++k) {
          const double one = matrix(a, k), two = matrix(b, k);
          matrix(a, k) = c * one - s * two;
          matrix(b, k) = s * one + c * two;
          const double first = directions(k, a), second = directions(k, b);
          directions(k, a) = c * first - s * second;
          directions(k, b) = s * first + c * second;
        }
        matrix(a, b) = matrix(b, a) = 0;
      }
  return directions;
}

// The inverse on the directions whose eigenvalues are above `least`, zero on the others.
template <int D>
RECON_DEVICE SmallMatrix<D> invert_where_seen(SmallMatrix<D> matrix, double least) {
  if (recon::detail::exceeds_along_all(matrix, least)) return matrix.inverse();
  const auto directions = turn_to_axes(matrix);
  auto inverse = SmallMatrix<D>::Zero();
  for (int k = 0; k < D; ++k) {
    if (!(matrix(k, k) > least)) continue;
    for (int r = 0; r < D; ++r)
      for (int c = 0; c < D; ++c)
        inverse(r, c) += directions(r, k) * directions(c, k) / matrix(k, k);
  }
  return inverse;
}

}  // namespace recon::mpm
