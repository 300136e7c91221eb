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
//   partial(nx, ny, nz)   one derivative, of order at most 4                     1
//   value.at(offsets), gradient.at(offsets), ...: the same of the local polynomial at these offsets
//                   from each target, offset by offset
//   cell_average, line_integral, own: any linear functionals of the local polynomial
// Of a field of D components, which it mixes:
//   divergence      sum_d du_d/dx_d                                  1/length    1
//   curl            3-D: duz/dy - duy/dz, dux/dz - duz/dx, duy/dx - dux/dy       3
//                   2-D: duy/dx - dux/dy                                         1
//   strain_rate     (du_a/dx_b + du_b/dx_a) / 2 for xx, xy, xz, yy, yz, zz       D (D + 1) / 2
//
// First derivatives are `exact` unless with(Derivative::diffuse) says otherwise: of x -> sum_p
// phi_p(x) u_p, through weights, supports and solve; the diffuse ones are of the local polynomial.
// Derivatives of higher order are of the local polynomial, and zero where it has a lower degree.
// All are zero in directions in which the gradient is not resolved (FitReport::gradient_rank), and
// second ones also where FitReport::hessian_rank is 0, higher ones by the same rule for each order.
//
// The local polynomial of a target is what was fitted to the particles in its support. It
// reproduces polynomials up to the reported degree, and so does each functional of it. What is said
// above of derivatives holds for it: it is constant across directions that are not resolved, and
// derivatives that cannot be told from an unresolved slope are left out. A functional of your own
// is given by what it makes of monomials about the target; the mean over a disc of radius R:
//
// ```cpp
// const double R = 2 * h;
// const auto disc = recon::Functional::own([R](const std::array<int, 3>& n) {
//   if (n[0] % 2 + n[1] % 2 > 0) return 0.0;
//   return n[0] + n[1] == 0 ? 1 : R * R / 4;  // for degrees up to 3
// });
// const auto [mean] = fit.operators(disc);
// ```
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "recon/local_solve/local_cloud.hpp"
#include "recon/points/view.hpp"

namespace recon {

class OwnFunctional;
class VectorFunctional;

// Acts on each component of a field by itself.
class Functional {
 public:
  enum class Kind : std::uint8_t { value, gradient, hessian, laplacian, partial };
  using Powers = std::array<int, max_dimension>;     // 0 along axes that the points do not have
  using Offset = std::array<double, max_dimension>;  // from a target, lengths; 0 along such axes

  static const Functional value, gradient, hessian, laplacian;
  static const VectorFunctional divergence, curl, strain_rate;
  // d^(nx + ny + nz) u / dx^nx dy^ny dz^nz. Throws InvalidArgument for negative orders and for more
  // than 4 in all, the highest degree; orders along axes that the points do not have are refused
  // when it is used.
  static Functional partial(int nx, int ny = 0, int nz = 0);

  // The average of the local polynomial over a box with these edges (>= 0) about the target, and
  // its integral along the straight line from one offset to another. Throw InvalidArgument for what
  // is not finite and for negative edges; lengths along axes that the points do not have are
  // refused when they are used.
  static OwnFunctional cell_average(const Offset& edges);
  static OwnFunctional line_integral(const Offset& from, const Offset& to);
  // A linear functional of your own, given by what it makes of the monomials about the target x_t,
  //     action(powers) = L(prod_d (x_d - x_t,d)^powers[d]) ,
  // with powers that sum to at most the degree; or action(target, powers) where it is another for
  // each target. With lengths in m and L an average, the result of powers {1, 1, 0} is in m^2. It
  // is called concurrently. Using it throws InvalidArgument where an action is not finite, naming
  // powers and target.
  template <class Action>
  requires std::is_invocable_r_v<double, const Action&, const Powers&>
  static OwnFunctional own(Action action);
  template <class Action>
  requires std::is_invocable_r_v<double, const Action&, std::size_t, const Powers&>
  static OwnFunctional own(Action action);
  // Several numbers per target: action(target, powers, out) sets out[0], ..., out[numbers - 1].
  template <class Action>
  requires std::invocable<const Action&, std::size_t, const Powers&, std::span<double>>
  static OwnFunctional own(int numbers, Action action);

  // The same of the local polynomial at offsets from each target: for each offset as many numbers
  // as this has, all derivatives `diffuse`. Throws InvalidArgument for offsets that are not finite.
  OwnFunctional at(std::vector<Offset> offsets) const;

  // The same with first derivatives of this kind.
  constexpr Functional with(Derivative slopes) const {
    Functional other = *this;
    other.slopes_ = slopes;
    return other;
  }

  constexpr Kind kind() const { return kind_; }
  constexpr Derivative slopes() const { return slopes_; }
  constexpr const Powers& orders() const { return orders_; }
  // The order of its derivatives.
  int order() const;

  // The derivatives that each of its numbers is the sum of, in this many dimensions. Throws
  // InvalidArgument for orders along other axes.
  std::vector<std::vector<Powers>> derivatives(int dimension) const;

 private:
  constexpr explicit Functional(Kind kind, Powers orders = {}) : kind_(kind), orders_(orders) {}

  Kind kind_;
  Derivative slopes_ = Derivative::exact;
  Powers orders_;  // of a partial derivative
};

// A linear functional of the local polynomial: Functional::own, cell_average, line_integral, at.
class OwnFunctional {
 public:
  using Powers = Functional::Powers;
  // What it is in a number of dimensions.
  struct Action {
    int numbers = 1;  // for each target and component
    std::function<void(std::size_t target, const Powers& powers, std::span<double> out)> act;
  };

  // The same in any number of dimensions. Throws InvalidArgument for fewer than one number, and for
  // an action without a function.
  static OwnFunctional of(Action action);

  // Throws InvalidArgument where it has no meaning in this many dimensions.
  Action in(int dimension) const { return in_(dimension); }

 private:
  friend class Functional;
  explicit OwnFunctional(std::function<Action(int dimension)> in) : in_(std::move(in)) {}

  std::function<Action(int dimension)> in_;
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

template <class Action>
requires std::is_invocable_r_v<double, const Action&, const Functional::Powers&> OwnFunctional
Functional::own(Action action) {
  return OwnFunctional::of(
      {1, [action = std::move(action)](std::size_t, const Powers& powers, std::span<double> out) {
         out[0] = action(powers);
       }});
}

template <class Action>
requires std::is_invocable_r_v<double, const Action&, std::size_t, const Functional::Powers&>
    OwnFunctional Functional::own(Action action) {
  return OwnFunctional::of({1, [action = std::move(action)](
                                   std::size_t target, const Powers& powers,
                                   std::span<double> out) { out[0] = action(target, powers); }});
}

template <class Action>
requires std::invocable<const Action&, std::size_t, const Functional::Powers&, std::span<double>>
    OwnFunctional Functional::own(int numbers, Action action) {
  return OwnFunctional::of({numbers, std::move(action)});
}

}  // namespace recon
