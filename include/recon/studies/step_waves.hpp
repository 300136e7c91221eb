// The waves of one step of a method, by eigenvalues.
//
// A body without stress that fills all space, at rest or in uniform motion: a step is linear in what
// little the variables z = (v, stress, L, modes) of the particles depart from that. Particles lie alike
// in all cells, so that disturbances z_c = exp(i theta . c) z of the cells c go over into disturbances of
// the same kind,
//     z'  = G(theta) z ,   G(theta) = sum_c exp(i theta . c) J_c ,
// where J_c is what a step makes in the cell 0 of what was in the cell c. The blocks J_c are steps of the
// driver itself on a patch that is wide enough, so that the symbol G is that of the method as it runs,
// whatever its choices are: no formula of it is written twice. An eigenvalue
//     lambda = exp(-i omega dt - gamma dt)
// of G belongs to a wave of the frequency omega that is damped by gamma; the step is stable where no
// eigenvalue lies outside of the unit circle.
//
// A body that moves sees the grid from other places in each step. With N steps to a cell the product
// of the N symbols is what a cell crossed makes of a wave; where its spectral radius exceeds 1, small
// disturbances grow in any body that flies over the grid, however short the steps are.
//
// Material: c_p = 1, lambda = 0, mu = 1 / 2, density 1; cells of size 1, so that dt = c_p dt / h.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "recon/mpm/method.hpp"
#include "recon/mpm/types.hpp"

namespace recon::mpm {

// The symbol G of a step.
template <int D>
class StepSymbol {
 public:
  // `offset` is how far the particles, which start at the fractions (j - 1/2) / per_cell of the
  // cells, have moved along x, in cells; `speed` that along x over c_p. Throws InvalidArgument for a
  // method that cannot run in D dimensions or carries a disturbance farther than 40 cells in a
  // step, and unless per_cell and courant are positive.
  StepSymbol(const Method& method, int per_cell, double courant, double offset = 0,
             double speed = 0);

  // How many cells along each axis are alike only together: 2 for elements of 2 x 2 cells, else 1.
  int period() const { return period_; }
  // Variables of the particles of one period.
  Eigen::Index size() const { return size_; }
  // G for the phase theta from one cell to the next, along each axis.
  Eigen::MatrixXcd at(const Vector<D>& theta) const;
  // Velocities along x like exp(i theta . x), all else zero.
  Eigen::VectorXcd wave(const Vector<D>& theta) const;

 private:
  struct Block {
    Vector<D> cells;  // from the disturbance to the response
    Eigen::MatrixXd response;
  };
  int period_ = 1;
  Eigen::Index size_ = 0;
  std::vector<Block> blocks_;
  std::vector<Vector<D>> places_;  // of the particles of one period, in cells
  Eigen::Index per_particle_ = 0;
};

// A longitudinal wave in a bar, as the step carries it: of all eigenvectors of G the one that has the
// largest part in velocities that were like exp(i k x) half a period ago, and is no rest that stays.
struct StepWave {
  double frequency = 0;  // omega / (k c_p): 1 without dispersion
  double damping = 0;    // the part of the amplitude that a period takes away
};
StepWave step_wave(const Method& method, int per_cell, double courant, double kh);

// The largest factor by which one step multiplies a small disturbance of a body at rest; and, for
// steps_per_cell > 0, by which one cell crossed does, at the speed h / (steps_per_cell dt). `free`: a
// body of `body_cells` cells along each axis with nothing around it; else one without end, where the
// phases are all multiples of pi / 8 in 1-D and of pi / 4 in 2-D. dimension is 1 or 2.
double spectral_radius(const Method& method, int dimension, int per_cell, double courant,
                       int steps_per_cell = 0, bool free = false, int body_cells = 4);

// The largest c_p dt / h, up to 4 and to 0.005, at which a step multiplies no small disturbance of a
// body at rest by more than 1.001.
double largest_step_by_eigenvalues(const Method& method, int dimension, int per_cell,
                                   bool free = false);

extern template class StepSymbol<1>;
extern template class StepSymbol<2>;

}  // namespace recon::mpm
