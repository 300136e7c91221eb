// Particles that are spread over the ranks of a grid: each is with the rank in whose box it lies.
//
// ```cpp
//   recon::petsc::Particles particles(distributed, {{"mass", 1}, {"velocity", 3}});
//   particles.add(points, {mass, velocity});  // of this rank, wherever they lie
//   move_all(particles.x(), particles.array("velocity"));
//   particles.migrate();                      // to their ranks, with all of their arrays
// ```
//
// What a particle carries are arrays with names, numbers of double precision; positions and ids are
// always there. migrate() brings each particle to grid.rank_of() its position, however many ranks
// away, in one exchange, and only where a reduction over all ranks says that a particle has left
// its rank. Periodic coordinates are wrapped into [lower, upper). After each exchange the number of
// particles and a sum over their ids are compared with those before: a particle that was lost or
// is there twice is an Error on all ranks.
//
// The box is that of the nodes of the grid. A particle beyond it, along an axis that is not
// periodic, is refused or kept, as `outside` says: one that is kept belongs to the rank of the
// nearest cell, and is counted in what migrate() returns. None is ever removed.
//
// Ids are 0, 1, 2, ... over all ranks, in the order of the calls of add() and in each of the ranks.
// The order of the particles of a rank, and with it what spans refer to, is another one after
// add() and migrate(): ask for spans and views again.
//
// It is a DMSWARM_BASIC of PETSc, whose DMSWARM_PIC duplicates a particle on the plane between two
// other ranks and loses one that jumps past its neighbours.
#pragma once

#include <petscdm.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "recon/petsc/distributed_grid.hpp"
#include "recon/points/view.hpp"

namespace recon::petsc {

struct ParticleArray {
  std::string name;
  int components = 1;
};

enum class Outside {
  stop,  // InvalidArgument, naming the id of the particle and the axis
  keep   // with the rank of the nearest cell
};

// What a migration has done.
struct Migration {
  std::int64_t moved = 0;               // particles that have changed their rank, of all ranks
  std::int64_t outside = 0;             // particles beyond the box, of all ranks
  std::int64_t sent = 0, received = 0;  // of this rank
};

class Particles {
 public:
  // Collective. Throws InvalidArgument for names that are empty, "x", "id", said twice or those of
  // PETSc's own arrays ("DMSwarm..."), components below 1, and arrays that differ between ranks.
  Particles(const DistributedGrid& grid, const std::vector<ParticleArray>& arrays,
            Outside outside = Outside::stop);

  // Adds particles, on any rank, with the values of the arrays in their order, and migrates.
  // Collective. Throws InvalidArgument on all ranks, and adds nothing, for sizes and components
  // that do not fit, coordinates that are not finite, and particles outside where these are
  // refused (naming the point). Where a particle that was there before is refused by the migration,
  // the new ones are there, not yet with their ranks.
  Migration add(const PointsView<double>& points, const std::vector<FieldView<double>>& values);

  // Collective. Throws InvalidArgument, and leaves all particles where they are, for coordinates
  // that are not finite and particles outside where these are refused (naming the id).
  Migration migrate();

  const DistributedGrid& grid() const;
  std::size_t size() const;    // of this rank
  std::int64_t total() const;  // of all ranks

  // Coordinates x0 y0 z0 x1 y1 z1 ..., dimension() numbers for each particle.
  std::span<double> x();
  PointsView<double> points() const;
  std::span<const std::int64_t> ids() const;
  // The numbers of an array, components after components. Throws InvalidArgument for a name that
  // no array has, saying which there are.
  std::span<double> array(const std::string& name);
  FieldView<double> field(const std::string& name) const;

  DM dm() const;

 private:
  struct Data;
  std::shared_ptr<Data> data_;
};

}  // namespace recon::petsc
