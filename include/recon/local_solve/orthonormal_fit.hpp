// A fit in an orthonormal basis: what Gram-Schmidt, QR and SVD have in common.
//
// Column u_j holds sqrt(w_p) P_j(xi_p) for a polynomial P_j, with u_i . u_j = delta_ij, so that the
// moment matrix is the identity and
//     phi_p = sqrt(w_p) sum_j P_j(0) u_j(p)                      (Tran et al. 2019, eq. 17).
// Beside each column stand the Taylor coefficients of P_j at the target (its jet), from which all
// derivatives follow. T may be a pack; entries with w_p = 0 are zero in all columns.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "recon/basis/monomials.hpp"
#include "recon/core/sums.hpp"
#include "recon/local_solve/gradient_resolution.hpp"
#include "recon/local_solve/local_cloud.hpp"

namespace recon {

template <class T, int D>
class OrthonormalFit {
 public:
  static constexpr int jets = detail::jet_size(D);
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

  // Completes the report by the resolution of the gradient, and removes what is not resolved from
  // all derivatives that follow: the unresolved directions in space, and from the second
  // derivatives also the polynomial whose slope is noise. It works on single targets, not packs;
  // there are slopes in `linear` directions.
  template <class B>
  void resolve_gradient(const T& weight_sum, const FitTolerances& tolerances, int linear,
                        FitReport& report) {
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
      for (int d = 0; d < D; ++d)
        if (resolution_.dropped[d]) remove_from_second_derivatives(components[d]);
      for (int j = 0; j < rank && partial_; ++j) project(jets_[j]);
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
  // Removes the polynomial sum_j c_j P_j from the second derivatives.
  void remove_from_second_derivatives(const T* c) {
    T size2 = T(0);
    for (int j = 0; j < rank_; ++j) size2 += c[j] * c[j];
    for (int entry = 1 + D; entry < jets; ++entry) {
      T part = T(0);
      for (int j = 0; j < rank_; ++j) part += c[j] * jets_[j][entry];
      for (int j = 0; j < rank_; ++j) jets_[j][entry] -= part / size2 * c[j];
    }
  }

  // Keeps of the derivatives in a jet (gradient g, Hessian H) what lies in the resolved
  // directions: Q g, Q H Q.
  void project(Jet& jet) const {
    std::array<T, D> slope;
    std::array<std::array<T, D>, D> second, half;
    int entry = 1 + D;
    for (int a = 0; a < D; ++a) {
      slope[a] = jet[1 + a];
      for (int b = a; b < D; ++b, ++entry)
        second[a][b] = second[b][a] = a == b ? T(T(2) * jet[entry]) : jet[entry];
    }
    slope = resolution_.project(slope);
    for (int a = 0; a < D; ++a) half[a] = resolution_.project(second[a]);
    entry = 1 + D;
    for (int a = 0; a < D; ++a) {
      jet[1 + a] = slope[a];
      std::array<T, D> column;
      for (int b = 0; b < D; ++b) column[b] = half[b][a];
      column = resolution_.project(column);
      for (int b = a; b < D; ++b, ++entry) jet[entry] = a == b ? T(column[b] / T(2)) : column[b];
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
};

}  // namespace recon
