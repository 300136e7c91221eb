// Small vectors and matrices of the driver. D is the number of space dimensions: 1 (uniaxial
// strain), 2 (plane strain) or 3.
#pragma once

#include <Eigen/Core>

namespace recon::mpm {

template <int D>
using Vector = Eigen::Matrix<double, D, 1>;
template <int D>
using Matrix = Eigen::Matrix<double, D, D>;

}  // namespace recon::mpm
