// A grid velocity as written by hand for one degree, one weight and one machine, that the
// reconstruction on grids is measured against: degree 1, tensor products of cubic B-splines of
// natural width, three components, a cube of cells over the unit cube.
//
// Particles are sorted into cells. In a cell the sums of moments about its centre are a product of
// small matrices, (weights at 64 nodes)^T times (22 products of offsets and velocities), kept in
// registers three products at a time; then they are shifted to the nodes and added to the slab of a
// thread. Moment matrices are solved for eight nodes at once, as L D L^T. Nothing is checked, and no
// node may lack particles. Compiled like hand_written.hpp.
#pragma once

#include <array>
#include <vector>

namespace hand_written {

// Nodal velocities at the (cells + 1)^3 nodes, the first axis fastest.
std::vector<std::array<double, 3>> velocity_on_grid(const std::vector<std::array<double, 3>>& x,
                                                    const std::vector<std::array<double, 3>>& u,
                                                    int cells, int threads);

}  // namespace hand_written
