// One target's local least-squares problem: minimise sum_p w_p (sum_j a_j m_j(xi_p) - u_p)^2.
//
// Shapes: n particles, terms m_j of a basis (basis/monomials.hpp). The results are shape functions
//     phi_p = w_p m(xi_p)^T M^-1 m(0) ,   M = sum_p w_p m(xi_p) m(xi_p)^T   (the moment matrix),
// so that the fit at the target is sum_p phi_p u_p (Gong 2015, eq. 3.8 with b(0); corrected form of
// Tran et al. 2019, eq. 17), and their derivatives:
//   diffuse  of the local polynomial, the target held:  d phi_p = w_p m_p^T M^-1 dm(0)
//   exact    of x -> phi_p(x), through weights and solve:
//            d phi_p = dw_p lambda_p + w_p m_p^T M^-1 (dm(0) - sum_q dw_q lambda_q m_q)
//            with lambda_q = m_q^T M^-1 m(0).
// The second form holds the basis still while the target moves, which is allowed because the space
// of polynomials is the same about every point.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "recon/core/error.hpp"
#include "recon/core/lanes.hpp"
#include "recon/local_solve/report.hpp"

namespace recon {

// The input of one fit; the arrays are the caller's. All particles have w > 0, except in a
// pack: lanes with fewer particles than others have w = 0 (and xi = 0, dw = 0) in the entries
// that they lack.
template <class T, int D>
struct LocalCloud {
  int size = 0;                  // n
  std::array<const T*, D> xi{};  // scaled offsets (x_p - x) / rho, per axis, no unit
  const T* w = nullptr;          // weights, > 0, largest about 1
  std::array<const T*, D> dw{};  // d w_p / d x along each axis, 1/length; null if not asked for
  T rho = T(1);                  // support radius, a length
  T noise =
      T(std::numeric_limits<ScalarOf<T>>::epsilon());  // rounding of xi: eps (|x| + rho) / rho

  constexpr std::array<T, D> at(int p) const {
    std::array<T, D> x;
    for (int d = 0; d < D; ++d) x[d] = xi[d][p];
    return x;
  }
};

// The limits below which a term or a direction counts as unresolved; gram_schmidt.hpp says
// how they are used.
struct FitTolerances {
  double rank = 1e-10;     // drop a direction whose independent part is below this fraction of it
  double leverage = 30.0;  // drop a direction whose value at the target exceeds this times its size
                           // at the particles
  // No slope across particles that extend less than this many support radii; 0: any slope
  // (gradient_resolution.hpp).
  double gradient_extent = 1e-3;
};

// Which derivatives of the shape functions to form.
enum class Derivative { diffuse, exact };

namespace detail {
constexpr void require_derivative(Derivative kind) {
  require(kind == Derivative::diffuse || kind == Derivative::exact, "kind of derivative",
          static_cast<int>(kind), "must be an enumerator of recon::Derivative");
}
}  // namespace detail

// The results, n entries in each array; null pointers are not written. Gradients have the unit
// 1/length. Hessians (diffuse only) have 1/length^2 and the entries xx, xy, xz, yy, yz, zz as far
// as the dimension has them.
template <class T, int D>
struct ShapeArrays {
  T* value = nullptr;
  std::array<T*, D> gradient{};
  std::array<T*, D*(D + 1) / 2> hessian{};
  Derivative kind = Derivative::exact;

  // Lays arrays of n numbers side by side in `memory`, which must hold jet_size(D) of them.
  static constexpr ShapeArrays in(T* memory, int n, Derivative kind, bool gradient, bool hessian) {
    ShapeArrays out;
    out.kind = kind;
    out.value = memory;
    for (int d = 0; d < D && gradient; ++d) out.gradient[d] = memory + (1 + d) * n;
    for (std::size_t i = 0; i < out.hessian.size() && hessian; ++i)
      out.hessian[i] = memory + (1 + D + static_cast<int>(i)) * n;
    return out;
  }

  constexpr bool wants_gradient() const { return gradient[0] != nullptr; }
  constexpr bool wants_hessian() const { return hessian[0] != nullptr; }
};

namespace detail {

// A direction must extend this many times the rounding of the coordinates to count as more than
// rounding. On particles that lie on a line or sphere up to rounding, the independent part measures
// 0.3 to 2 roundings.
inline constexpr int rounding_margin = 8;

// Thresholds in the precision of T. All are about the independent part p of a term or direction q,
// relative to the whole of it.
template <class T>
struct Thresholds {
  T drop;              // ||p|| / ||q|| at or below: not resolved
  T clear2;            // (||p|| / ||q||)^2 above: clearly resolved, no closer look needed
  T well_conditioned;  // as clear2, for the moment matrix, which loses digits as 1 / pivot

  constexpr Thresholds(const FitTolerances& tolerances, const T& noise) {
    using Scalar = ScalarOf<T>;
    const Scalar eps = std::numeric_limits<Scalar>::epsilon();
    const Scalar root = square_root(eps);
    const T rounding = T(Scalar(rounding_margin)) * larger(noise, T(eps));
    drop = larger(T(static_cast<Scalar>(tolerances.rank)), rounding);
    const T margin = T(Scalar(100)) * drop * drop;
    clear2 = larger(margin, T(root));
    well_conditioned = larger(margin, T(square_root(root)));  // a quarter of the digits may go
  }
};

// The square of the largest amplification, in units of the support, of a slope that is resolved in
// a fit of this degree: gradient_resolution.hpp.
template <class Scalar>
constexpr Scalar gradient_limit2(const FitTolerances& tolerances, int degree) {
  const Scalar extent = static_cast<Scalar>(tolerances.gradient_extent);
  const Scalar limit = static_cast<Scalar>(degree * degree) / extent;
  return extent > Scalar(0) ? Scalar(limit * limit) : std::numeric_limits<Scalar>::max();
}

// The number of Taylor coefficients of order <= 2, which are numbered as the monomials
// of degree <= 2.
constexpr int jet_size(int dimension) {
  return 1 + dimension + dimension * (dimension + 1) / 2;
}

}  // namespace detail
}  // namespace recon
