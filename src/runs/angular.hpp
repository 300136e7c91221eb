// Angular momentum about the origin.
#pragma once

#include <array>

#include "recon/mpm/types.hpp"

namespace recon::mpm {

// The cross product x x p: its last component in 2-D, zero in 1-D.
template <int D>
void add_angular(std::array<double, 3>& sum, const Vector<D>& x, const Vector<D>& p) {
  if constexpr (D >= 2) sum[2] += x[0] * p[1] - x[1] * p[0];
  if constexpr (D == 3) {
    sum[0] += x[1] * p[2] - x[2] * p[1];
    sum[1] += x[2] * p[0] - x[0] * p[2];
  }
}

}  // namespace recon::mpm
