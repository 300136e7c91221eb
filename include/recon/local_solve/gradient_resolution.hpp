// In which directions the slope of a local fit is resolved, and how much it amplifies errors.
//
// Let P_j be polynomials that are orthonormal on the particles (sum_p w_p P_i P_j = delta_ij),
// and G_j their gradients at the target, in xi = (x_p - x) / rho. The slope of the fit along a
// unit vector n is
//     n . g = (1 / rho) sum_p w_p sum_j (n . G_j) P_j(xi_p) u_p ,
// and by Cauchy and Schwarz it amplifies errors in the data, in units of rho, at most
// a(n) times, where
//     a(n) = sqrt(sum_p w_p  n^T S n) ,   S = sum_j G_j G_j^T:  the linear block of M^-1.
// At degree 1, 1 / a(n) is the extent of the particles along n, in support radii: their weighted
// standard deviation. A polynomial of degree R may be R^2 times as steep (Markov 1889), so that the
// extent is taken to be R^2 / a(n). It also shrinks where curved terms explain the linear one, as
// on a thin curved sheet. Where the extent is below FitTolerances::gradient_extent a slope has no
// meaning: noise of the data would be divided by next to nothing. The gradient is then projected
// onto the other directions.
//
// The default of 1e-3 was chosen by measurement: with two or more neighbours per term no target in,
// at the wall of, or outside the corner of regular, jittered and random clouds in 2-D and 3-D has
// an extent below 0.015 (degree 1 to 4); random clouds squeezed to a hundredth of their width keep
// all, and those squeezed to a thousandth most of theirs. In sheets, noise of 1e-4 spacings has an
// extent of 3e-5.
//
// The directions are the eigenvectors of S. They are found from the G_j themselves (one-sided
// Jacobi, Hestenes 1958), so that a thickness of 1e-12 beside an extent of 1 loses no digits
// to the squares.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "recon/core/lanes.hpp"

namespace recon::detail {

template <class T, int D>
struct GradientResolution {
  int rank = 0;             // directions in which the slope is resolved
  T amplification2 = T(0);  // the largest a(e_d)^2 over the axes of what is left
  std::array<std::array<T, D>, D> projector{};  // onto those directions
  std::array<bool, D> dropped{};                // which rows of `slope` are not resolved

  // slope[d] has `count` numbers, component d of each G_j. They are overwritten by the components
  // of G_j along the directions found, which are orthogonal to each other. Of the D directions only
  // `linear` have a slope at all: those along which linear terms were kept. Directions n whose
  // a(n)^2 exceeds `limit2` are dropped.
  static constexpr GradientResolution of(const std::array<T*, D>& slope, int count,
                                         const T& weight_sum, int linear, const T& limit2) {
    using std::abs;
    std::array<std::array<T, D>, D> turned{};  // rows: the directions
    for (int d = 0; d < D; ++d) turned[d][d] = T(1);
    const T tolerance = T(4) * std::numeric_limits<T>::epsilon();
    bool done = false;
    for (int sweep = 0; sweep < 30 && !done; ++sweep) {
      done = true;
      for (int a = 0; a < D; ++a)
        for (int b = a + 1; b < D; ++b) {
          const T xx = square(slope[a], count), yy = square(slope[b], count);
          T xy = T(0);
          for (int j = 0; j < count; ++j) xy += slope[a][j] * slope[b][j];
          if (!(T(abs(xy)) > T(tolerance * square_root(xx) * square_root(yy)))) continue;
          done = false;
          const T zeta = (yy - xx) / (T(2) * xy);
          const T t =
              (zeta >= T(0) ? T(1) : T(-1)) / T(abs(zeta) + square_root(T(T(1) + zeta * zeta)));
          const T c = T(1) / square_root(T(T(1) + t * t)), s = c * t;
          const auto turn = [&](T* u, T* v, int n) {
            for (int i = 0; i < n; ++i) {
              const T first = u[i];
              u[i] = c * first - s * v[i];
              v[i] = s * first + c * v[i];
            }
          };
          turn(slope[a], slope[b], count);
          turn(turned[a].data(), turned[b].data(), D);
        }
    }
    std::array<T, D> a2;
    std::array<int, D> order;
    for (int d = 0; d < D; ++d) {
      a2[d] = weight_sum * square(slope[d], count);
      order[d] = d;
      for (int i = d; i > 0 && a2[order[i]] > a2[order[i - 1]]; --i)
        std::swap(order[i], order[i - 1]);
    }
    GradientResolution found;
    std::array<T, D> left{};
    for (int i = 0; i < linear; ++i) {
      const int k = order[i];
      found.dropped[k] = !(a2[k] <= limit2);
      if (found.dropped[k]) continue;
      ++found.rank;
      for (int d = 0; d < D; ++d) {
        left[d] += turned[k][d] * turned[k][d] * a2[k];
        for (int e = 0; e < D; ++e) found.projector[d][e] += turned[k][d] * turned[k][e];
      }
    }
    found.amplification2 = *std::max_element(left.begin(), left.end());
    return found;
  }

  // The part of a vector in the resolved directions.
  constexpr std::array<T, D> project(const std::array<T, D>& vector) const {
    std::array<T, D> part{};
    for (int d = 0; d < D; ++d)
      for (int e = 0; e < D; ++e) part[d] += projector[d][e] * vector[e];
    return part;
  }

 private:
  static constexpr T square(const T* a, int n) {
    T sum = T(0);
    for (int i = 0; i < n; ++i) sum += a[i] * a[i];
    return sum;
  }
};

}  // namespace recon::detail
