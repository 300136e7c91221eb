// Reference solvers, by Eigen in compiled code: pivoted QR and SVD of the weighted basis
// A = diag(sqrt w) m.
//
// Slow and simple, to check the other solvers with and to compare their cost with. With Householder
// QR, A P = Q R, the orthonormal columns are those of Q with jets R^-T P^T origin; with A = U S V^T
// they are those of U with jets S^-1 V^T origin. Both decide rank by magnitude over all terms at
// once, which can lose even the constant; so a target that they find deficient is handed over to
// Gram-Schmidt like an ill-conditioned moment matrix.
#pragma once

#include <cmath>
#include <type_traits>
#include <vector>

#include "recon/basis/monomials.hpp"
#include "recon/local_solve/fill_report.hpp"
#include "recon/local_solve/local_cloud.hpp"
#include "recon/local_solve/orthonormal_fit.hpp"

namespace recon {

namespace detail {

// Scales the columns of an n x terms matrix to length one, factorises it, and overwrites them by
// orthonormal ones. `jets`, terms x count, has what the terms are at the target, and gets what the
// orthonormal polynomials are there. Both are column-major. Returns the smallest singular value, or
// diagonal entry of R, relative to the largest; 0 where a column is zero or one of the first
// `linear` not longer than `shortest`.
template <class Work>
Work factorise_by_reference(Solver solver, int n, int terms, int linear, Work shortest, int count,
                            Work* columns, Work* jets);
extern template double factorise_by_reference(Solver, int, int, int, double, int, double*, double*);
extern template long double factorise_by_reference(Solver, int, int, int, long double, int,
                                                   long double*, long double*);

}  // namespace detail

template <class T, Basis B>
class ReferenceFit {
 public:
  static constexpr int D = B::dimension;

  ReferenceFit(Solver solver, FitTolerances tolerances = {})
      : solver_(solver), tolerances_(tolerances) {}

  // False where the target must be handed over; the report is then unfinished.
  bool fit(const LocalCloud<T, D>& cloud, FitReport& report) {
    fit_.start(cloud, B::size);
    if (cloud.size < B::size) return false;
    const int n = cloud.size;
    // Floats are treated in double: Eigen's sums are plain, and lose three digits over a
    // million particles.
    using Work = std::conditional_t<std::is_same_v<T, float>, double, T>;
    constexpr int jets = detail::jet_size(D);
    std::vector<Work> a(static_cast<std::size_t>(n) * B::size), at_target(B::size * jets);
    Work weight_sum = Work(0);
    for (int p = 0; p < n; ++p) {
      std::array<T, B::size> values;
      B::evaluate(cloud.at(p), values.data());
      for (int j = 0; j < B::size; ++j) a[j * n + p] = fit_.root_weights()[p] * values[j];
      weight_sum += Work(cloud.w[p]);
    }
    // All columns get the same length, as in the moment matrix scaled to unit diagonal.
    const detail::Thresholds<T> thresholds(tolerances_, cloud.noise);
    const Work shortest = std::sqrt(Work(thresholds.clear2) * weight_sum);
    for (int j = 0; j < B::size; ++j)
      for (int c = 0; c < jets; ++c) at_target[c * B::size + j] = Work(B::origin(j, c));
    const Work smallest =
        detail::factorise_by_reference<Work>(solver_, n, B::size, B::degree >= 1 ? B::begin(2) : 0,
                                             shortest, jets, a.data(), at_target.data());
    if (!(smallest * smallest > thresholds.clear2)) return false;
    for (int j = 0; j < B::size; ++j) {
      for (int p = 0; p < n; ++p) fit_.next_column()[p] = T(a[j * n + p]);
      for (int c = 0; c < jets; ++c) fit_.next_jet()[c] = T(at_target[c * B::size + j]);
      fit_.keep();
    }
    const T amplification2 = T(weight_sum) * fit_.christoffel();
    if (!(amplification2 <= T(tolerances_.leverage * tolerances_.leverage))) return false;
    report = detail::report_of<B>({solver_, static_cast<std::uint32_t>(n),
                                   static_cast<float>(smallest * smallest),
                                   static_cast<float>(std::sqrt(amplification2))});
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
