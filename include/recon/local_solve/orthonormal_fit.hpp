// A fit in an orthonormal basis: what Gram-Schmidt, QR and SVD have in common.
//
// Column u_j holds sqrt(w_p) P_j(xi_p) for a polynomial P_j, with u_i . u_j = delta_ij, so that the
// moment matrix is the identity and
//     phi_p = sqrt(w_p) sum_j P_j(0) u_j(p)                      (Tran et al. 2019, eq. 17).
// Beside each column stand the Taylor coefficients of P_j at the target up to an order (its jet),
// numbered as the monomials up to that degree, from which all derivatives follow. T may be a pack;
// entries with w_p = 0 are zero in all columns.
//
// Where the gradient is not resolved in all directions (gradient_resolution.hpp), the local
// polynomial p is replaced by p(Q xi) with Q the projector onto the directions in which it is. What
// is left of the derivatives of an order k >= 2 may still be noise: that of a polynomial that
// nearly vanishes on the particles and has a slope along an unresolved direction n, as
// z - k (x^2 + y^2) does in a thin bowl. Derivative number i is sum_j h_ij (u_j . sqrt(w) u), and
// the slope along n is sum_j c_j (u_j . sqrt(w) u); if the second were known to vanish, the first
// would have the coefficients h_i less their part along c. Where that part makes up more than half
// of sum_i |h_i|^2 (a sum over the entries of the tensor of the derivatives, which rotations leave
// alone), derivatives of order k cannot be told from the slope, and are zero. Elsewhere nothing is
// removed: they are those of polynomials, and amplify errors of the data at most sqrt(2) times as
// much as if the slope were known.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "recon/basis/monomials.hpp"
#include "recon/core/memory.hpp"
#include "recon/core/sums.hpp"
#include "recon/local_solve/fill_report.hpp"
#include "recon/local_solve/gradient_resolution.hpp"
#include "recon/local_solve/local_cloud.hpp"

namespace recon {

// jet_order: that of the jets, at least 2. Numbers: a store of core/memory.hpp.
template <class T, int D, int jet_order = 2, class Numbers = std::vector<T>>
class OrthonormalFit {
 public:
  using Terms = Monomials<D, jet_order>;
  static constexpr int jets = Terms::size;
  using Jet = std::array<T, jets>;

  // The numbers that are held: `fixed` of them, and `each` for every particle, where there are up
  // to `terms` columns and `spare` ones of the caller's.
  static constexpr std::size_t fixed(int terms) {
    return static_cast<std::size_t>(terms) * (jets + 3 * D + 1);
  }
  static constexpr std::size_t each(int terms, int spare = 0) {
    return static_cast<std::size_t>(terms + 3 + spare);
  }

  OrthonormalFit() = default;
  constexpr explicit OrthonormalFit(Numbers numbers) : numbers_(std::move(numbers)) {}

  constexpr int rank() const { return rank_; }
  constexpr int size() const { return n_; }
  constexpr const T* column(int j) const { return of_particles(j); }
  // The `jets` Taylor coefficients of P_j.
  constexpr const T* jet(int j) const { return of_terms(j * jets); }

  // sum_j P_j(0)^2 = e^T M^-1 e, the quantity behind FitReport::amplification.
  constexpr T christoffel() const {
    T sum = T(0);
    for (int j = 0; j < rank_; ++j) sum += jet(j)[0] * jet(j)[0];
    return sum;
  }

  // sum_j |grad P_j(0)|^2 along each axis: e_d^T M^-1 e_d of the linear terms.
  constexpr std::array<T, D> slopes2() const {
    std::array<T, D> sum{};
    for (int j = 0; j < rank_; ++j)
      for (int d = 0; d < D; ++d) sum[d] += jet(j)[1 + d] * jet(j)[1 + d];
    return sum;
  }

  // The sum of |phi_p| over the particles, which sqrt(sum w * christoffel()) bounds.
  constexpr T absolute_sum() {
    using std::abs;
    T* const lambda = this->lambda();
    const T* const root = root_weights();
    combine(lambda, values());
    return detail::sum_of<T>(n_, [&](int p) { return T(T(abs(lambda[p])) * root[p]); });
  }

