// reconstruct_on_grid(particles, fields, distributed grid, options): each rank gives its particles,
// and gets the values at its nodes.
//
// ```cpp
//   const recon::petsc::DistributedGrid grid(PETSC_COMM_WORLD, all_nodes);
//   const recon::GridReconstruction v = recon::petsc::reconstruct_on_grid(points, {velocity}, grid);
//   const Eigen::MatrixXd& at_nodes = v.values();  // a row per node of grid.owned()
// ```
//
// Values, gradients, reports and limits are those of reconstruct_on_grid() with the particles of all
// ranks, to rounding, for any solver, degree, weight and support, in 1-D to 3-D. Options::domain is not
// said here: the grid says which axes are periodic, and all images count, as in a periodic domain.
// Supports of single nodes (Radii) are those of owned(). There are two ways to it, as there:
//   By moments. Each rank sums the moments of its particles at the nodes of its piece (GridMoments),
//   the sums are added over the ghosts in one round of messages, and each rank solves its own nodes.
//   A particle may be with any rank to whose piece all nodes that it sees belong: those closer than
//   its support, within the grid. With `ghosts` the support in spacings, rounded up, these are at
//   least the particles of grid.rank_of() (particles.hpp brings them there). Where a particle sees a
//   node beyond, all ranks throw InvalidArgument, naming the rank and its particle. Nodes whose
//   moments are not safe are reduced as GridMoments says, not fitted from their particles.
//   By halos, for what GridMoments refuses: degree 3 and up, graded Gram-Schmidt (IMLS), exact
//   gradients, limits, supports that differ from node to node or are wider than 8 spacings, growing
//   supports. Each rank gets the particles that its own nodes see, wherever they are, and has their
//   operators (reconstruct.hpp, which says what is refused).
// Periodic coordinates need not be wrapped.
//
// All functions but solve_owned() and moments_of_piece() are collective. Cost besides that of the
// moments: one round of messages of GridMoments::per_node() numbers for each ghost, and four
// reductions of three numbers.
#pragma once

#include <vector>

#include "recon/grid/grid_moments.hpp"
#include "recon/petsc/distributed_grid.hpp"

namespace recon::petsc {

// Throws InvalidArgument as reconstruct_on_grid() of one process does, as petsc::Reconstruction where
// halos are needed, and for particles that see nodes beyond the piece of their rank where moments
// are enough; where several ranks do, that of the lowest rank is told. Messages about nodes say the
// number among those of owned().
GridReconstruction reconstruct_on_grid(const PointsView<double>& points,
                                       const std::vector<FieldView<double>>& fields,
                                       const DistributedGrid& grid, const Options& options = {},
                                       const GridApply& apply = {});

// The two halves of it, for codes that send more than moments in one round of messages:
//
// ```cpp
//   using namespace recon::petsc;
//   const recon::GridMoments m = moments_of_piece(points, {velocity}, distributed, options);
//   const std::vector<NodeValues> arrays{{m.values(), m.per_node()}, {masses, 1}};
//   const std::vector<std::vector<double>> sums = distributed.sum(arrays);  // one round of messages
//   const recon::GridReconstruction v = solve_owned(sums[0], 3, distributed, options);
// ```
//
// They throw InvalidArgument for what GridMoments refuses. Neither is collective: where they throw,
// other ranks do not know (Communicator::together).
GridMoments moments_of_piece(const PointsView<double>& points,
                             const std::vector<FieldView<double>>& fields,
                             const DistributedGrid& grid, const Options& options = {});
GridReconstruction solve_owned(std::span<const double> sums, int components,
                               const DistributedGrid& grid, const Options& options = {},
                               const GridApply& apply = {});

}  // namespace recon::petsc
