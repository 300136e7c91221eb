// A regular grid that is spread over the ranks, each with a box of the nodes and layers of ghosts.
//
// ```cpp
//   const recon::petsc::DistributedGrid grid(PETSC_COMM_WORLD, all_nodes, {.ghosts = 2});
//   std::vector<double> mass(grid.piece().size());   // of this rank's particles
//   std::vector<double> sums = grid.sum(mass, 1);    // at the nodes of grid.owned(), of all ranks
//   std::vector<double> seen = grid.fill(sums, 1);   // the same at the nodes of grid.piece()
// ```
//
// owned() are the nodes that belong to this rank: each node belongs to one. piece() are these and
// the ghosts: up to `ghosts` layers around them, which belong to other ranks, no farther than the
// grid goes. On a periodic axis the grid has N nodes and the period N * spacing, node N being node
// 0, and the ghosts go on beyond the border: their coordinates are those of the images.
//
// sum() adds what the pieces of all ranks have at the same node; fill() is the way back, and its
// transpose: sum over owned nodes of sum(a) b = sum over all pieces of a fill(b). Each is one round
// of messages between neighbours, whatever the number of arrays, of at most 3^D - 1 messages from
// each rank; traffic() counts them. Sums are formed in an order that depends on the number of
// ranks: results for different numbers of ranks agree to rounding.
//
// It is a DMDA of PETSc with a box stencil. All functions that say so are collective
// (communicator.hpp). A copy is the same grid.
#pragma once

#include <petscdm.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "recon/petsc/communicator.hpp"
#include "recon/points/domain.hpp"
#include "recon/points/structured_grid.hpp"

namespace recon::petsc {

struct DistributedGridOptions {
  std::array<bool, max_dimension> periodic{};
  // Layers of ghosts: at least the support in spacings, rounded up. 2 is that of a cubic B-spline.
  int ghosts = 2;
  // The number of ranks along each axis, whose product is that of all ranks; 0 along all axes of
  // the grid: chosen so that pieces have the smallest surface.
  std::array<int, max_dimension> ranks{};
};

// What one rank sends in one round of messages.
struct Traffic {
  std::int64_t messages = 0, bytes = 0;
};

// Numbers at the nodes of a piece, `per_node` for each node, one node after another.
struct NodeValues {
  std::span<const double> values;
  int per_node = 1;
};

class DistributedGrid {
 public:
  // Collective. Throws InvalidArgument for bad grids, ghosts or ranks, arguments that are not the
  // same on all ranks, and where a rank would have fewer nodes along an axis than there are ghosts
  // (naming the axis): use fewer ranks or more nodes then.
  DistributedGrid(MPI_Comm comm, const StructuredGrid<double>& grid,
                  const DistributedGridOptions& options = {});

  // The centres of the cells, each with the rank of the node at its lower corner: one fewer than
  // nodes along an axis, as many on a periodic one. Collective. Throws InvalidArgument where the
  // last rank along an axis has fewer cells than there are ghosts.
  DistributedGrid cells() const;

  const Communicator& communicator() const;
  const StructuredGrid<double>& all() const;
  const StructuredGrid<double>& owned() const;
  const StructuredGrid<double>& piece() const;
  // The index in all() of the first node of owned() and of piece(); negative for images.
  const std::array<std::int64_t, max_dimension>& owned_begin() const;
  const std::array<std::int64_t, max_dimension>& piece_begin() const;
  int ghosts() const;
  const std::array<bool, max_dimension>& periodic() const;
  // The periods, for options of reconstructions and for wrapping.
  PeriodicDomain<double> domain() const;
  // The number of ranks along each axis. Rank r stands at place r % ranks()[0] along the first one,
  // and so on: the first axis runs fastest.
  const std::array<int, max_dimension>& ranks() const;

  // The position along an axis in spacings: node i is at i.
  double place(double coordinate, int axis) const;
  // The rank of the node at the lower corner of the cell that x lies in: of the nearest such cell
  // for points outside of the grid, of the image in it on periodic axes. Coordinates are finite.
  int rank_of(const std::array<double, max_dimension>& x) const;

  // From the nodes of piece() to those of owned(), and back. Collective. Throw InvalidArgument for
  // sizes and numbers per node that do not fit, and for more numbers than PETSc can count.
  std::vector<double> sum(std::span<const double> piece, int per_node) const;
  // Several arrays in one round of messages; an array of owned nodes for each.
  std::vector<std::vector<double>> sum(std::span<const NodeValues> arrays) const;
  std::vector<double> fill(std::span<const double> owned, int per_node) const;

  // What this rank sends in a sum() of so many numbers at each node.
  Traffic traffic(int per_node) const;

  // The DMDA with so many numbers at each node; it belongs to the grid. Collective where a number
  // is asked for the first time.
  DM dm(int per_node) const;

  struct Data;

 private:
  explicit DistributedGrid(std::shared_ptr<Data> data) : data_(std::move(data)) {}
  std::shared_ptr<Data> data_;
};

}  // namespace recon::petsc
