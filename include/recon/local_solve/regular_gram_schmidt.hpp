// Gram-Schmidt where all terms are clearly independent (Tran et al. 2019, eq. 17-19), each term
// projected twice.
//
// The terms of the basis, times sqrt(w_p), become orthonormal columns u_j, graded by degree, the
// constant first. This is the fast half of gram_schmidt.hpp, which also says what happens to the
// rest: a target is regular where every term keeps a clear independent part (Thresholds::clear2 of
// its square), and the whole fit amplifies data errors by no more than the leverage limit, by the
// bound of FitReport::amplification.
//
// T may be a pack (core/pack.hpp), with one target in each lane. Lanes that are not regular go
// through the same arithmetic with harmless numbers; their results are meaningless, and the mask
// that fit() returns excludes them.
//
// Cost: 4 n m^2 multiply-adds for n particles and m terms.
#pragma once

#include <array>
#include <cmath>

#include "recon/core/lanes.hpp"
#include "recon/core/memory.hpp"
#include "recon/core/sums.hpp"
#include "recon/local_solve/local_cloud.hpp"
#include "recon/local_solve/orthonormal_fit.hpp"

namespace recon {

// Memory: core/memory.hpp. `spare` columns more are kept for the caller.
template <class T, Basis B, int jet_order = 2, class Memory = Growing, int spare = 0>
class RegularGramSchmidt {
  using Sizes = OrthonormalFit<T, B::dimension, jet_order>;
  static constexpr std::size_t fixed = Sizes::fixed(B::size), each = Sizes::each(B::size, spare);

 public:
  static constexpr int D = B::dimension;
  using Mask = MaskOf<T>;
  using Result = OrthonormalFit<T, D, jet_order, typename Memory::template Store<T, fixed, each>>;

  // What is taken from a Workspace for this many particles.
  static constexpr std::size_t bytes_for(int most) {
    return Workspace::bytes_for<T>(fixed + each * static_cast<std::size_t>(most));
  }

  constexpr explicit RegularGramSchmidt(FitTolerances tolerances = {}, Memory memory = {})
      : tolerances_(tolerances), fit_(memory.template make<T, fixed, each>()) {}

  // Orthonormalises the basis on the cloud; false where the target is not regular and must go
  // through gram_schmidt.hpp. Whether the gradient is resolved is a question of its own:
  // gradient_resolved().
  constexpr Mask fit(const LocalCloud<T, D>& cloud) {
    const int n = cloud.size;
    fit_.start(cloud, B::size, spare);
    weight_sum_ = detail::sum_of<T>(n, [&](int p) RECON_INLINE_LAMBDA { return cloud.w[p]; });
    smallest_pivot_ = T(1);
    independent_ = Mask(false);
    Mask regular = weight_sum_ > T(0);
    if (n < B::size) return Mask(false);

    const T* const root = fit_.root_weights();
    T* const columns = fit_.column(0);
    for (int p = 0; p < n; ++p) {
      std::array<T, B::size> values;
      B::evaluate(cloud.at(p), values.data());
      for (int j = 0; j < B::size; ++j)
        columns[static_cast<std::size_t>(j) * n + p] = root[p] * values[j];
    }
    const detail::Thresholds<T> thresholds(tolerances_, cloud.noise);
    const T shortest = thresholds.clear2 * weight_sum_;  // a least size for linear terms
    for (int j = 0; j < B::size; ++j) {
      T *const column = fit_.next_column(), *const jet = fit_.next_jet();
      for (int a = 0; a < fit_.jets; ++a) jet[a] = T(static_cast<ScalarOf<T>>(B::origin(j, a)));
      const T whole = square(column, n);
      fit_.project_out(column, jet, j);
      fit_.project_out(column, jet, j);
      const T part = square(column, n);
      regular = regular && part > thresholds.clear2 * whole;
      if (B::degree >= 1 && j < B::begin(2)) regular = regular && part > shortest;
      if (!detail::any_lane(regular)) return regular;
      smallest_pivot_ = detail::smaller(
          detail::select(regular, part, T(1)) / detail::select(regular, whole, T(1)),
          smallest_pivot_);
      const T scale = T(1) / detail::square_root(detail::select(regular, part, T(1)));
      for (int p = 0; p < n; ++p) column[p] *= scale;
      for (int a = 0; a < fit_.jets; ++a) jet[a] *= scale;
      fit_.keep();
    }
    independent_ = regular;
    amplification_ =
        detail::square_root(detail::select(regular, weight_sum_ * fit_.christoffel(), T(0)));
    T total = T(0), largest = T(0);
    for (const T& slope : fit_.slopes2()) {
      total += slope;
      largest = detail::larger(slope, largest);
    }
    gradient_amplification_ =
        detail::square_root(detail::select(regular, weight_sum_ * largest, T(0)));
    gradient_resolved_ =
        weight_sum_ * total <= T(detail::gradient_limit2<ScalarOf<T>>(tolerances_, B::degree));
    return regular && amplification_ <= T(static_cast<ScalarOf<T>>(tolerances_.leverage));
  }

  // Whether all terms are clearly independent. Where they are and fit() is false, the
  // amplification is too large.
  constexpr const Mask& independent() const { return independent_; }
  // Where fit() is true: whether the slope is clearly resolved in all directions.
  constexpr const Mask& gradient_resolved() const { return gradient_resolved_; }
  constexpr const T& gradient_amplification() const { return gradient_amplification_; }
  // FitReport::smallest_pivot and FitReport::amplification; the sum of the weights.
  constexpr const T& smallest_pivot() const { return smallest_pivot_; }
  constexpr const T& amplification() const { return amplification_; }
  constexpr const T& weight_sum() const { return weight_sum_; }

  constexpr const Result& result() const { return fit_; }
  constexpr Result& result() { return fit_; }

  constexpr void shape_functions(const LocalCloud<T, D>& cloud, const ShapeArrays<T, D>& out) {
    fit_.shape_functions(cloud, out);
  }

 private:
  static constexpr T square(const T* a, int n) {
    return detail::sum_of<T>(n, [&](int p) RECON_INLINE_LAMBDA { return a[p] * a[p]; });
  }

  FitTolerances tolerances_;
  Result fit_;
  T weight_sum_ = T(0), smallest_pivot_ = T(1), amplification_ = T(0),
    gradient_amplification_ = T(0);
  Mask independent_ = Mask(false), gradient_resolved_ = Mask(false);
};

}  // namespace recon
