// The shape functions of one target from the offsets of its neighbours: the whole path from weights
// to phi_p, without a search and without lists.
//
// It runs in constant expressions and in the threads of a GPU, and allocates nothing with memory of
// compile-time size or of the caller's (core/memory.hpp):
//
// ```cpp
//   using Shapes =
//       recon::TargetShapes<recon::Monomials<2, 2>, recon::BSpline<3>, double, recon::RoomFor<32>>;
//   Shapes shapes(recon::BSpline<3>{}, recon::Solver::moment_matrix);
//   const auto offset = [&](int i) {
//     return std::array<double, 2>{position[i][0] - x[0], position[i][1] - x[1]};
//   };
//   const recon::FitReport report = shapes.fit(x, rho, 20, offset);
//   double value = 0;  // at x, of the data u
//   for (int p = 0; p < shapes.size(); ++p) value += shapes.arrays().value[p] * u[shapes.place(p)];
// ```
//
// ShapeEvaluator (shape_function.hpp) adds the search and results in the order of the neighbours.
#pragma once

#include <array>
#include <concepts>
#include <limits>
#include <type_traits>
#include <utility>

#include "recon/core/memory.hpp"
#include "recon/local_solve/safe_solve.hpp"
#include "recon/shape/stencil.hpp"

namespace recon {

// Solve: SafeSolve, or a class with its functions.
template <Basis B, class W, class T = double, class Memory = Growing,
          class Solve = SafeSolve<T, B, Memory>>
class TargetShapes {
  static_assert(RadialWeight<W, T>,
                "a weight needs w(q) and derivative(q), const, in the scalar of the evaluator, and "
                "must be copyable: see RadialWeight in recon/weights/weight.hpp");

 public:
  static constexpr int D = B::dimension;
  using Point = std::array<T, D>;
  // Exact gradients hold the basis still while the target moves. That needs a space of functions
  // that is the same about every point: polynomials are; a basis of your own says so with `static
  // constexpr bool translation_invariant = true`. Others have diffuse gradients only.
  static constexpr bool has_exact_gradient = [] {
    if constexpr (requires { B::translation_invariant; }) return bool(B::translation_invariant);
    return detail::is_monomials<B>;
  }();
  static constexpr Derivative default_gradient =
      has_exact_gradient ? Derivative::exact : Derivative::diffuse;

  // What is taken from a Workspace for this many neighbours.
  static constexpr std::size_t bytes_for(int most) {
    return Solve::bytes_for(most) + Stencil<T, D, Memory>::bytes_for(most) +
           Workspace::bytes_for<T>(each * static_cast<std::size_t>(most));
  }

  // Throws InvalidArgument for a bad weight, solver or form.
  constexpr explicit TargetShapes(W weight, Solver solver = Solver::gram_schmidt,
                                  WeightForm form = WeightForm::radial,
                                  FitTolerances tolerances = {}, Memory memory = {})
      : weights_{std::move(weight)},
        form_(form),
        solve_(solver, tolerances, memory),
        stencil_(memory),
        values_(memory.template make<T, 0, each>()) {
    detail::require_form(form);
    detail::validate_weight(weights_.weight);
  }

  // Fits at x, with support radius rho > 0 (a length), the neighbours 0 <= i < count that are at
  // x + offset(i). Throws InvalidArgument for a bad x, rho or kind, and for more neighbours than
  // there is memory for.
  template <class Offset>
  requires std::convertible_to<std::invoke_result_t<Offset&, int>, Point>
  constexpr FitReport fit(const Point& x, T rho, int count, Offset&& offset,
                          Derivative kind = default_gradient) {
    detail::require_derivative(kind);
    detail::require(kind == Derivative::diffuse || has_exact_gradient, "kind", "exact",
                    "must be diffuse for a basis that is not translation_invariant");
    detail::require(rho > T(0) && detail::is_finite(rho), "rho", rho,
                    "must be positive and finite");
    detail::require(rho * rho >= std::numeric_limits<T>::min(), "rho", rho,
                    "must not be so small that its square underflows");
    for (const T& c : x)
      detail::require(detail::is_finite(c), "coordinate of x", c, "must be finite");
    size_ = 0;
    stencil_.start(x, rho, count);
    for (int i = 0; i < count; ++i) {
      const Point from_target = offset(i);
      for (int d = 0; d < D; ++d) stencil_.offsets(d)[i] = from_target[d];
    }
    stencil_.weigh(weights_, form_, kind == Derivative::exact);
    const LocalCloud<T, D> cloud = stencil_.cloud();
    const FitReport report = solve_.fit(cloud);
    if (report.rank == 0) return report;
    size_ = cloud.size;
    kind_ = kind;
    detail::provide(values_, each * static_cast<std::size_t>(size_));
    solve_.shape_functions(cloud, arrays_of(values_.data()));
    return report;
  }

  // Of the last fit: the number of particles with a weight, which of the neighbours particle p is,
  // and phi_p and its derivatives for each particle.
  constexpr int size() const { return size_; }
  constexpr int place(int p) const { return stencil_.place(p); }
  constexpr ShapeArrays<const T, D> arrays() const { return arrays_of<const T>(values_.data()); }

 private:
  static constexpr std::size_t each = detail::jet_size(D);

  template <class Number>
  constexpr ShapeArrays<Number, D> arrays_of(Number* memory) const {
    return ShapeArrays<Number, D>::in(memory, size_, kind_, true, true);
  }

  // Makes a weight that takes one q per call one that takes an array of them.
  struct Batch {
    W weight;
    constexpr void evaluate(const T* q, T* w, T* slope, int n) const {
      if constexpr (requires { weight.evaluate(q, w, slope, std::size_t{}); }) {
        weight.evaluate(q, w, slope, static_cast<std::size_t>(n));
      } else {
        for (int i = 0; i < n; ++i) {
          w[i] = q[i] < T(1) ? T(weight(q[i])) : T(0);
          detail::require_weight(q[i], w[i]);
          if (!slope) continue;
          slope[i] = q[i] < T(1) ? T(weight.derivative(q[i])) : T(0);
          detail::require_slope(q[i], slope[i]);
        }
      }
    }
  };

  Batch weights_;
  WeightForm form_;
  Derivative kind_ = default_gradient;
  int size_ = 0;
  Solve solve_;
  Stencil<T, D, Memory> stencil_;
  typename Memory::template Store<T, 0, each> values_;
};

}  // namespace recon
