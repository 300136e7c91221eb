// Moving least squares by the moment matrix (Gong 2015, eq. 3.6-3.8): fast, used where it is safe.
//
//     M = sum_p w_p m_p m_p^T = L diag(d) L^T,   M c = m(0),   phi_p = w_p m_p^T c .
// M is scaled to unit diagonal first. Each pivot is then the squared share of a term that is
// independent of the terms before it, between 0 and 1; digits are lost in proportion to 1 / pivot.
// The target is handed over to Gram-Schmidt where the smallest pivot is below a quarter of the
// working precision (eps^(1/4)), where the fit would amplify data errors by more than the leverage
// limit, and where the gradient is not clearly resolved in all directions. Gram-Schmidt gives the
// same answer where both work, and a right one where this would not.
//
// For monomials, M has only C(2 degree + D, D) different entries, the moments sum_p w_p xi^alpha:
// those are summed. Cost: that many multiply-adds per particle, m^3 / 6 for the factors.
//
// T may be a pack (core/pack.hpp), with one target in each lane. Lanes that are not safe go through
// the same arithmetic with harmless numbers; their results are meaningless, and the mask that fit()
// returns excludes them.
#pragma once

#include <algorithm>
#include <array>
#include <utility>

#include "recon/basis/monomials.hpp"
#include "recon/core/lanes.hpp"
#include "recon/core/memory.hpp"
#include "recon/core/sums.hpp"
#include "recon/local_solve/local_cloud.hpp"

namespace recon {

template <class T, Basis B>
class MomentMatrix {
 public:
  static constexpr int D = B::dimension;
  static constexpr int m = B::size;
  static constexpr int moment_count = monomial_count(D, 2 * B::degree);
  using Mask = MaskOf<T>;
  using Vector = std::array<T, m>;
  using Moments = std::array<T, moment_count>;  // ordered as Monomials<D, 2 degree>

  constexpr explicit MomentMatrix(FitTolerances tolerances = {}) : tolerances_(tolerances) {}

  // Builds and factorises M from the particles. False where the target must be handed over.
  constexpr Mask fit(const LocalCloud<T, D>& cloud) {
    if constexpr (detail::is_monomials<B>) {
      return factor(moments_of(cloud), cloud.noise);
    } else {
      std::array<T, m * m> sums{};
      detail::add_in_blocks<m * m>(cloud.size, sums.data(), [&](int begin, int end, T* part) {
        for (int p = begin; p < end; ++p) {
          const Vector terms = evaluate(cloud, p);
          for (int i = 0; i < m; ++i)
            for (int j = 0; j <= i; ++j) part[i * m + j] += cloud.w[p] * terms[i] * terms[j];
        }
      });
      for (int i = 0; i < m; ++i) detail::copy_numbers(sums.data() + i * m, m, lower_[i].data());
      return factor(cloud.noise);
    }
  }

  // Factorises M from moments summed elsewhere: moments[a] = sum_p w_p xi_p^alpha, alpha being the
  // exponents of term a of Monomials<D, 2 degree>.
  constexpr Mask factor(const Moments& moments, const T& noise) requires detail::is_monomials<B> {
    if constexpr (m <= detail::most_unrolled / 3) {
      detail::unroll<m>([&](auto i) RECON_INLINE_LAMBDA {
        detail::unroll<i + 1>([&](auto j)
                                  RECON_INLINE_LAMBDA { lower_[i][j] = moments[place(i, j)]; });
      });
    } else {
      for (int i = 0; i < m; ++i)
        for (int j = 0; j <= i; ++j) lower_[i][j] = moments[RECON_TABLE(places)[i][j]];
    }
    return factor(noise);
  }

  // Whether the slope is clearly resolved in all directions (gradient_resolution.hpp), a question
  // apart from whether M is safe; and where it is, FitReport::gradient_amplification.
  constexpr const Mask& gradient_resolved() const { return gradient_resolved_; }
  constexpr const T& gradient_amplification() const { return gradient_amplification_; }
  // D^-1/2 L^-1 times the scaled gradients at the target: the G_j of gradient_resolution.hpp.
  constexpr std::array<std::array<T, D>, m> slopes() const {
    std::array<std::array<T, D>, m> g{};
    reduce_slopes(g);
    for (int k = 0; k < m; ++k)
      for (T& component : g[k]) component *= detail::square_root(inverse_[k]);
    return g;
  }
  // FitReport::smallest_pivot and FitReport::amplification.
  constexpr const T& smallest_pivot() const { return smallest_; }
  constexpr const T& amplification() const { return amplification_; }
  // The solution of M c = m(0): phi_p = w_p m_p^T c.
  constexpr const Vector& coefficients() const { return value_; }

