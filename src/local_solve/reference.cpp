#include "recon/local_solve/reference.hpp"

#include <Eigen/Core>
#include <Eigen/QR>
#include <Eigen/SVD>

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
  if (solver == Solver::qr) {
    const Eigen::ColPivHouseholderQR<Matrix> qr(a);
    const Matrix r = qr.matrixR().topRows(terms);
    q = qr.householderQ() * Matrix::Identity(n, terms);
    at_target = r.template triangularView<Eigen::Upper>().transpose().solve(
        Matrix(qr.colsPermutation().transpose() * origin));
    return std::abs(r(terms - 1, terms - 1) / r(0, 0));
  }
  const Eigen::JacobiSVD<Matrix> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const auto& s = svd.singularValues();
  q = svd.matrixU();
  at_target = s.cwiseInverse().asDiagonal() * (svd.matrixV().transpose() * origin);
  return s[terms - 1] / s[0];
}

template double factorise_by_reference(Solver, int, int, int, double, int, double*, double*);
template long double factorise_by_reference(Solver, int, int, int, long double, int, long double*,
                                            long double*);

}  // namespace recon::detail
