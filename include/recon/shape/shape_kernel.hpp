// Shape functions of a range of targets: the compiled inner part of every reconstruction.
//
// Dimension, degree and solver are template parameters inside; here they are values. One call
// evaluates many targets, so the choice is made outside the loops. For the formulas see
// local_solve/local_cloud.hpp; for weights weights/weight.hpp.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>

#include "recon/core/instruction_set.hpp"
#include "recon/local_solve/local_cloud.hpp"
#include "recon/neighbourhood/neighbour_list.hpp"
#include "recon/points/point_cloud.hpp"
#include "recon/weights/weight.hpp"

namespace recon {

struct ShapeChoice {
  int degree = 1;
  WeightFunction weight = Weight::cubic_b_spline;
  WeightForm form = WeightForm::radial;
  Solver solver = Solver::gram_schmidt;
  FitTolerances tolerances{};
  InstructionSet instruction_set = InstructionSet::generic;  // not automatic: see resolved()
};

template <class Scalar>
struct ShapeProblem {
  const PointCloud<Scalar>& particles;
  const PointCloud<Scalar>& targets;
  NeighbourListView<Scalar> neighbours;
  const PeriodicDomain<Scalar>& domain;
  // Derivatives are multiplied by this along each axis: 1 / stretch, where coordinates have been
  // divided by stretch.
  static constexpr std::array<Scalar, max_dimension> no_scale{1, 1, 1};
  std::array<Scalar, max_dimension> axis_scale = no_scale;
  // The factors m_p of the weights of the particles, > 0, the largest about 1. Null: all ones.
  const Scalar* particle_weights = nullptr;
};

// The output arrays, null where not wanted. Entry e of the neighbour list has value[e], gradient[e
// * D + d] and hessian[e * D (D + 1) / 2 + i] (xx, xy, xz, yy, yz, zz as far as they exist); target
// t has report[t].
template <class Scalar>
struct ShapeRows {
  Scalar* value = nullptr;
  Scalar* gradient = nullptr;
  Scalar* hessian = nullptr;  // diffuse
  Derivative kind = Derivative::exact;
  FitReport* report = nullptr;
};

// Linear functionals L_i of the local polynomial, from what they make of monomials. Entry e of the
// neighbour list has value[e * numbers + i].
template <class Scalar>
struct FunctionalRows {
  Scalar* value = nullptr;
  int numbers = 0;
  // Sets out[i] to L_i of the monomial (x - x_t)^powers about target t, whose unit is a power of
  // that of the lengths; it may throw. Called concurrently.
  std::function<void(std::size_t t, const std::array<int, max_dimension>& powers,
                     std::span<double> out)>
      action;
};

template <class Scalar>
class ShapeKernel {
 public:
  virtual ~ShapeKernel() = default;
  // Evaluates the targets begin <= t < end, which are best in an order in which neighbours in space
  // follow each other. Thread-safe; no allocation per target.
  virtual void evaluate(const ShapeProblem<Scalar>& problem, std::size_t begin, std::size_t end,
                        const ShapeRows<Scalar>& rows) const = 0;
  // The same for functionals of the local polynomial as far as it is resolved
  // (local_solve/orthonormal_fit.hpp): without derivatives in directions in which those are not.
  // Each target is fitted by Gram-Schmidt, whose polynomial is that of every other solver. Throws
  // InvalidArgument where an action is not finite or so large that it overflows.
  virtual void evaluate(const ShapeProblem<Scalar>& problem, std::size_t begin, std::size_t end,
                        const FunctionalRows<Scalar>& rows) const = 0;
  // Gives back the memory that is kept from one call to the next.
  virtual void forget_buffers() const = 0;
};

// Throws InvalidArgument for a dimension outside 1..3 or a degree outside 0..4.
template <class Scalar>
std::unique_ptr<ShapeKernel<Scalar>> make_shape_kernel(int dimension, const ShapeChoice& choice);

extern template std::unique_ptr<ShapeKernel<float>> make_shape_kernel(int, const ShapeChoice&);
extern template std::unique_ptr<ShapeKernel<double>> make_shape_kernel(int, const ShapeChoice&);

}  // namespace recon
