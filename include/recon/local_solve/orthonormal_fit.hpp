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
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "recon/basis/monomials.hpp"
#include "recon/core/sums.hpp"
#include "recon/local_solve/gradient_resolution.hpp"
#include "recon/local_solve/local_cloud.hpp"

namespace recon {

// jet_order: that of the jets, at least 2.
template <class T, int D, int jet_order = 2>
class OrthonormalFit {
 public:
  using Terms = Monomials<D, jet_order>;
  static constexpr int jets = Terms::size;
  using Jet = std::array<T, jets>;

  int rank() const { return rank_; }
  int size() const { return n_; }
  const T* column(int j) const { return columns_.data() + static_cast<std::size_t>(j) * n_; }
  const Jet& jet(int j) const { return jets_[j]; }

  // sum_j P_j(0)^2 = e^T M^-1 e, the quantity behind FitReport::amplification.
  T christoffel() const {
    T sum = T(0);
    for (int j = 0; j < rank_; ++j) sum += jets_[j][0] * jets_[j][0];
    return sum;
  }

  // sum_j |grad P_j(0)|^2 along each axis: e_d^T M^-1 e_d of the linear terms.
  std::array<T, D> slopes2() const {
    std::array<T, D> sum{};
    for (int j = 0; j < rank_; ++j)
      for (int d = 0; d < D; ++d) sum[d] += jets_[j][1 + d] * jets_[j][1 + d];
    return sum;
  }

  // The sum of |phi_p| over the particles, which sqrt(sum w * christoffel()) bounds.
  T absolute_sum() {
    using std::abs;
    combine(lambda_.data(), [&](int j) { return jets_[j][0]; });
    return detail::sum_of<T>(n_, [&](int p) { return T(T(abs(lambda_[p])) * root_[p]); });
  }

  // Completes the report by the resolution of the derivatives, and removes what is not resolved
  // from the jets. It works on single targets, not packs. There are slopes in `linear` directions;
  // those of each P_j along others that have been flattened, whatever their unit, are in
  // `flattened`, an array for each direction.
  template <class B>
  void resolve_gradient(const T& weight_sum, const FitTolerances& tolerances, int linear,
                        FitReport& report, std::span<const std::vector<T>> flattened = {}) {
    using std::sqrt;
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
      directions_.resize(static_cast<std::size_t>(D) * rank);
      std::array<T*, D> components;
      for (int d = 0; d < D; ++d) {
        components[d] = directions_.data() + d * rank;
        for (int j = 0; j < rank; ++j) components[d][j] = jets_[j][1 + d];
      }
      resolution_ =
          detail::GradientResolution<T, D>::of(components, rank, weight_sum, linear, limit2);
      report.gradient_rank = static_cast<std::uint8_t>(resolution_.rank);
      amplification2 = resolution_.amplification2;
      partial_ = resolution_.rank < D;
      if (partial_) {
        project_jets();
        report.hessian_rank = detail::hessian_rank_of(report);
        unresolved_.clear();
        for (int d = 0; d < D; ++d)
          if (resolution_.dropped[d]) add_unresolved(components[d]);
        for (const std::vector<T>& slope : flattened) add_unresolved(slope.data());
        for (int k = 2; k <= jet_order; ++k) {
          if (share_of_slopes(k) <= T(0.5)) continue;
          for (int j = 0; j < rank; ++j)
            for (int a = Terms::begin(k); a < Terms::begin(k + 1); ++a) jets_[j][a] = T(0);
          if (k == 2) report.hessian_rank = 0;
        }
      }
    }
    report.gradient_amplification = detail::to_float(T(sqrt(amplification2)));
  }

