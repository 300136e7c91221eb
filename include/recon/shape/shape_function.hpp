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
#include "recon/shape/target_shapes.hpp"

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
  using Shapes = TargetShapes<B, W, T, Growing, LocalSolve<T, B>>;

 public:
  static constexpr int D = B::dimension;
  using Point = std::array<T, D>;
  static constexpr bool has_exact_gradient = Shapes::has_exact_gradient;
  static constexpr Derivative default_gradient = Shapes::default_gradient;

  explicit ShapeEvaluator(W weight, Solver solver = Solver::gram_schmidt,
                          WeightForm form = WeightForm::radial, FitTolerances tolerances = {})
      : form_(form), shapes_(std::move(weight), solver, form, tolerances) {}

  // Evaluates the shape functions of the given neighbours; position(p) is the Point of particle p.
  // Particles outside the support of radius rho > 0 (a length) get phi = 0. Throws InvalidArgument
  // for a bad rho, x or kind.
  template <class Position>
  requires std::convertible_to<std::invoke_result_t<Position, ParticleIndex>, Point>
  const ShapeFunction<T, D>& at(const Point& x, T rho, std::span<const ParticleIndex> neighbours,
                                Position&& position, Derivative kind = default_gradient) {
    const int count = static_cast<int>(neighbours.size());
    const auto offset = [&](int i) {
      Point from_target = position(neighbours[static_cast<std::size_t>(i)]);
      for (int d = 0; d < D; ++d) from_target[d] = from_target[d] - x[d];
      return from_target;
    };
    shape_.report = shapes_.fit(x, rho, count, offset, kind);
    shape_.neighbours.assign(neighbours.begin(), neighbours.end());
    shape_.value.assign(neighbours.size(), T(0));
    shape_.gradient.assign(neighbours.size(), {});
    shape_.hessian.assign(neighbours.size(), {});
    const ShapeArrays<const T, D> phi = shapes_.arrays();
    for (int p = 0; p < shapes_.size(); ++p) {
      const int at = shapes_.place(p);
      shape_.value[at] = phi.value[p];
      for (int d = 0; d < D; ++d) shape_.gradient[at][d] = phi.gradient[d][p];
      for (int i = 0; i < D * (D + 1) / 2; ++i) shape_.hessian[at][i] = phi.hessian[i][p];
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
  WeightForm form_;
  Shapes shapes_;
  ShapeFunction<T, D> shape_;
  std::vector<ParticleIndex> found_;
};

}  // namespace recon
