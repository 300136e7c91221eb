// A fit in an orthonormal basis: what Gram-Schmidt, QR and SVD have in common.
//
// Column u_j holds sqrt(w_p) P_j(xi_p) for a polynomial P_j, with u_i . u_j = delta_ij, so that the
// moment matrix is the identity and
//     phi_p = sqrt(w_p) sum_j P_j(0) u_j(p)                      (Tran et al. 2019, eq. 17).
// Beside each column stand the Taylor coefficients of P_j at the target (its jet), from which all
// derivatives follow.
#pragma once

#include <cmath>
#include <vector>

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
    n_ = cloud.size;
    rank_ = 0;
    columns_.resize(static_cast<std::size_t>(terms + 1) *
                    n_);  // one more: work space of derivatives
    jets_.resize(terms);
    root_.resize(n_);
    for (int p = 0; p < n_; ++p) root_[p] = std::sqrt(cloud.w[p]);
  }
  const T* root_weights() const { return root_.data(); }
  T* next_column() { return columns_.data() + static_cast<std::size_t>(rank_) * n_; }
  Jet& next_jet() { return jets_[rank_]; }
  void keep() { ++rank_; }
  void clear() { rank_ = 0; }

  // Removes from `column` (and its jet) its part in the span of the first `count` kept columns,
  // once. With `removed`, adds what was taken away, column by column.
  void project_out(T* column, Jet& jet, int count, T* removed = nullptr) const {
    // Classical: all products with the same vector first. Called twice it is as good as exact
    // ("twice is enough", Giraud, Langou, Rozloznik 2005).
    for (int j = 0; j < count; ++j) {
      const T* u = this->column(j);
      T r = T(0);
      for (int p = 0; p < n_; ++p) r += u[p] * column[p];
      for (int p = 0; p < n_; ++p) column[p] -= r * u[p];
      for (int a = 0; a < jets; ++a) jet[a] -= r * jets_[j][a];
      if (removed) removed[j] += r;
    }
  }

  // Shape functions and derivatives, from columns and jets. cloud.dw is needed for exact gradients.
  void shape_functions(const LocalCloud<T, D>& cloud, const ShapeArrays<T, D>& out) {
    combine(out.value, [&](int j) { return jets_[j][0]; });
    if (out.wants_gradient()) {
      // lambda_p = phi_p / w_p, a polynomial, in the spare column.
      T* lambda = columns_.data() + static_cast<std::size_t>(rank_) * n_;
      for (int p = 0; p < n_; ++p) lambda[p] = out.value[p] / cloud.w[p];
      for (int d = 0; d < D; ++d) {
        if (out.kind == Derivative::diffuse) {
          combine(out.gradient[d], [&](int j) { return jets_[j][1 + d] / cloud.rho; });
          continue;
        }
        combine(out.gradient[d], [&](int j) {
          const T* u = column(j);
          T moved = T(0);
          for (int p = 0; p < n_; ++p) moved += u[p] / root_[p] * cloud.dw[d][p] * lambda[p];
          return jets_[j][1 + d] / cloud.rho - moved;
        });
        for (int p = 0; p < n_; ++p) out.gradient[d][p] += cloud.dw[d][p] * lambda[p];
      }
    }
    if (out.wants_hessian()) {
      int entry = 0;
      for (int a = 0; a < D; ++a)
        for (int b = a; b < D; ++b, ++entry) {
          // The Taylor coefficient of xx is half the second derivative, that of xy the mixed one.
          const T scale = T(a == b ? 2 : 1) / (cloud.rho * cloud.rho);
          combine(out.hessian[entry], [&](int j) { return jets_[j][1 + D + entry] * scale; });
        }
    }
  }

 private:
  // result_p = sqrt(w_p) sum_j coefficient(j) u_j(p)
  template <class Coefficient>
  void combine(T* result, Coefficient coefficient) const {
    for (int p = 0; p < n_; ++p) result[p] = T(0);
    for (int j = 0; j < rank_; ++j) {
      const T c = coefficient(j);
      const T* u = column(j);
      for (int p = 0; p < n_; ++p) result[p] += c * u[p];
    }
    for (int p = 0; p < n_; ++p) result[p] *= root_[p];
  }

  int n_ = 0, rank_ = 0;
  std::vector<T> columns_;  // column-wise
  std::vector<Jet> jets_;
  std::vector<T> root_;  // sqrt(w_p)
};

}  // namespace recon
