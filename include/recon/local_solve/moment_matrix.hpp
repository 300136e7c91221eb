// Moving least squares by the moment matrix (Gong 2015, eq. 3.6-3.8): the fast way where it is
// safe.
//
//     M = sum_p w_p m_p m_p^T = L diag(d) L^T,   M c = m(0),   phi_p = w_p m_p^T c .
// M is scaled to unit diagonal first. Each pivot is then the squared share of a term that is
// independent of the terms before it, between 0 and 1; digits are lost in proportion to 1 / pivot.
// Where the smallest pivot is below a quarter of the working precision (eps^(1/4)), or the fit
// would amplify data errors by more than the leverage limit, the target is handed over to
// Gram-Schmidt: same answer where both work, and a right one where this would not.
//
// For monomials, M has only C(2 degree + D, D) different entries, the moments sum_p w_p xi^alpha:
// those are summed. Cost: that many multiply-adds per particle, m^3 / 6 for the factors.
#pragma once

#include <array>
#include <cmath>

#include "recon/basis/monomials.hpp"
#include "recon/local_solve/gram_schmidt.hpp"
#include "recon/local_solve/local_cloud.hpp"

namespace recon {

template <class T, Basis B>
class MomentMatrix {
 public:
  static constexpr int D = B::dimension;
  static constexpr int m = B::size;
  using Vector = std::array<T, m>;

  explicit MomentMatrix(FitTolerances tolerances = {}) : tolerances_(tolerances) {}

  // Builds and factorises M. False where the target must be handed over; the report is then
  // unfinished.
  bool fit(const LocalCloud<T, D>& cloud, FitReport& report) {
    report = {};
    report.solver = Solver::moment_matrix;
    report.neighbours = static_cast<std::uint32_t>(cloud.size);
    if (cloud.size < m) return false;
    assemble(cloud);
    const T weight_sum = lower_[0][0];
    const detail::Thresholds<T> thresholds(tolerances_, cloud.noise);
    const T regular = thresholds.well_conditioned;
    for (int j = 1; j < B::begin(2) && B::degree >= 1; ++j)
      if (!(lower_[j][j] > regular * regular * weight_sum)) return false;
    const T smallest = factorise();
    if (!(smallest > regular)) return false;
    Vector unit{};
    for (int j = 0; j < m; ++j) unit[j] = T(B::origin(j, 0));
    value_ = solve(unit);
    T christoffel = T(0);
    for (int j = 0; j < m; ++j) christoffel += unit[j] * value_[j];
    const T amplification2 = weight_sum * christoffel;
    if (!(amplification2 <= T(tolerances_.leverage * tolerances_.leverage))) return false;
    report.rcond = static_cast<float>(smallest);
    report.amplification = static_cast<float>(std::sqrt(amplification2));
    detail::report_full<B>(report);
    return true;
  }

  void shape_functions(const LocalCloud<T, D>& cloud, const ShapeArrays<T, D>& out) const {
    const int n = cloud.size;
    std::array<Vector, D> first{};  // M^-1 (dm(0) - what the weights' motion takes)
    constexpr int seconds = D * (D + 1) / 2;
    std::array<Vector, seconds> second{};
    if (out.wants_gradient()) {
      for (int d = 0; d < D; ++d)
        for (int j = 0; j < m; ++j) first[d][j] = T(B::origin(j, 1 + d)) / cloud.rho;
      if (out.kind == Derivative::exact)
        for (int p = 0; p < n; ++p) {
          const Vector terms = evaluate(cloud, p);
          const T lambda = dot(terms, value_);
          for (int d = 0; d < D; ++d)
            for (int j = 0; j < m; ++j) first[d][j] -= cloud.dw[d][p] * lambda * terms[j];
        }
      for (int d = 0; d < D; ++d) first[d] = solve(first[d]);
    }
    if (out.wants_hessian()) {
      int entry = 0;
      for (int a = 0; a < D; ++a)
        for (int b = a; b < D; ++b, ++entry) {
          for (int j = 0; j < m; ++j)
            second[entry][j] =
                T(a == b ? 2 : 1) / (cloud.rho * cloud.rho) * T(B::origin(j, 1 + D + entry));
          second[entry] = solve(second[entry]);
        }
    }
    for (int p = 0; p < n; ++p) {
      const Vector terms = evaluate(cloud, p);
      const T lambda = dot(terms, value_);
      out.value[p] = cloud.w[p] * lambda;
      if (out.wants_gradient())
        for (int d = 0; d < D; ++d) {
          out.gradient[d][p] = cloud.w[p] * dot(terms, first[d]);
          if (out.kind == Derivative::exact) out.gradient[d][p] += cloud.dw[d][p] * lambda;
        }
      if (out.wants_hessian())
        for (int e = 0; e < seconds; ++e) out.hessian[e][p] = cloud.w[p] * dot(terms, second[e]);
    }
  }

