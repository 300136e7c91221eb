// Shape functions at one point, with a weight, basis, search and scalar of your own.
//
// This is the template interface beneath reconstruct(): every part is a type that you may supply.
//
// ```cpp
//   recon::KdTree<double, 2> search(particles);
//   recon::ShapeEvaluator<recon::Monomials<2, 1>, MyWeight> shapes(MyWeight{});
//   const auto& shape = shapes.at(x, rho, search, [&](auto p) { return position[p]; });
//   double fit = 0;  // at x, of the data u
//   for (std::size_t i = 0; i < shape.neighbours.size(); ++i)
//     fit += shape.value[i] * u[shape.neighbours[i]];
// ```
//
// Concepts: RadialWeight (weights/weight.hpp), Basis (basis/monomials.hpp), NeighbourSearch
// (neighbourhood/search.hpp); the scalar T is any type with arithmetic, comparison and a square
// root, for example long double. docs/concepts.md has the list, and a minimal model of each, which
// compiles in the tests.
//
// Formulas in local_solve/local_cloud.hpp. An evaluator keeps its arrays: one per thread; with
// given neighbours nothing is allocated once warm.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "recon/local_solve/local_solve.hpp"
#include "recon/neighbourhood/search.hpp"
#include "recon/shape/stencil.hpp"

namespace recon {

// The shape functions at one point x: phi_p(x) and its derivatives for the particles p near it.
template <class T, int D>
struct ShapeFunction {
  std::vector<ParticleIndex> neighbours;
  std::vector<T> value;                               // phi_p, no unit
  std::vector<std::array<T, D>> gradient;             // 1/length
  std::vector<std::array<T, D*(D + 1) / 2>> hessian;  // 1/length^2, diffuse: xx, xy, xz, yy, yz, zz
  FitReport report;
};

template <Basis B, class W, class T = double>
class ShapeEvaluator {
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

  explicit ShapeEvaluator(W weight, Solver solver = Solver::gram_schmidt,
                          WeightForm form = WeightForm::radial, FitTolerances tolerances = {})
      : weights_{std::move(weight)}, form_(form), solve_(solver, tolerances) {
    detail::validate_weight(weights_.weight);
  }

  // Evaluates the shape functions of the given neighbours; position(p) is the Point of particle p.
  // Particles outside the support of radius rho > 0 (a length) get phi = 0. Throws InvalidArgument
  // for a bad rho, x or kind.
  template <class Position>
  requires std::convertible_to<std::invoke_result_t<Position, ParticleIndex>, Point>
  const ShapeFunction<T, D>& at(const Point& x, T rho, std::span<const ParticleIndex> neighbours,
                                Position&& position, Derivative kind = default_gradient) {
    detail::require_derivative(kind);
    detail::require(kind == Derivative::diffuse || has_exact_gradient, "kind", "exact",
                    "must be diffuse for a basis that is not translation_invariant");
    detail::require(rho > T(0) && detail::is_finite(rho), "rho", rho,
                    "must be positive and finite");
    detail::require(rho * rho >= std::numeric_limits<T>::min(), "rho", rho,
                    "must not be so small that its square underflows");
    for (const T& c : x)
      detail::require(detail::is_finite(c), "coordinate of x", c, "must be finite");
    const int count = static_cast<int>(neighbours.size());
    stencil_.start(x, rho, count);
    positions_.clear();
    for (const ParticleIndex p : neighbours) positions_.push_back(position(p));
    for (int d = 0; d < D; ++d)
      for (int p = 0; p < count; ++p) stencil_.offsets(d)[p] = positions_[p][d] - x[d];
    stencil_.weigh(weights_, form_, kind == Derivative::exact);

    const LocalCloud<T, D> cloud = stencil_.cloud();
    shape_.neighbours.assign(neighbours.begin(), neighbours.end());
    shape_.value.assign(count, T(0));
    shape_.gradient.assign(count, {});
    shape_.hessian.assign(count, {});
    shape_.report = solve_.fit(cloud);
    if (shape_.report.rank == 0) return shape_;

    const int n = cloud.size;
    arrays_.resize(static_cast<std::size_t>(n) * detail::jet_size(D));
    const auto out = ShapeArrays<T, D>::in(arrays_.data(), n, kind, true, true);
    solve_.shape_functions(cloud, out);
    for (int p = 0; p < n; ++p) {
      const int at = stencil_.place(p);
      shape_.value[at] = out.value[p];
      for (int d = 0; d < D; ++d) shape_.gradient[at][d] = out.gradient[d][p];
      for (int i = 0; i < D * (D + 1) / 2; ++i) shape_.hessian[at][i] = out.hessian[i][p];
    }
    return shape_;
  }

  // Evaluates the shape functions of all particles that the search finds in the support.
  template <NeighbourSearch S, class Position>
  const ShapeFunction<T, D>& at(const Point& x, T rho, const S& search, Position&& position,
                                Derivative kind = default_gradient) {
    using Scalar = typename S::Scalar;
    static_assert(S::dimension == D, "the search must have the dimension of the basis");
    std::array<Scalar, D> centre, lower, upper;
    for (int d = 0; d < D; ++d) {
      centre[d] = static_cast<Scalar>(x[d]);
      lower[d] = static_cast<Scalar>(x[d] - rho);
      upper[d] = static_cast<Scalar>(x[d] + rho);
    }
    std::vector<Neighbour<Scalar>> found;
    if (form_ == WeightForm::radial)
      search.within(centre, static_cast<Scalar>(rho), found);
    else
      search.in_box(lower, upper, found);
    found_.clear();
    for (const auto& neighbour : found) found_.push_back(neighbour.index);
    return at(x, rho, std::span<const ParticleIndex>(found_), position, kind);
  }

 private:
  // Makes a weight that takes one q per call one that takes an array of them.
  struct Batch {
    W weight;
    void evaluate(const T* q, T* w, T* slope, std::size_t n) const {
      if constexpr (requires { weight.evaluate(q, w, slope, n); }) {
        weight.evaluate(q, w, slope, n);
      } else {
        for (std::size_t i = 0; i < n; ++i) {
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
  LocalSolve<T, B> solve_;
  Stencil<T, D> stencil_;
  ShapeFunction<T, D> shape_;
  std::vector<Point> positions_;
  std::vector<T> arrays_;
  std::vector<ParticleIndex> found_;
};

}  // namespace recon
