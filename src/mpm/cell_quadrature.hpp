// One-point quadrature over the cells of the grid, with density and stress fitted at their centres.
//
// Gong 2015, eq. 5.7-5.14. A cell counts with the part of it that holds material: 1 where the cell
// and all its neighbours hold particles (or lie beyond the grid), 0 where it holds none, else what
// its particles' volumes fill of it, at most 1. So the bodies' borders are where their particles
// are, and inside nothing depends on how particles are spread over cells.
#pragma once

#include "recon/mpm/simulation.hpp"

namespace recon::mpm {

// b: body force per mass of the particles, or empty.
template <int D>
void fit_cells(const Problem<D>& problem, const std::vector<Vector<D>>& b, Cells<D>& cells);

// Adds to the nodes' mass and force.
template <int D>
void integrate_cells(const Grid<D>& grid, const Cells<D>& cells, Nodes<D>& nodes);

}  // namespace recon::mpm
