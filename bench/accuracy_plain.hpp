// Moving least squares without rank handling, as a reference: what most codes and papers do.
//
//   PlainMomentMatrix     M = sum w m m^T, Cholesky, M c = m(0); its only test is whether Cholesky
//                         meets a pivot that is not positive
//   SinglePassGramSchmidt Tran et al. (2019), section 2.4, orthogonalised once, keeping p_j where
//                         <p_j, p_j> != 0; with the corrections of docs/papers.md without which it
//                         is wrong on good clouds too (sum over k, p_{j+1} outside the `if`) and in
//                         the centred, scaled basis
//
// Both fill phi[p] and return whether they think that they succeeded.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "recon/basis/monomials.hpp"
#include "recon/local_solve/local_cloud.hpp"

namespace recon_bench {

template <class T, recon::Basis B>
class PlainMomentMatrix {
 public:
  bool shape_functions(const recon::LocalCloud<T, B::dimension>& cloud, T* phi) {
    using Vector = Eigen::Matrix<T, B::size, 1>;
    std::array<T, pairs> sums{};
    for (int p = 0; p < cloud.size; ++p) {
      const std::array<T, B::size> terms = evaluate(cloud, p);
      add_products(cloud.w[p], terms, sums, std::make_index_sequence<pairs>{});
    }
    Eigen::Matrix<T, B::size, B::size> moments = moments.Zero();
    for (int a = 0; a < pairs; ++a) moments(triangle[a][0], triangle[a][1]) = sums[a];
    const Eigen::LLT<Eigen::Matrix<T, B::size, B::size>> cholesky(moments);
    if (cholesky.info() != Eigen::Success) return false;
    const Vector c = cholesky.solve(Vector::Unit(0));
    for (int p = 0; p < cloud.size; ++p) {
      const std::array<T, B::size> terms = evaluate(cloud, p);
      T sum = T(0);
      for (int j = 0; j < B::size; ++j) sum += terms[j] * c[j];
      phi[p] = cloud.w[p] * sum;
    }
    return true;
  }

 private:
  static constexpr int pairs = B::size * (B::size + 1) / 2;
  // Row and column of the entries of the lower triangle.
  static constexpr std::array<std::array<int, 2>, pairs> triangle = [] {
    std::array<std::array<int, 2>, pairs> all{};
    for (int j = 0, at = 0; j < B::size; ++j)
      for (int i = j; i < B::size; ++i) all[at++] = {i, j};
    return all;
  }();

  // Written out entry by entry, so that the sums stay in registers.
  template <std::size_t... a>
  static void add_products(T w, const std::array<T, B::size>& terms, std::array<T, pairs>& sums,
                           std::index_sequence<a...>) {
    ((sums[a] += w * terms[triangle[a][0]] * terms[triangle[a][1]]), ...);
  }

  static std::array<T, B::size> evaluate(const recon::LocalCloud<T, B::dimension>& cloud, int p) {
    std::array<T, B::size> terms;
    B::evaluate(cloud.at(p), terms.data());
    return terms;
  }
};

template <class T, recon::Basis B>
class SinglePassGramSchmidt {
 public:
  bool shape_functions(const recon::LocalCloud<T, B::dimension>& cloud, T* phi) {
    const int n = cloud.size;
    fill(cloud);
    std::fill(phi, phi + n, T(0));
    for (int j = 0; j < B::size; ++j) {
      T* p = p_.data() + static_cast<std::size_t>(j) * (n + 1);
      const T* q = q_.data() + static_cast<std::size_t>(j) * (n + 1);
      std::copy(q, q + n + 1, p);
      for (int k = 0; k < j; ++k) {
        if (products_[k] == T(0)) continue;
        const T* other = p_.data() + static_cast<std::size_t>(k) * (n + 1);
        const T r = product(cloud.w, q, other, n) / products_[k];
        for (int i = 0; i <= n; ++i) p[i] -= r * other[i];
      }
      products_[j] = product(cloud.w, p, p, n);
      if (products_[j] == T(0)) continue;
      const T factor = p[n] / products_[j];
      for (int i = 0; i < n; ++i) phi[i] += cloud.w[i] * factor * p[i];
    }
    return true;
  }

  // max |u_i . u_j - delta_ij| of the polynomials that it kept, brought to length 1.
  double loss_of_orthogonality(const recon::LocalCloud<T, B::dimension>& cloud) const {
    const int n = cloud.size;
    double loss = 0;
    for (int i = 0; i < B::size; ++i)
      for (int j = 0; j < i; ++j) {
        if (products_[i] == T(0) || products_[j] == T(0)) continue;
        const T* p = p_.data() + static_cast<std::size_t>(i) * (n + 1);
        const T* other = p_.data() + static_cast<std::size_t>(j) * (n + 1);
        const double scale = std::sqrt(static_cast<double>(products_[i])) *
                             std::sqrt(static_cast<double>(products_[j]));
        loss = std::max(loss, std::abs(static_cast<double>(product(cloud.w, p, other, n))) / scale);
      }
    return loss;
  }

 private:
  static T product(const T* w, const T* a, const T* b, int n) {
    T sum = T(0);
    for (int i = 0; i < n; ++i) sum += w[i] * a[i] * b[i];
    return sum;
  }

  // The monomials at the particles, column-wise, and at the target in the last place.
  void fill(const recon::LocalCloud<T, B::dimension>& cloud) {
    const int n = cloud.size;
    const auto stride = static_cast<std::size_t>(n + 1);
    q_.resize(stride * B::size);
    p_.resize(stride * B::size);
    std::array<T, B::size> terms;
    for (int i = 0; i <= n; ++i) {
      B::evaluate(i < n ? cloud.at(i) : std::array<T, B::dimension>{}, terms.data());
      for (int j = 0; j < B::size; ++j) q_[static_cast<std::size_t>(j) * stride + i] = terms[j];
    }
  }

  std::vector<T> q_, p_;
  std::array<T, B::size> products_{};  // <p_j, p_j>
};

}  // namespace recon_bench
