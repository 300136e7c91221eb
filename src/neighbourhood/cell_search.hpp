// The neighbours of all targets at once, by cells: find_neighbours for evenly spread particles.
//
// Particles are sorted by cell and targets by bricks of a few cells. The particles around the
// targets of a brick are collected once for all of them, as floats about the middle of the brick;
// for each target vector instructions then pick those inside the ball or cube (cell_kernel.hpp).
// What floats cannot tell the coordinates decide (brick.hpp). For the k nearest the ball is a guess
// from the k-th distance of the targets before, a little larger; where it holds fewer than k it
// grows. A guess can only cost time: the result is that of find_neighbours.hpp to the bit, but for
// the order in rows where that of the particles' numbers will do.
//
// Covered: Radius, Radii and Nearest with both shapes, NearestWithin with the ball, in periodic
// domains too. Not covered, and left to find_neighbours_with.hpp: visibility, NearestWithin with
// the cube. Its functions also serve single targets here: those that coincide with all their
// neighbours, and those whose k nearest reach farther than a period.
//
// Where particles are too many to a cell, or targets lie in great voids, a target costs more than
// it would with a k-d tree. If `may_build_tree`, such work is added up; once it has cost as much as
// building a tree, one is built, and serves the targets that are too much work from then on. A
// cloud that is too uneven from the start is refused.
//
// Cost: O(particles + cells + targets) for sorting, then per target what lies around it.
#pragma once

#include "neighbourhood/search_index.hpp"
#include "recon/neighbourhood/find_neighbours.hpp"

namespace recon::detail {

// Is this a question that find_by_cells answers? (There must be a particle, too.)
bool covered_by_cells(const NeighbourRule& rule, const NeighbourOptions& options);

// Into `list`, whose memory is used again. False, and the list unchanged, where the cloud is
// refused.
template <int D, class Scalar>
bool find_by_cells(SearchIndex<Scalar, D>& particles, const PointCloud<Scalar>& targets,
                   const NeighbourRule& rule, const PeriodicDomain<Scalar>& domain,
                   const NeighbourOptions& options, bool may_build_tree, const RowsAsked& rows,
                   NeighbourList<Scalar>& list);

}  // namespace recon::detail
