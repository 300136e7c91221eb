// Reference solvers on Eigen: pivoted QR and SVD of the weighted basis A = diag(sqrt w) m.
//
// Slow and simple, to check the other solvers with and to compare their cost with. With Householder
// QR, A P = Q R, the orthonormal columns are those of Q with jets R^-T P^T origin; with A = U S V^T
// they are those of U with jets S^-1 V^T origin. Both decide rank by magnitude over all terms at
// once, which can lose even the constant; so a target that they find deficient is handed over to
// Gram-Schmidt like an ill-conditioned moment matrix.
#pragma once

#include <Eigen/Core>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <type_traits>

#include "recon/basis/monomials.hpp"
#include "recon/local_solve/local_cloud.hpp"
#include "recon/local_solve/orthonormal_fit.hpp"

namespace recon {

template <class T, Basis B>
class ReferenceFit {
 public:
  static constexpr int D = B::dimension;

  ReferenceFit(Solver solver, FitTolerances tolerances = {})
      : solver_(solver), tolerances_(tolerances) {}

  // False where the target must be handed over; the report is then unfinished.
  bool fit(const LocalCloud<T, D>& cloud, FitReport& report) {
    report = {};
    report.solver = solver_;
    report.neighbours = static_cast<std::uint32_t>(cloud.size);
    fit_.start(cloud, B::size);
    if (cloud.size < B::size) return false;
    const int n = cloud.size;
    // Floats are treated in double: Eigen's sums are plain, and lose three digits over a
    // million particles.
    using Work = std::conditional_t<std::is_same_v<T, float>, double, T>;
    using Matrix = Eigen::Matrix<Work, Eigen::Dynamic, Eigen::Dynamic>;
    Matrix a(n, B::size);
    Work weight_sum = Work(0);
    for (int p = 0; p < n; ++p) {
      std::array<T, B::size> values;
      B::evaluate(cloud.at(p), values.data());
      for (int j = 0; j < B::size; ++j) a(p, j) = fit_.root_weights()[p] * values[j];
      weight_sum += Work(cloud.w[p]);
    }
    // Scales all columns to the same length, as in the moment matrix scaled to unit diagonal.
    const Eigen::Matrix<Work, 1, Eigen::Dynamic> length = a.colwise().norm();
    const detail::Thresholds<T> thresholds(tolerances_, cloud.noise);
    const Work shortest = std::sqrt(Work(thresholds.clear2) * weight_sum);
    for (int j = 0; j < B::size; ++j)
      if (!(length[j] > Work(0)) || (B::degree >= 1 && j < B::begin(2) && !(length[j] > shortest)))
        return false;
    for (int j = 0; j < B::size; ++j) a.col(j) /= length[j];
    Matrix origin(B::size, detail::jet_size(D));
    for (int j = 0; j < B::size; ++j)
      for (int c = 0; c < detail::jet_size(D); ++c)
        origin(j, c) = Work(B::origin(j, c)) / length[j];

    Matrix q, jets;
    Work smallest;  // the smallest singular value or diagonal entry of R, relative to the largest
    if (solver_ == Solver::qr) {
      const Eigen::ColPivHouseholderQR<Matrix> qr(a);
      const Matrix r = qr.matrixR().topRows(B::size);
      smallest = std::abs(r(B::size - 1, B::size - 1) / r(0, 0));
      q = qr.householderQ() * Matrix::Identity(n, B::size);
      jets = r.template triangularView<Eigen::Upper>().transpose().solve(
          Matrix(qr.colsPermutation().transpose() * origin));
    } else {
      const Eigen::JacobiSVD<Matrix> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
      const auto& s = svd.singularValues();
      smallest = s[B::size - 1] / s[0];
      q = svd.matrixU();
      jets = s.cwiseInverse().asDiagonal() * (svd.matrixV().transpose() * origin);
    }
    if (!(smallest * smallest > thresholds.clear2)) return false;
    for (int j = 0; j < B::size; ++j) {
      for (int p = 0; p < n; ++p) fit_.next_column()[p] = T(q(p, j));
      for (int c = 0; c < detail::jet_size(D); ++c) fit_.next_jet()[c] = T(jets(j, c));
      fit_.keep();
    }
    const T amplification2 = T(weight_sum) * fit_.christoffel();
    if (!(amplification2 <= T(tolerances_.leverage * tolerances_.leverage))) return false;
    report.smallest_pivot = static_cast<float>(smallest * smallest);
    report.amplification = static_cast<float>(std::sqrt(amplification2));
    detail::report_full<B>(report);
    fit_.template resolve_gradient<B>(T(weight_sum), tolerances_, D, report);
    return true;
  }

  const OrthonormalFit<T, D>& result() const { return fit_; }

  void shape_functions(const LocalCloud<T, D>& cloud, const ShapeArrays<T, D>& out) {
    fit_.shape_functions(cloud, out);
  }

 private:
  Solver solver_;
  FitTolerances tolerances_;
  OrthonormalFit<T, D> fit_;
};

}  // namespace recon
