// Matrices of D x D numbers for code that runs on a GPU: the functions of Eigen's that materials
// (mpm/material.hpp) and what happens to single particles (mpm/pointwise.hpp) use, by their names.
// Eigen itself is for the processor here.
#pragma once

#include "cuda/device_code.hpp"

namespace recon::mpm {

template <int D>
struct SmallMatrix {
  static constexpr int RowsAtCompileTime = D;
  double of[D * D];  // column after column, as in the arrays of particles

  RECON_DEVICE constexpr double& operator()(int row, int column) { return of[column * D + row]; }
  RECON_DEVICE constexpr double operator()(int row, int column) const {
    return of[column * D + row];
  }

  RECON_DEVICE static constexpr SmallMatrix Zero() {
    SmallMatrix zero{};
    return zero;
  }
  RECON_DEVICE static constexpr SmallMatrix Identity() {
    SmallMatrix one{};
    for (int d = 0; d < D; ++d) one(d, d) = 1;
    return one;
  }
  RECON_DEVICE static constexpr SmallMatrix at(const double* numbers) {
    SmallMatrix matrix{};
    for (int k = 0; k < D * D; ++k) matrix.of[k] = numbers[k];
    return matrix;
  }
  RECON_DEVICE constexpr void put(double* numbers) const {
    for (int k = 0; k < D * D; ++k) numbers[k] = of[k];
  }

  RECON_DEVICE constexpr SmallMatrix transpose() const {
    SmallMatrix turned{};
    for (int r = 0; r < D; ++r)
      for (int c = 0; c < D; ++c) turned(c, r) = (*this)(r, c);
    return turned;
  }
  RECON_DEVICE constexpr double trace() const {
    double sum = 0;
    for (int d = 0; d < D; ++d) sum += (*this)(d, d);
    return sum;
  }
  RECON_DEVICE constexpr double sum() const {
    double all = 0;
    for (int k = 0; k < D * D; ++k) all += of[k];
    return all;
  }
  RECON_DEVICE constexpr SmallMatrix cwiseProduct(const SmallMatrix& other) const {
    SmallMatrix product{};
    for (int k = 0; k < D * D; ++k) product.of[k] = of[k] * other.of[k];
    return product;
  }
  RECON_DEVICE constexpr double squaredNorm() const { return cwiseProduct(*this).sum(); }
  // det A times the inverse.
  RECON_DEVICE constexpr SmallMatrix adjugate() const {
    const SmallMatrix& a = *this;
    SmallMatrix out{};
    if constexpr (D == 1) {
      out(0, 0) = 1;
    } else if constexpr (D == 2) {
      out(0, 0) = a(1, 1);
      out(0, 1) = -a(0, 1);
      out(1, 0) = -a(1, 0);
      out(1, 1) = a(0, 0);
    } else {
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          const int i = (c + 1) % 3, j = (c + 2) % 3, k = (r + 1) % 3, l = (r + 2) % 3;
          out(r, c) = a(i, k) * a(j, l) - a(i, l) * a(j, k);
        }
    }
    return out;
  }
  RECON_DEVICE constexpr double determinant() const {
    if constexpr (D == 1) return of[0];
    const SmallMatrix cofactors = adjugate();
    double sum = 0;
    for (int c = 0; c < D; ++c) sum += (*this)(0, c) * cofactors(c, 0);
    return sum;
  }
  RECON_DEVICE constexpr SmallMatrix inverse() const { return adjugate() / determinant(); }

  RECON_DEVICE constexpr SmallMatrix& operator+=(const SmallMatrix& other) {
    for (int k = 0; k < D * D; ++k) of[k] += other.of[k];
    return *this;
  }
  RECON_DEVICE friend constexpr SmallMatrix operator+(SmallMatrix a, const SmallMatrix& b) {
    return a += b;
  }
  RECON_DEVICE friend constexpr SmallMatrix operator-(SmallMatrix a, const SmallMatrix& b) {
    for (int k = 0; k < D * D; ++k) a.of[k] -= b.of[k];
    return a;
  }
  RECON_DEVICE friend constexpr SmallMatrix operator*(double factor, SmallMatrix a) {
    for (int k = 0; k < D * D; ++k) a.of[k] *= factor;
    return a;
  }
  RECON_DEVICE friend constexpr SmallMatrix operator*(const SmallMatrix& a, double factor) {
    return factor * a;
  }
  RECON_DEVICE friend constexpr SmallMatrix operator/(SmallMatrix a, double divisor) {
    for (int k = 0; k < D * D; ++k) a.of[k] /= divisor;
    return a;
  }
  RECON_DEVICE friend constexpr SmallMatrix operator*(const SmallMatrix& a, const SmallMatrix& b) {
    SmallMatrix product{};
    for (int r = 0; r < D; ++r)
      for (int c = 0; c < D; ++c)
        for (int k = 0; k < D; ++k) product(r, c) += a(r, k) * b(k, c);
    return product;
  }
};

}  // namespace recon::mpm
