// Short names of the driver for the grid and its vectors. D is the number of space dimensions: 1
// (uniaxial strain), 2 (plane strain) or 3.
#pragma once

#include "recon/transfer/cartesian_grid.hpp"

namespace recon::mpm {

template <int D>
using Vector = SpaceVector<D>;
template <int D>
using Matrix = SpaceMatrix<D>;
template <int D>
using Grid = CartesianGrid<D>;

}  // namespace recon::mpm
