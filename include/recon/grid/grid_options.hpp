// The choices of a reconstruction on a grid.
//
// A particle counts at a node through q_d = |x_p - x_i|_d / rho_d, with rho_d the support along
// axis d, a length. tensor_product: w = prod_d w(q_d), the support is a box. radial: w = w(|q|),
// the support is an ellipsoid. The natural support of a B-spline of degree P is (P + 1) / 2
// spacings of the grid: the weights are then the cardinal splines of the material point method
// (Steffen, Kirby, Berzins 2008), which sum to one over the grid. A larger support smooths more,
// and its cost grows in proportion to its volume.
#pragma once

#include <array>
#include <limits>

#include "recon/core/instruction_set.hpp"
#include "recon/local_solve/local_cloud.hpp"
#include "recon/operators/limit.hpp"
#include "recon/points/view.hpp"
#include "recon/weights/weight.hpp"

namespace recon {

struct GridOptions {
  // Polynomials of degree up to this are reproduced: 0 (Shepard), 1 or 2.
  int degree = 1;
  // An enumerator or any object that is a RadialWeight.
  WeightFunction weight = Weight::cubic_b_spline;
  WeightForm form = WeightForm::tensor_product;
  // rho_d, lengths. 0: (P + 1) / 2 spacings along this axis, for B-splines of degree P; other
  // weights have no natural support. At most 8 spacings.
  std::array<double, max_dimension> support{};

  // Whether to compute also the gradient of the local polynomial (the diffuse one). It is zero at
  // degree 0 and in directions that the particles do not resolve (FitReport::gradient_rank).
  bool gradients = false;
  // Keeps each value in or near the range of the data in its support, those of particles with m_p
  // > 0 (operators/limit.hpp). Gradients are never limited. GridMoments refuse a limit, because
  // they keep no data.
  Limit limit = Limit::none;
  // The value of nodes without a particle in their support.
  double fill_value = std::numeric_limits<double>::quiet_NaN();

  FitTolerances tolerances{};
  InstructionSet instruction_set = InstructionSet::automatic;
  int threads = 0;  // 0: default_threads(); the results do not depend on it

  // Throws InvalidArgument for a value outside its range; supports are checked against a grid.
  void validate() const;
};

}  // namespace recon