  // Completes the report by the resolution of the derivatives, and removes what is not resolved
  // from the jets. It works on single targets, not packs. There are slopes in `linear` directions;
  // those of each P_j along others that have been flattened, whatever their unit, are in
  // `flattened`, an array for each direction.
  template <class B>
  constexpr void resolve_gradient(const T& weight_sum, const FitTolerances& tolerances, int linear,
                                  FitReport& report, std::span<const T* const> flattened = {}) {
    if (B::degree < 1) return;
    int degree = 1;
    for (int k = 2; k <= B::degree; ++k)
      if (report.kept[k] > 0) degree = k;
    const T limit2 = detail::gradient_limit2<T>(tolerances, degree);
    const std::array<T, D> slopes = slopes2();
    T total = T(0);
    for (const T& slope : slopes) total += weight_sum * slope;
    report.gradient_rank = D;
    T amplification2 = weight_sum * *std::max_element(slopes.begin(), slopes.end());
    if (linear < D || !(total <= limit2)) {
      partial_ = true;
      const int rank = rank_;
      std::array<T*, D> components{};
      for (int d = 0; d < D; ++d) {
        components[d] = of_terms(terms_ * (jets + d));
        for (int j = 0; j < rank; ++j) components[d][j] = jet(j)[1 + d];
      }
      resolution_ =
          detail::GradientResolution<T, D>::of(components, rank, weight_sum, linear, limit2);
      report.gradient_rank = static_cast<std::uint8_t>(resolution_.rank);
      amplification2 = resolution_.amplification2;
      partial_ = resolution_.rank < D;
      if (partial_) {
        project_jets();
        report.hessian_rank = detail::hessian_rank_of(report);
        unresolved_ = 0;
        for (int d = 0; d < D; ++d)
          if (resolution_.dropped[d]) add_unresolved(components[d]);
        for (const T* const slope : flattened) add_unresolved(slope);
        for (int k = 2; k <= jet_order; ++k) {
          if (share_of_slopes(k) <= T(0.5)) continue;
          for (int j = 0; j < rank; ++j)
            for (int a = Terms::begin(k); a < Terms::begin(k + 1); ++a) jet(j)[a] = T(0);
          if (k == 2) report.hessian_rank = 0;
        }
      }
    }
    report.gradient_amplification = detail::to_float(detail::square_root(amplification2));
  }

  // Makes room for up to `terms` columns of n entries, and keeps none. `spare` columns more are the
  // caller's.
  constexpr void start(const LocalCloud<T, D>& cloud, int terms, int spare = 0) {
    n_ = cloud.size;
    terms_ = terms;
    first_ = fixed(terms);
    rank_ = 0;
    partial_ = false;
    detail::provide(numbers_, fixed(terms) + each(terms, spare) * static_cast<std::size_t>(n_));
    T *const root = of_particles(terms), *const inverse_root = of_particles(terms + 1);
    for (int p = 0; p < n_; ++p) {
      const auto present = cloud.w[p] > T(0);
      root[p] = detail::square_root(cloud.w[p]);
      inverse_root[p] =
          detail::select(present, T(1) / detail::select(present, root[p], T(1)), T(0));
    }
  }
  // sqrt(w_p), and 1 / sqrt(w_p) or 0.
  constexpr const T* root_weights() const { return of_particles(terms_); }
  constexpr const T* inverse_root_weights() const { return of_particles(terms_ + 1); }
  constexpr T* column(int j) { return of_particles(j); }
  constexpr T* jet(int j) { return of_terms(j * jets); }
  constexpr T* next_column() { return column(rank_); }
  constexpr T* next_jet() { return jet(rank_); }
  constexpr T* spare_column(int j) { return of_particles(terms_ + 3 + j); }
  // From here on the polynomial of column j counts as having no derivatives.
  constexpr void flatten(int j) {
    for (int a = 1; a < jets; ++a) jet(j)[a] = T(0);
  }
  constexpr void keep() { ++rank_; }
  constexpr void clear() { rank_ = 0; }

  // Removes from `column` (and its jet) its part in the span of the first `count` kept columns,
  // once. `removed`, unless null, receives the sum of what was removed, column by column.
  constexpr void project_out(T* column, T* column_jet, int count, T* removed = nullptr) const {
    const int n = n_;
    // Classical Gram-Schmidt: the products of several columns with the same vector come first.
    // Called twice it is as good as exact ("twice is enough", Giraud, Langou, Rozloznik 2005).
    in_chunks(count, [&](int first, auto size) {
      constexpr int C = decltype(size)::value;
      std::array<T, C> r{};
      const T* u = this->column(first);
      detail::add_in_blocks<C>(n, r.data(), [&](int begin, int end, T* part) RECON_INLINE_LAMBDA {
        for (int p = begin; p < end; ++p)
          detail::unroll<C>([&](auto j)
                                RECON_INLINE_LAMBDA { part[j] += u[j * n + p] * column[p]; });
      });
      for (int p = 0; p < n; ++p) {
        T rest = column[p];
        detail::unroll<C>([&](auto j) RECON_INLINE_LAMBDA { rest -= r[j] * u[j * n + p]; });
        column[p] = rest;
      }
      for (int j = 0; j < C; ++j) {
        for (int a = 0; a < jets; ++a) column_jet[a] -= r[j] * jet(first + j)[a];
        if (removed) removed[first + j] += r[j];
      }
    });
  }

