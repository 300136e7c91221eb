// Polynomials of single cells that keep sums: what quadrature at Gauss points needs of particle
// data (Wobbes, Moller, Galavi, Vuik 2018).
//
//     u(x) = a_1 + sum_k a_k psi_k(xi) ,   xi = (x - x_c) / (h / 2) ,
//     psi: xi_d ,  xi_d^2 / 2 - 1/6 ,  xi_d xi_e ,  all of mean zero over the cell.
//
// For columns that are conserved a_1 is a given mean over the cell, such as the sum of the
// particles' masses over its volume, so that the integral of u is theirs whatever the rest; a_k by
// least squares of u_p - a_1. For all other columns every coefficient is by least squares. The
// quadratic psi take more points than there are functions, and so do the linear ones; with fewer
// points u is linear or constant. Of coefficients that the points do not determine the smallest are
// taken.
//
// ```cpp
//   const recon::CartesianGrid<1> grid(recon::SpaceVector<1>(0), recon::SpaceVector<1>(1), 0.25);
//   const std::vector<recon::SpaceVector<1>> places{recon::SpaceVector<1>(0.3),
//                                                   recon::SpaceVector<1>(0.35),
//                                                   recon::SpaceVector<1>(0.45)};
//   const Eigen::MatrixXd density = Eigen::MatrixXd::Constant(3, 1, 2.0);  // a row for each place
//   recon::CellPolynomial<1> in_cell;
//   in_cell.fit(grid, 1, places, density, Eigen::RowVectorXd::Constant(1, 1.9), {true});
//   const double mean = in_cell(recon::SpaceVector<1>(0.375))[0];  // 1.9, at the middle
// ```
//
// The cost is that of a small QR decomposition for each cell.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "recon/transfer/cells.hpp"

namespace recon {

template <int D>
class CellPolynomial {
 public:
  // u: a row of data for each place, a column for each field. mean: of all columns; only those of
  // columns that are conserved count. Throws InvalidArgument for sizes that do not go together, a
  // cell that there is not, no places, and numbers that are not finite.
  void fit(const CartesianGrid<D>& grid, std::size_t cell, std::span<const SpaceVector<D>> places,
           const Eigen::MatrixXd& u, const Eigen::RowVectorXd& mean,
           const std::vector<bool>& conserved);

  // All columns at x, in or near the cell of the last fit. Throws InvalidArgument without a fit.
  Eigen::RowVectorXd operator()(const SpaceVector<D>& x) const;

 private:
  Eigen::RowVectorXd psi(const SpaceVector<D>& x) const;

  double half_edge_ = 0;
  SpaceVector<D> centre_;
  Eigen::MatrixXd coefficients_;  // a row for each function
};

extern template class CellPolynomial<1>;
extern template class CellPolynomial<2>;
extern template class CellPolynomial<3>;

}  // namespace recon
