#include "recon/local_solve/reference.hpp"

#include <Eigen/Core>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "core/instantiate.hpp"

namespace recon::detail {

template <class Work>
Work factorise_by_reference(Solver solver, int n, int terms, int linear, Work shortest, int count,
                            Work* columns, Work* jets) {
  using Matrix = Eigen::Matrix<Work, Eigen::Dynamic, Eigen::Dynamic>;
  Eigen::Map<Matrix> q(columns, n, terms), at_target(jets, terms, count);
  Matrix a = q, origin = at_target;
  const Eigen::Matrix<Work, 1, Eigen::Dynamic> length = a.colwise().norm();
  for (int j = 0; j < terms; ++j)
    if (!(length[j] > Work(0)) || (j < linear && !(length[j] > shortest))) return Work(0);
  for (int j = 0; j < terms; ++j) {
    a.col(j) /= length[j];
    for (int c = 0; c < count; ++c) origin(j, c) /= length[j];
  }
  const Eigen::ColPivHouseholderQR<Matrix> qr(a);
  const Matrix r = qr.matrixR().topRows(terms).template triangularView<Eigen::Upper>();
  origin = qr.colsPermutation().transpose() * origin;
  q = qr.householderQ() * Matrix::Identity(n, terms);
  if (solver == Solver::qr) {
    at_target = r.template triangularView<Eigen::Upper>().transpose().solve(origin);
    return std::abs(r(terms - 1, terms - 1) / r(0, 0));
  }
  // R = U S V^T gives A P = (Q U) S V^T.
  const Eigen::JacobiSVD<Matrix, Eigen::NoQRPreconditioner> svd(
      r, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const auto& s = svd.singularValues();
  q = q * svd.matrixU();
  at_target = s.cwiseInverse().asDiagonal() * (svd.matrixV().transpose() * origin);
  return s[terms - 1] / s[0];
}

template double factorise_by_reference(Solver, int, int, int, double, int, double*, double*);
RECON_FLOAT(template long double factorise_by_reference(Solver, int, int, int, long double, int,
                                                        long double*, long double*);)

}  // namespace recon::detail