  // The shape functions of a linear functional of the local polynomial, from what it makes of the
  // monomials in xi, numbered as the jets.
  constexpr void shape_functions_of(const T* on_monomials, T* out) {
    T* const c = coefficients();
    for (int j = 0; j < rank_; ++j) {
      c[j] = T(0);
      for (int a = 0; a < jets; ++a) c[j] += jet(j)[a] * on_monomials[a];
    }
    combine(out, c);
    const T* const root = root_weights();
    for (int p = 0; p < n_; ++p) out[p] *= root[p];
  }

  // Shape functions and derivatives from columns and jets. Exact gradients need cloud.dw.
  constexpr void shape_functions(const LocalCloud<T, D>& cloud, const ShapeArrays<T, D>& out) {
    const int n = n_;
    T* const lambda = this->lambda();  // phi_p / w_p, a polynomial
    T* const c = coefficients();
    const T *const root = root_weights(), *const inverse_root = inverse_root_weights();
    combine(lambda, values());
    for (int p = 0; p < n; ++p) {
      out.value[p] = lambda[p] * root[p];
      lambda[p] *= inverse_root[p];
    }
    if (out.wants_gradient())
      for (int d = 0; d < D; ++d) {
        const T* const dw = cloud.dw[d];
        for (int j = 0; j < rank_; ++j) {
          T slope = jet(j)[1 + d] / cloud.rho;
          if (out.kind == Derivative::exact) {
            const T* u = column(j);
            detail::add_in_blocks<1>(n, &slope,
                                     [&](int begin, int end, T* part) RECON_INLINE_LAMBDA {
                                       for (int p = begin; p < end; ++p)
                                         part[0] -= u[p] * inverse_root[p] * dw[p] * lambda[p];
                                     });
          }
          c[j] = slope;
        }
        combine(out.gradient[d], c);
        for (int p = 0; p < n; ++p) {
          out.gradient[d][p] *= root[p];
          if (out.kind == Derivative::exact) out.gradient[d][p] += dw[p] * lambda[p];
        }
      }
    // The change of the weights with the target has parts in all directions.
    if constexpr (LaneTraits<T>::lanes == 1)
      for (int p = 0; p < n && partial_ && out.wants_gradient(); ++p) {
        std::array<T, D> slope;
        for (int d = 0; d < D; ++d) slope[d] = out.gradient[d][p];
        slope = resolution_.project(slope);
        for (int d = 0; d < D; ++d) out.gradient[d][p] = slope[d];
      }
    if (out.wants_hessian()) {
      int entry = 0;
      for (int a = 0; a < D; ++a)
        for (int b = a; b < D; ++b, ++entry) {
          // The Taylor coefficient of xx is half the second derivative, that of xy the mixed one.
          const T scale = T(a == b ? 2 : 1) / (cloud.rho * cloud.rho);
          for (int j = 0; j < rank_; ++j) c[j] = jet(j)[1 + D + entry] * scale;
          combine(out.hessian[entry], c);
          for (int p = 0; p < n; ++p) out.hessian[entry][p] *= root[p];
        }
    }
  }

 private:
  // Appends to the unresolved slopes one whose coefficients are c, as a unit vector orthogonal to
  // those before it.
  constexpr void add_unresolved(const T* c) {
    T* const added = unresolved(unresolved_);
    detail::copy_numbers(c, rank_, added);
    const auto dot = [this](const T* a, const T* b) {
      T sum = T(0);
      for (int j = 0; j < rank_; ++j) sum += a[j] * b[j];
      return sum;
    };
    const T whole = dot(added, added);
    for (int i = 0; i < unresolved_; ++i) {
      const T* const unit = unresolved(i);
      const T part = dot(unit, added);
      for (int j = 0; j < rank_; ++j) added[j] -= part * unit[j];
    }
    const T left = dot(added, added);
    if (!(left > T(std::numeric_limits<T>::epsilon()) * whole)) return;
    for (int j = 0; j < rank_; ++j) added[j] /= detail::square_root(left);
    ++unresolved_;
  }

