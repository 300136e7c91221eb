// Eigenvalues and directions of small symmetric matrices, by Eigen, compiled once for all dimensions.
#pragma once

#include <array>

namespace recon::detail {

struct SymmetricEigen {
  std::array<double, 3> values;                    // ascending
  std::array<std::array<double, 3>, 3> direction;  // of each value, of length one
};

// Of the D x D numbers at `matrix`, row by row; what is beyond D in the result is no part of it.
SymmetricEigen symmetric_eigen(int D, const double* matrix);

}  // namespace recon::detail
