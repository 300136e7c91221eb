// Quadrature at Gauss points of reconstructed density, momentum and stress in the cells that are
// full; in all other cells the particles are the quadrature points.
//
//   taylor_cells  in each cell u = a_1 + sum_k a_k psi_k with psi of mean zero, of xi = (x - x_c) /
//                 (h / 2): xi_d, xi_d^2 / 2 - 1/6 and xi_d xi_e. For density and momentum a_1 is
//                 the sum of the particles' masses and momenta over the volume of the cell, so that
//                 the integral is theirs whatever the rest; a_k by least squares of u_p - a_1. For
//                 the stress all by least squares (Wobbes, Moller, Galavi, Vuik 2018). Without the
//                 quadratic psi where a cell holds too few particles for them
//   gauss_cells   moving least squares at each Gauss point, cubic B-spline of support 2 h
//                 (Tran, Wobbes, Solowski, Moller, Vuik 2019)
#pragma once

#include "mpm/cell_quadrature.hpp"
#include "mpm/mass_matrix.hpp"

namespace recon::mpm {

// full: 1 for the cells that are reconstructed. Adds to mass, momentum and force of the nodes, and
// to the entries of a consistent mass matrix, if there is one.
template <int D>
void integrate_gauss(const Problem<D>& problem, const std::vector<Vector<D>>& b,
                     const std::vector<double>& full, Nodes<D>& nodes, MassEntries* entries);

template <int D>
bool in_full_cell(const Problem<D>& problem, const std::vector<double>& full, std::size_t p) {
  return full[problem.grid.cell_number(problem.particles.x[p])] > 0;
}

extern template void integrate_gauss(const Problem<1>&, const std::vector<Vector<1>>&,
                                     const std::vector<double>&, Nodes<1>&, MassEntries*);
extern template void integrate_gauss(const Problem<2>&, const std::vector<Vector<2>>&,
                                     const std::vector<double>&, Nodes<2>&, MassEntries*);
extern template void integrate_gauss(const Problem<3>&, const std::vector<Vector<3>>&,
                                     const std::vector<double>&, Nodes<3>&, MassEntries*);

}  // namespace recon::mpm