 private:
  static T dot(const Vector& a, const Vector& b) {
    T sum = T(0);
    for (int j = 0; j < m; ++j) sum += a[j] * b[j];
    return sum;
  }

  static Vector evaluate(const LocalCloud<T, D>& cloud, int p) {
    Vector terms;
    B::evaluate(cloud.at(p), terms.data());
    return terms;
  }

  void assemble(const LocalCloud<T, D>& cloud) {
    if constexpr (detail::is_monomials<B>) {
      using Moments = Monomials<D, 2 * B::degree>;
      std::array<T, Moments::size> moments{};
      for (int p = 0; p < cloud.size; ++p) {
        std::array<T, Moments::size> powers;
        Moments::evaluate(cloud.at(p), powers.data());
        for (int a = 0; a < Moments::size; ++a) moments[a] += cloud.w[p] * powers[a];
      }
      for (int i = 0; i < m; ++i)
        for (int j = 0; j <= i; ++j) lower_[i][j] = moments[place(i, j)];
    } else {
      lower_ = {};
      for (int p = 0; p < cloud.size; ++p) {
        const Vector terms = evaluate(cloud, p);
        for (int i = 0; i < m; ++i)
          for (int j = 0; j <= i; ++j) lower_[i][j] += cloud.w[p] * terms[i] * terms[j];
      }
    }
  }

  // Where the moment of the product of terms i and j stands.
  static int place(int i, int j) requires detail::is_monomials<B> {
    static constexpr auto table = [] {
      std::array<std::array<std::uint16_t, m>, m> all{};
      for (int a = 0; a < m; ++a)
        for (int b = 0; b < m; ++b) {
          auto e = B::exponents[a];
          for (int d = 0; d < D; ++d) e[d] = static_cast<std::uint8_t>(e[d] + B::exponents[b][d]);
          all[a][b] = static_cast<std::uint16_t>(Monomials<D, 2 * B::degree>::find(e));
        }
      return all;
    }();
    return table[i][j];
  }

  // LDL^T of the matrix scaled to unit diagonal, in place; returns the smallest pivot.
  T factorise() {
    T smallest = T(1);
    for (int i = 0; i < m; ++i) scale_[i] = T(1) / std::sqrt(lower_[i][i]);
    for (int j = 0; j < m; ++j) {
      Vector row;
      T pivot = T(1);
      for (int k = 0; k < j; ++k) {
        row[k] = lower_[j][k] * pivot_[k];
        pivot -= lower_[j][k] * row[k];
      }
      pivot_[j] = pivot;
      smallest = pivot < smallest ? pivot : smallest;
      const T inverse = T(1) / pivot;
      for (int i = j + 1; i < m; ++i) {
        T value = lower_[i][j] * scale_[i] * scale_[j];
        for (int k = 0; k < j; ++k) value -= lower_[i][k] * row[k];
        lower_[i][j] = value * inverse;
      }
      if (!(pivot > T(0))) return T(0);
    }
    return smallest;
  }

  Vector solve(Vector b) const {
    for (int i = 0; i < m; ++i) {
      b[i] *= scale_[i];
      for (int k = 0; k < i; ++k) b[i] -= lower_[i][k] * b[k];
    }
    for (int i = 0; i < m; ++i) b[i] /= pivot_[i];
    for (int i = m - 1; i >= 0; --i) {
      for (int k = i + 1; k < m; ++k) b[i] -= lower_[k][i] * b[k];
    }
    for (int i = 0; i < m; ++i) b[i] *= scale_[i];
    return b;
  }

  FitTolerances tolerances_;
  std::array<Vector, m> lower_{};
  Vector pivot_{}, scale_{}, value_{};
};

}  // namespace recon
