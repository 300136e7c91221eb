// Sums over kernels: how much of something lies at a place, per volume.
//
//     s(x) = sum_p a_p W(x - x_p) ,   W = w(q) / (c rho^D) ,   q = |x - x_p| / rho ,
//     c = integral of w over the unit support ,
//
// with the amounts a_p of the particles (mass: the density; 1: the number density; volume: the
// solid fraction), a weight w and the support radius rho of the target or the pair, a length (Lucy
// 1977; Gingold, Monaghan 1977). W has a unit integral, so the integral of s over all space is the
// sum of the amounts where all targets have the same rho, or each particle its own. Images across
// periodic borders count. Near a wall or a free surface part of the support is empty, and s falls
// off over one support radius; it is not divided by the part that is filled: that is reconstruct()
// with degree 0.
//
// Where supports are ellipsoids, q is |A^-1 (x_p - x)| with the support tensor A of the target or
// the pair (neighbourhood/support_tensor.hpp), and rho^D becomes det A.
//
// 1 / (c rho^D) must be a normal number of the precision, so that no digit is lost: in 3-D for rho
// from about 1e-12 to 1e12 in float, and from 1e-102 to 1e102 in double.
//
// ```cpp
// auto rho = recon::kernel_sum(sources, targets, mass, recon::Weight::cubic_b_spline, 2 * h);
// ```
#pragma once

#include "recon/neighbourhood/sources.hpp"
#include "recon/operators/csr_operator.hpp"
#include "recon/weights/weight.hpp"

namespace recon {

struct KernelOptions {
  WeightFunction weight = Weight::cubic_b_spline;
  // tensor_product: w = prod_d w(|x_p - x|_d / rho), the support a cube.
  WeightForm form = WeightForm::radial;
  // Radius{rho}, Radii{per target} or PairRadii, Ellipsoids{per target} or PairEllipsoids: with
  // radii or tensors of the particles the density of smoothed particle hydrodynamics in its scatter
  // form. Nearest and NearestWithin give each target the support that a reconstruction with that
  // rule has; all particles in it count, not only the k nearest.
  NeighbourRule support = Nearest{20};
  SearchMethod search = SearchMethod::automatic;
  int threads = 0;  // 0: default_threads(); the results do not depend on it
  InstructionSet instruction_set = InstructionSet::automatic;
};

// The sums as an operator: a row per target with the W of its particles, 1 / length^D. Of no
// particle the sum is 0. Throws InvalidArgument for bad targets and rules, for weights without an
// integral, and for a rho whose 1 / (c rho^D) is not a normal number, naming target, rho and
// precision.
template <class Scalar>
CsrOperator<Scalar> kernel_operator(const BasicSources<Scalar>& sources,
                                    const PointsView<Scalar>& targets,
                                    const KernelOptions& options);

// The sums for one field of amounts, of any number of components: a row per target. `radius` is
// rho.
template <class Scalar>
typename CsrOperator<Scalar>::Matrix kernel_sum(
    const BasicSources<Scalar>& sources, const std::type_identity_t<PointsView<Scalar>>& targets,
    const std::type_identity_t<FieldView<Scalar>>& amounts, const WeightFunction& weight,
    double radius) {
  return kernel_operator<Scalar>(sources, targets, {.weight = weight, .support = Radius{radius}})
      .apply(amounts);
}

// The integral of a weight over the unit ball or, as a tensor product, the cube of half side 1.
double weight_integral(const WeightFunction& weight, WeightForm form, int dimension);

extern template CsrOperator<float> kernel_operator(const SourcesF&, const PointsView<float>&,
                                                   const KernelOptions&);
extern template CsrOperator<double> kernel_operator(const Sources&, const PointsView<double>&,
                                                    const KernelOptions&);

}  // namespace recon
