// Functionals: what one can ask of the reconstructed field at each target.
//
// ```cpp
// const auto [v, grad, lap] = fit.operators(
//     recon::Functional::value, recon::Functional::gradient, recon::Functional::laplacian);
// const auto heat = v + dt * lap;  // operators on one pattern add up
// ```
//
// Of each component of a field:
//   value           u                                                            1 number
//   gradient        du/dx, du/dy, du/dz                              1/length    D
//   hessian         xx, xy, xz, yy, yz, zz as far as they exist      1/length^2  D (D + 1) / 2
//   laplacian       sum_d d2u/dx_d^2                                 1/length^2  1
//   partial(nx, ny, nz)   one derivative of order at most 2                      1
// Of a field of D components, which it mixes:
//   divergence      sum_d du_d/dx_d                                  1/length    1
//   curl            3-D: duz/dy - duy/dz, dux/dz - duz/dx, duy/dx - dux/dy       3
//                   2-D: duy/dx - dux/dy                                         1
//   strain_rate     (du_a/dx_b + du_b/dx_a) / 2 for xx, xy, xz, yy, yz, zz       D (D + 1) / 2
//
// First derivatives are `exact` unless with(Derivative::diffuse) says otherwise: of x -> sum_p
// phi_p(x) u_p, through weights, supports and solve; the diffuse ones are of the local polynomial.
// Second derivatives are of the local polynomial, and zero below degree 2. All are zero in
// directions in which the gradient is not resolved (FitReport::gradient_rank).
#pragma once

#include <array>
#include <cstdint>

#include "recon/local_solve/local_cloud.hpp"
#include "recon/points/view.hpp"

namespace recon {

// Acts on each component of a field by itself.
class Functional {
 public:
  enum class Kind : std::uint8_t { value, gradient, hessian, laplacian, partial };

  static const Functional value, gradient, hessian, laplacian;
  static const class VectorFunctional divergence, curl, strain_rate;
  // d^(nx + ny + nz) u / dx^nx dy^ny dz^nz. Throws InvalidArgument for negative orders and for more
  // than 2 in all; orders along axes that the points do not have are refused when it is used.
  static Functional partial(int nx, int ny = 0, int nz = 0);

  // The same with first derivatives of this kind.
  constexpr Functional with(Derivative slopes) const {
    Functional other = *this;
    other.slopes_ = slopes;
    return other;
  }

  constexpr Kind kind() const { return kind_; }
  constexpr Derivative slopes() const { return slopes_; }
  constexpr const std::array<int, max_dimension>& orders() const { return orders_; }

 private:
  constexpr explicit Functional(Kind kind, std::array<int, max_dimension> orders = {})
      : kind_(kind), orders_(orders) {}

  Kind kind_;
  Derivative slopes_ = Derivative::exact;
  std::array<int, max_dimension> orders_;  // of a partial derivative
};

// Acts on fields of D components, through their gradient.
class VectorFunctional {
 public:
  enum class Kind : std::uint8_t { divergence, curl, strain_rate };

  constexpr explicit VectorFunctional(Kind kind) : kind_(kind) {}
  constexpr VectorFunctional with(Derivative slopes) const {
    VectorFunctional other = *this;
    other.slopes_ = slopes;
    return other;
  }

  constexpr Kind kind() const { return kind_; }
  constexpr Derivative slopes() const { return slopes_; }

 private:
  Kind kind_;
  Derivative slopes_ = Derivative::exact;
};

inline constexpr Functional Functional::value{Kind::value};
inline constexpr Functional Functional::gradient{Kind::gradient};
inline constexpr Functional Functional::hessian{Kind::hessian};
inline constexpr Functional Functional::laplacian{Kind::laplacian};
inline constexpr VectorFunctional Functional::divergence{VectorFunctional::Kind::divergence};
inline constexpr VectorFunctional Functional::curl{VectorFunctional::Kind::curl};
inline constexpr VectorFunctional Functional::strain_rate{VectorFunctional::Kind::strain_rate};

}  // namespace recon