  // Makes room for up to `terms` columns of n entries, and keeps none.
  void start(const LocalCloud<T, D>& cloud, int terms) {
    using std::sqrt;
    n_ = cloud.size;
    rank_ = 0;
    partial_ = false;
    columns_.resize(static_cast<std::size_t>(terms) * n_);
    jets_.resize(terms);
    root_.resize(n_);
    inverse_root_.resize(n_);
    lambda_.resize(n_);
    for (int p = 0; p < n_; ++p) {
      const auto present = cloud.w[p] > T(0);
      root_[p] = sqrt(cloud.w[p]);
      inverse_root_[p] =
          detail::select(present, T(1) / detail::select(present, root_[p], T(1)), T(0));
    }
  }
  const T* root_weights() const { return root_.data(); }
  T* column(int j) { return columns_.data() + static_cast<std::size_t>(j) * n_; }
  T* next_column() { return column(rank_); }
  Jet& next_jet() { return jets_[rank_]; }
  // From here on the polynomial of column j counts as having no derivatives.
  void flatten(int j) {
    for (int a = 1; a < jets; ++a) jets_[j][a] = T(0);
  }
  void keep() { ++rank_; }
  void clear() { rank_ = 0; }

  // Removes from `column` (and its jet) its part in the span of the first `count` kept columns,
  // once. `removed`, unless null, receives the sum of what was removed, column by column.
  void project_out(T* column, Jet& jet, int count, T* removed = nullptr) const {
    // Classical Gram-Schmidt: the products of several columns with the same vector come first.
    // Called twice it is as good as exact ("twice is enough", Giraud, Langou, Rozloznik 2005).
    in_chunks(count, [&](int first, auto size) {
      constexpr int C = decltype(size)::value;
      std::array<T, C> r{};
      const T* u = this->column(first);
      detail::add_in_blocks<C>(n_, r.data(), [&](int begin, int end, T* part) RECON_INLINE_LAMBDA {
        for (int p = begin; p < end; ++p)
          detail::unroll<C>([&](auto j)
                                RECON_INLINE_LAMBDA { part[j] += u[j * n_ + p] * column[p]; });
      });
      for (int p = 0; p < n_; ++p) {
        T rest = column[p];
        detail::unroll<C>([&](auto j) RECON_INLINE_LAMBDA { rest -= r[j] * u[j * n_ + p]; });
        column[p] = rest;
      }
      for (int j = 0; j < C; ++j) {
        for (int a = 0; a < jets; ++a) jet[a] -= r[j] * jets_[first + j][a];
        if (removed) removed[first + j] += r[j];
      }
    });
  }

  // The shape functions of a linear functional of the local polynomial, from what it makes of the
  // monomials in xi, numbered as the jets.
  void shape_functions_of(const T* on_monomials, T* out) const {
    combine(out, [&](int j) {
      T sum = T(0);
      for (int a = 0; a < jets; ++a) sum += jets_[j][a] * on_monomials[a];
      return sum;
    });
    for (int p = 0; p < n_; ++p) out[p] *= root_[p];
  }