  // Returns M^-1 b.
  constexpr Vector solve(Vector b) const {
    for (int i = 0; i < m; ++i) {
      b[i] *= scale_[i];
      for (int k = 0; k < i; ++k) b[i] -= lower_[i][k] * b[k];
    }
    for (int i = 0; i < m; ++i) b[i] *= inverse_[i];
    for (int i = m - 1; i >= 0; --i)
      for (int k = i + 1; k < m; ++k) b[i] -= lower_[k][i] * b[k];
    for (int i = 0; i < m; ++i) b[i] *= scale_[i];
    return b;
  }

  constexpr void shape_functions(const LocalCloud<T, D>& cloud,
                                 const ShapeArrays<T, D>& out) const {
    const int n = cloud.size;
    std::array<Vector, D> first{};  // M^-1 (dm(0) - sum_q dw_q lambda_q m_q)
    constexpr int seconds = D * (D + 1) / 2;
    std::array<Vector, seconds> second{};
    if (out.wants_gradient()) {
      std::array<T, D * m> sides;
      for (int d = 0; d < D; ++d)
        for (int j = 0; j < m; ++j) sides[d * m + j] = T(Scalar(B::origin(j, 1 + d))) / cloud.rho;
      if (out.kind == Derivative::exact)
        detail::add_in_blocks<D * m>(n, sides.data(),
                                     [&](int begin, int end, T* part) RECON_INLINE_LAMBDA {
                                       for (int p = begin; p < end; ++p) {
                                         const Vector terms = evaluate(cloud, p);
                                         const T lambda = dot(terms, value_);
                                         for (int d = 0; d < D; ++d) {
                                           const T moved = cloud.dw[d][p] * lambda;
                                           for (int j = 0; j < m; ++j)
                                             part[d * m + j] -= moved * terms[j];
                                         }
                                       }
                                     });
      for (int d = 0; d < D; ++d) {
        detail::copy_numbers(sides.data() + d * m, m, first[d].data());
        first[d] = solve(first[d]);
      }
    }
    if (out.wants_hessian()) {
      int entry = 0;
      for (int a = 0; a < D; ++a)
        for (int b = a; b < D; ++b, ++entry) {
          for (int j = 0; j < m; ++j)
            second[entry][j] =
                T(Scalar((a == b ? 2 : 1) * B::origin(j, 1 + D + entry))) / (cloud.rho * cloud.rho);
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
  using Scalar = ScalarOf<T>;

  // L^-1 times the scaled derivatives of the terms along each axis at the target.
  RECON_INLINE constexpr void reduce_slopes(std::array<std::array<T, D>, m>& g) const {
    constexpr int first = detail::is_monomials<B> ? 1 : 0;  // the constant has none
    for (int i = first; i < m; ++i) {
      for (int d = 0; d < D; ++d) g[i][d] = T(Scalar(B::origin(i, 1 + d))) * scale_[i];
      for (int k = first; k < i; ++k)
        for (int d = 0; d < D; ++d) g[i][d] -= lower_[i][k] * g[k][d];
    }
  }

  RECON_INLINE static constexpr T dot(const Vector& a, const Vector& b) {
    T sum = a[0] * b[0];
    for (int j = 1; j < m; ++j) sum += a[j] * b[j];
    return sum;
  }

  RECON_INLINE static constexpr Vector evaluate(const LocalCloud<T, D>& cloud, int p) {
    Vector terms;
    B::evaluate(cloud.at(p), terms.data());
    return terms;
  }

  static constexpr Moments moments_of(const LocalCloud<T, D>& cloud) {
    Moments moments{};
    detail::add_in_blocks<moment_count>(
        cloud.size, moments.data(), [&](int begin, int end, T* part) RECON_INLINE_LAMBDA {
          for (int p = begin; p < end; ++p) {
            Moments powers;
            Monomials<D, 2 * B::degree>::evaluate(cloud.at(p), powers.data(), cloud.w[p]);
            if constexpr (moment_count <= detail::most_unrolled)
              detail::unroll<moment_count>([&](auto a)
                                               RECON_INLINE_LAMBDA { part[a] += powers[a]; });
            else
              for (int a = 0; a < moment_count; ++a) part[a] += powers[a];
          }
        });
    return moments;
  }

  // The number of the moment of the product of terms i and j.
  static constexpr int place(int i, int j) {
    std::array<std::uint8_t, D> e = B::exponents[i];
    for (int d = 0; d < D; ++d) e[d] = static_cast<std::uint8_t>(e[d] + B::exponents[j][d]);
    return Monomials<D, 2 * B::degree>::find(e);
  }

  static constexpr std::array<std::array<std::uint16_t, m>, m> places = [] {
    std::array<std::array<std::uint16_t, m>, m> all{};
    if constexpr (detail::is_monomials<B>)
      for (int i = 0; i < m; ++i)
        for (int j = 0; j <= i; ++j) all[i][j] = static_cast<std::uint16_t>(place(i, j));
    return all;
  }();

  // Factorises M as L D L^T, in place of its lower triangle, and sets all that is asked about it.
  constexpr Mask factor(const T& noise) {
    const T weight_sum = lower_[0][0];
    const detail::Thresholds<T> thresholds(tolerances_, noise);
    const T& regular = thresholds.well_conditioned;
    const T shortest = regular * regular * weight_sum;  // a least size for linear terms
    Mask safe = weight_sum > T(0);
    for (int j = 1; j < B::begin(2) && B::degree >= 1; ++j) safe = safe && lower_[j][j] > shortest;

    for (int i = 0; i < m; ++i) {
      safe = safe && lower_[i][i] > T(0);
      scale_[i] = T(1) / detail::square_root(detail::select(safe, lower_[i][i], T(1)));
    }
    smallest_ = T(1);
    for (int j = 0; j < m; ++j) {
      Vector row;
      T pivot = T(1);
      for (int k = 0; k < j; ++k) {
        row[k] = lower_[j][k] * pivot_[k];
        pivot -= lower_[j][k] * row[k];
      }
      safe = safe && pivot > regular;
      pivot_[j] = detail::select(safe, pivot, T(1));
      smallest_ = detail::smaller(pivot_[j], smallest_);
      inverse_[j] = T(1) / pivot_[j];
      for (int i = j + 1; i < m; ++i) {
        T value = lower_[i][j] * scale_[i] * scale_[j];
        for (int k = 0; k < j; ++k) value -= lower_[i][k] * row[k];
        lower_[i][j] = detail::select(safe, value * inverse_[j], T(0));
      }
      if (!detail::any_lane(safe)) return safe;
    }

    Vector unit{};
    for (int j = 0; j < m; ++j) unit[j] = T(Scalar(B::origin(j, 0)));
    value_ = solve(unit);
    T christoffel = T(0);
    for (int j = 0; j < m; ++j) christoffel += unit[j] * value_[j];
    const T amplification2 = detail::select(safe, weight_sum * christoffel, T(0));
    amplification_ = detail::square_root(amplification2);
    std::array<T, D> slopes2{};
    if constexpr (B::degree >= 1) {
      std::array<std::array<T, D>, m> g;
      if constexpr (detail::is_monomials<B>) g[0] = {};
      reduce_slopes(g);
      for (int k = 0; k < m; ++k)
        for (int d = 0; d < D; ++d) slopes2[d] += g[k][d] * g[k][d] * inverse_[k];
    }
    T total = T(0), largest = T(0);
    for (const T& slope2 : slopes2) {
      total += slope2;
      largest = detail::larger(slope2, largest);
    }
    gradient_amplification_ = detail::square_root(detail::select(safe, weight_sum * largest, T(0)));
    gradient_resolved_ =
        weight_sum * total <= T(detail::gradient_limit2<Scalar>(tolerances_, B::degree));
    const auto limit = static_cast<Scalar>(tolerances_.leverage);
    return safe && amplification2 <= T(limit * limit);
  }

  FitTolerances tolerances_;
  std::array<Vector, m> lower_{};
  Vector pivot_{}, inverse_{}, scale_{}, value_{};
  T smallest_ = T(0), amplification_ = T(0), gradient_amplification_ = T(0);
  Mask gradient_resolved_ = Mask(false);
};

}  // namespace recon
