// The sweep over a grid: particles in, moments of one row of nodes after the other out.
//
// Tiles of nodes are worked through independently. In a tile the rows of cells are taken plane by
// plane along the last axis; only the planes of nodes that still receive contributions are held,
// n_2 of them. A node gets its contributions in the order of the cells, whichever tile it is in,
// and how cells are dealt out to lanes along the first axis depends on the grid alone: so the
// number of tiles along the other axes may follow the number of threads, with the same bits. Cells
// at the border of a tile are summed again by the next one.
#pragma once

#include <functional>
#include <memory>

#include "grid/particle_bins.hpp"
#include "recon/core/progress.hpp"

namespace recon {

// The distribution of the nodes of a row over lanes: node i of the grid with first <= i < first +
// width is in lane (i - first + n_0 - 1) / groups, at entry (i - first + n_0 - 1) % groups.
struct LaneLayout {
  int lanes, groups, stencil;
  std::int64_t width;  // number of nodes of a tile

  template <class Scalar>
  static LaneLayout of(const GridPlan<Scalar>& plan);

  std::size_t entry(std::int64_t i) const {
    return static_cast<std::size_t>((i + stencil - 1) % groups);
  }
  std::size_t lane(std::int64_t i) const {
    return static_cast<std::size_t>((i + stencil - 1) / groups);
  }
};

// The nodes first .. first + width - 1 of row (j, k), with their moments laid out as in
// row_kernel.hpp.
template <class Scalar>
struct FinishedRow {
  std::int64_t first, width, j, k;
  const Scalar* moments;
};

// Calls done(row) for every row of nodes of every tile, concurrently. make_done is called once for
// each tile: what it returns may hold work space.
template <class Scalar>
using RowSink = std::function<void(const FinishedRow<Scalar>&)>;
template <class Scalar>
void sweep(const ParticleData<Scalar>& particles, const ParticleBins& bins,
           const GridPlan<Scalar>& plan, const Progress& progress,
           const std::function<RowSink<Scalar>()>& make_done);

}  // namespace recon