  // The part of the derivatives of order k, in all of the square sum of their coefficients, that
  // lies along those of the unresolved slopes. The derivative with exponents alpha is alpha! times
  // its Taylor coefficient, and has k! / alpha! places in the tensor.
  constexpr T share_of_slopes(int k) const {
    T whole = T(0), shared = T(0);
    for (int a = Terms::begin(k); a < Terms::begin(k + 1); ++a) {
      T factor = T(1);
      for (int d = 0; d < D; ++d)
        for (int e = 2; e <= Terms::exponents_of(a)[d]; ++e) factor *= T(e);
      for (int j = 0; j < rank_; ++j) whole += factor * jet(j)[a] * jet(j)[a];
      for (int i = 0; i < unresolved_; ++i) {
        T part = T(0);
        for (int j = 0; j < rank_; ++j) part += unresolved(i)[j] * jet(j)[a];
        shared += factor * part * part;
      }
    }
    return whole > T(0) ? T(shared / whole) : T(0);
  }

  // Replaces each P_j(xi) by P_j(Q xi) with the projector Q onto the resolved directions.
  constexpr void project_jets() {
    std::array<Jet, jets> projected;  // of the monomials of Q xi
    for (int a = 1; a < jets; ++a)
      projected[a] = Terms::of_forms(Terms::exponents_of(a), resolution_.projector);
    for (int j = 0; j < rank_; ++j) {
      Jet whole;
      detail::copy_numbers(jet(j), jets, whole.data());
      for (int k = 1; k <= jet_order; ++k)
        for (int b = Terms::begin(k); b < Terms::begin(k + 1); ++b) {
          jet(j)[b] = T(0);
          for (int a = Terms::begin(k); a < Terms::begin(k + 1); ++a)
            jet(j)[b] += projected[a][b] * whole[a];
        }
    }
  }

  // Calls body(first, integral_constant<int, size>) for chunks of up to 8 of `count` columns.
  template <class Body>
  static constexpr void in_chunks(int count, Body&& body) {
    int first = 0;
    for (; first + 8 <= count; first += 8) body(first, std::integral_constant<int, 8>{});
    if (count - first >= 4) {
      body(first, std::integral_constant<int, 4>{});
      first += 4;
    }
    if (count - first == 3) body(first, std::integral_constant<int, 3>{});
    if (count - first == 2) body(first, std::integral_constant<int, 2>{});
    if (count - first == 1) body(first, std::integral_constant<int, 1>{});
  }

  // Forms result_p = sum_j coefficient_j u_j(p).
  constexpr void combine(T* result, const T* coefficient) const {
    const int n = n_;
    for (int p = 0; p < n; ++p) result[p] = T(0);
    in_chunks(rank_, [&](int first, auto size) {
      constexpr int C = decltype(size)::value;
      std::array<T, C> c;
      for (int j = 0; j < C; ++j) c[j] = coefficient[first + j];
      const T* u = column(first);
      for (int p = 0; p < n; ++p) {
        T sum = result[p];
        detail::unroll<C>([&](auto j) RECON_INLINE_LAMBDA { sum += c[j] * u[j * n + p]; });
        result[p] = sum;
      }
    });
  }

  // The P_j(0), as coefficients.
  constexpr const T* values() {
    T* const c = coefficients();
    for (int j = 0; j < rank_; ++j) c[j] = jet(j)[0];
    return c;
  }

  // The numbers in their order. For each of the terms: the jets, D components of slopes, 2 D
  // unresolved slopes, a coefficient. For each particle: the columns, sqrt(w_p), 1 / sqrt(w_p),
  // phi_p / w_p and what is spare.
  constexpr T* of_terms(int at) { return numbers_.data() + at; }
  constexpr const T* of_terms(int at) const { return numbers_.data() + at; }
  constexpr T* of_particles(int j) {
    return numbers_.data() + first_ + static_cast<std::size_t>(j) * n_;
  }
  constexpr const T* of_particles(int j) const {
    return numbers_.data() + first_ + static_cast<std::size_t>(j) * n_;
  }
  constexpr T* coefficients() { return of_terms(terms_ * (jets + 3 * D)); }
  constexpr T* lambda() { return of_particles(terms_ + 2); }
  // The coefficients of slopes that are not resolved: orthonormal, rank_ numbers each.
  constexpr T* unresolved(int i) { return of_terms(terms_ * (jets + D + i)); }
  constexpr const T* unresolved(int i) const { return of_terms(terms_ * (jets + D + i)); }

  int n_ = 0, rank_ = 0, terms_ = 0, unresolved_ = 0;
  std::size_t first_ = 0;  // of the numbers of particles
  bool partial_ = false;   // the gradient is not resolved in all directions
  detail::GradientResolution<T, D> resolution_;
  Numbers numbers_{};
};

}  // namespace recon