  // Shape functions and derivatives from columns and jets. Exact gradients need cloud.dw.
  void shape_functions(const LocalCloud<T, D>& cloud, const ShapeArrays<T, D>& out) {
    // lambda_p = phi_p / w_p, a polynomial.
    combine(lambda_.data(), [&](int j) { return jets_[j][0]; });
    for (int p = 0; p < n_; ++p) {
      out.value[p] = lambda_[p] * root_[p];
      lambda_[p] *= inverse_root_[p];
    }
    if (out.wants_gradient())
      for (int d = 0; d < D; ++d) {
        combine(out.gradient[d], [&](int j) {
          T slope = jets_[j][1 + d] / cloud.rho;
          if (out.kind == Derivative::exact) {
            const T* u = column(j);
            detail::add_in_blocks<1>(
                n_, &slope, [&](int begin, int end, T* part) RECON_INLINE_LAMBDA {
                  for (int p = begin; p < end; ++p)
                    part[0] -= u[p] * inverse_root_[p] * cloud.dw[d][p] * lambda_[p];
                });
          }
          return slope;
        });
        for (int p = 0; p < n_; ++p) {
          out.gradient[d][p] *= root_[p];
          if (out.kind == Derivative::exact) out.gradient[d][p] += cloud.dw[d][p] * lambda_[p];
        }
      }
    // The change of the weights with the target has parts in all directions.
    if constexpr (LaneTraits<T>::lanes == 1)
      for (int p = 0; p < n_ && partial_ && out.wants_gradient(); ++p) {
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
          combine(out.hessian[entry], [&](int j) { return jets_[j][1 + D + entry] * scale; });
          for (int p = 0; p < n_; ++p) out.hessian[entry][p] *= root_[p];
        }
    }
  }

 private:
  // Appends to the unresolved slopes one whose coefficients are c, as a unit vector orthogonal to
  // those before it.
  void add_unresolved(const T* c) {
    using std::sqrt;
    const std::size_t before = unresolved_.size();
    unresolved_.insert(unresolved_.end(), c, c + rank_);
    T* const added = unresolved_.data() + before;
    const auto dot = [this](const T* a, const T* b) {
      T sum = T(0);
      for (int j = 0; j < rank_; ++j) sum += a[j] * b[j];
      return sum;
    };
    const T whole = dot(added, added);
    for (const T* unit = unresolved_.data(); unit != added; unit += rank_) {
      const T part = dot(unit, added);
      for (int j = 0; j < rank_; ++j) added[j] -= part * unit[j];
    }
    const T left = dot(added, added);
    if (!(left > T(std::numeric_limits<T>::epsilon()) * whole)) return unresolved_.resize(before);
    for (int j = 0; j < rank_; ++j) added[j] /= T(sqrt(left));
  }

  // The part of the derivatives of order k, in all of the square sum of their coefficients, that
  // lies along those of the unresolved slopes. The derivative with exponents alpha is alpha! times
  // its Taylor coefficient, and has k! / alpha! places in the tensor.
  T share_of_slopes(int k) const {
    T whole = T(0), shared = T(0);
    for (int a = Terms::begin(k); a < Terms::begin(k + 1); ++a) {
      T factor = T(1);
      for (int d = 0; d < D; ++d)
        for (int e = 2; e <= Terms::exponents[a][d]; ++e) factor *= T(e);
      for (int j = 0; j < rank_; ++j) whole += factor * jets_[j][a] * jets_[j][a];
      for (std::size_t first = 0; first < unresolved_.size(); first += rank_) {
        T part = T(0);
        for (int j = 0; j < rank_; ++j) part += unresolved_[first + j] * jets_[j][a];
        shared += factor * part * part;
      }
    }
    return whole > T(0) ? T(shared / whole) : T(0);
  }

  // Replaces each P_j(xi) by P_j(Q xi) with the projector Q onto the resolved directions.
  void project_jets() {
    std::array<Jet, jets> projected;  // of the monomials of Q xi
    for (int a = 1; a < jets; ++a)
      projected[a] = Terms::of_forms(Terms::exponents[a], resolution_.projector);
    for (int j = 0; j < rank_; ++j) {
      const Jet whole = jets_[j];
      for (int k = 1; k <= jet_order; ++k)
        for (int b = Terms::begin(k); b < Terms::begin(k + 1); ++b) {
          jets_[j][b] = T(0);
          for (int a = Terms::begin(k); a < Terms::begin(k + 1); ++a)
            jets_[j][b] += projected[a][b] * whole[a];
        }
    }
  }

  // Calls body(first, integral_constant<int, size>) for chunks of up to 8 of `count` columns.
  template <class Body>
  static void in_chunks(int count, Body&& body) {
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

  // Forms result_p = sum_j coefficient(j) u_j(p).
  template <class Coefficient>
  void combine(T* result, Coefficient coefficient) const {
    for (int p = 0; p < n_; ++p) result[p] = T(0);
    in_chunks(rank_, [&](int first, auto size) {
      constexpr int C = decltype(size)::value;
      std::array<T, C> c;
      for (int j = 0; j < C; ++j) c[j] = coefficient(first + j);
      const T* u = column(first);
      for (int p = 0; p < n_; ++p) {
        T sum = result[p];
        detail::unroll<C>([&](auto j) RECON_INLINE_LAMBDA { sum += c[j] * u[j * n_ + p]; });
        result[p] = sum;
      }
    });
  }

  int n_ = 0, rank_ = 0;
  std::vector<T> columns_;  // column-wise
  std::vector<Jet> jets_;
  std::vector<T> root_, inverse_root_;  // sqrt(w_p), and 1 / sqrt(w_p) or 0
  std::vector<T> lambda_;
  bool partial_ = false;  // the gradient is not resolved in all directions
  detail::GradientResolution<T, D> resolution_;
  std::vector<T> directions_;
  std::vector<T> unresolved_;  // coefficients of slopes: orthonormal, rank_ numbers each
};

}  // namespace recon
