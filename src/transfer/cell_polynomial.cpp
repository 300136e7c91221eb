#include "recon/transfer/cell_polynomial.hpp"

#include <Eigen/QR>

namespace recon {

using detail::require;

template <int D>
Eigen::RowVectorXd CellPolynomial<D>::psi(const SpaceVector<D>& x) const {
  const SpaceVector<D> xi = (x - centre_) / half_edge_;
  Eigen::RowVectorXd row(coefficients_.rows());
  row[0] = 1;
  int k = 1;
  for (int d = 0; d < D && k < row.size(); ++d) row[k++] = xi[d];
  for (int d = 0; d < D && k < row.size(); ++d)
    for (int e = d; e < D; ++e) row[k++] = d == e ? xi[d] * xi[d] / 2 - 1.0 / 6 : xi[d] * xi[e];
  return row;
}

template <int D>
Eigen::RowVectorXd CellPolynomial<D>::operator()(const SpaceVector<D>& x) const {
  require(coefficients_.size() > 0, "polynomial of a cell", "none", "needs a fit() before");
  return psi(x) * coefficients_;
}

template <int D>
void CellPolynomial<D>::fit(const CartesianGrid<D>& grid, std::size_t cell,
                            std::span<const SpaceVector<D>> places, const Eigen::MatrixXd& u,
                            const Eigen::RowVectorXd& mean, const std::vector<bool>& conserved) {
  constexpr int linear = 1 + D, quadratic = linear + D * (D + 1) / 2;
  const auto count = static_cast<int>(places.size());
  require(cell < grid.cell_count(), "number of the cell", cell, "must be one of the grid's");
  require(count > 0, "places in a cell", count, "must be at least one");
  require(u.rows() == count, "rows of the data", u.rows(), "must be one for each place");
  require(mean.size() == u.cols(), "means", mean.size(), "must be one for each column");
  require(static_cast<Eigen::Index>(conserved.size()) == u.cols(), "conserved columns",
          conserved.size(), "must be told for each column");
  require(u.allFinite(), "data of a cell", u.sum(), "must be finite");
  require(mean.allFinite(), "means of a cell", mean.sum(), "must be finite");
  const int terms = count > quadratic ? quadratic : count > linear ? linear : 1;
  half_edge_ = grid.h() / 2;
  centre_ = cell_corner(grid, cell).array() + half_edge_;
  coefficients_.setZero(terms, u.cols());  // psi() has as many functions

  Eigen::MatrixXd A(count, terms), rest = u;
  for (int k = 0; k < count; ++k) {
    grid.require_point(places[static_cast<std::size_t>(k)]);
    A.row(k) = psi(places[static_cast<std::size_t>(k)]);
  }
  for (int column = 0; column < u.cols(); ++column)
    if (conserved[column]) rest.col(column).array() -= mean[column];
  Eigen::MatrixXd all = A.completeOrthogonalDecomposition().solve(rest);
  Eigen::MatrixXd kept(terms, u.cols());
  kept.row(0) = mean;
  if (terms > 1)
    kept.bottomRows(terms - 1) =
        A.rightCols(terms - 1).completeOrthogonalDecomposition().solve(rest);
  for (int column = 0; column < u.cols(); ++column)
    if (conserved[column]) all.col(column) = kept.col(column);
  coefficients_ = std::move(all);
}

template class CellPolynomial<1>;
template class CellPolynomial<2>;
template class CellPolynomial<3>;

}  // namespace recon
