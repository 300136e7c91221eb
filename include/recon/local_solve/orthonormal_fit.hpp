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

  // Room for up to `terms` columns of n entries; keeps none.
  void start(const LocalCloud<T, D>& cloud, int terms) {
    using std::sqrt;
    n_ = cloud.size;
    rank_ = 0;
    columns_.resize(static_cast<std::size_t>(terms) * n_);
    jets_.resize(terms);
    root_.resize(n_);
    inverse_root_.resize(n_);
    lambda_.resize(n_);
    for (int p = 0; p < n_; ++p) {
      const auto present = cloud.w[p] > T(0);
      root_[p] = sqrt(cloud.w[p]);
      inverse_root_[p] = select(present, T(1) / select(present, root_[p], T(1)), T(0));
    }
  }
  const T* root_weights() const { return root_.data(); }
  T* column(int j) { return columns_.data() + static_cast<std::size_t>(j) * n_; }
  T* next_column() { return column(rank_); }
  Jet& next_jet() { return jets_[rank_]; }
  void keep() { ++rank_; }
  void clear() { rank_ = 0; }

  // Removes from `column` (and its jet) its part in the span of the first `count` kept columns,
  // once. With `removed`, adds what was taken away, column by column.
  void project_out(T* column, Jet& jet, int count, T* removed = nullptr) const {
    // Classical: products with the same vector first, for several columns at once. Called twice it
    // is as good as exact ("twice is enough", Giraud, Langou, Rozloznik 2005).
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

  // Shape functions and derivatives, from columns and jets. cloud.dw is needed for exact gradients.
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
  // body(first, integral_constant<int, size>) for chunks of up to 8 of `count` columns.
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

  // result_p = sum_j coefficient(j) u_j(p)
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
};

}  // namespace recon
