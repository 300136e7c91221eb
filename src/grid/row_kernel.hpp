// The two inner loops of a reconstruction on a grid: adding the particles of a row of cells to the
// nodal moments, and solving a row of nodes. Compiled once per instruction set.
//
// A cell is the set of points that see the same nodes: n_d nodes along axis d. Cells and nodes are
// dealt out to the lanes of a pack by segments of G = `groups` along the first axis: lane l has the
// cells l G + g, g < G. All lanes then look at the same stencil offset at once, with the same
// distance from the cell's centre to the node, and the moments of a row of nodes are
//     row[(j K + k) L + l],  j < G + n_0 - 1,  k < K,  l < L lanes;
// cell (l, g) adds to the nodes j = g .. g + n_0 - 1 of its lane. Entry (j >= G, l) is the same
// node as (j - G, l + 1): they are added up when the row is complete (merge_lanes in sweep.cpp).
// The K quantities of a node are: number of particles | moments, as Monomials<D, 2 R> |
// right-hand sides, as Monomials<D, R>, component by component.
#pragma once

#include <array>
#include <cstdint>

#include "core/dispatch.hpp"
#include "recon/local_solve/local_cloud.hpp"
#include "recon/points/view.hpp"
#include "recon/weights/weight.hpp"

namespace recon {

template <class Scalar>
struct CellRow {
  int groups, components;
  std::array<int, max_dimension> stencil;  // n_d; 1 beyond the dimension
  // (x_i - centre of the cell) / rho along axis d, for the n_d nodes.
  std::array<const Scalar*, max_dimension> offset;
  WeightForm form;
  WeightFunction::Function<Scalar> weight;
  const void* weight_state;
  Scalar least_weight;  // a particle counts as a neighbour where its weight exceeds this

  // Particle slots of group g: begin[g] .. begin[g + 1]. A slot has D + 1 + components numbers for
  // each lane: (x_p - centre) / rho, particle weight, data; zeros where a lane has no particle.
  const std::uint32_t* begin;
  const Scalar* particles;
  // Rows of nodes that these cells touch, [n_2][n_1]; null for those that are not wanted.
  Scalar* const* rows;
  Scalar* work;  // work_size() numbers
};

template <class Scalar>
struct NodeRow {
  int groups, components;
  bool gradients;
  FitTolerances tolerances;
  std::array<Scalar, max_dimension> inverse_rho;
  const Scalar* row;    // merged moments
  const Scalar* noise;  // rounding of the coordinates, [groups][L]
  // [groups][numbers][L]: is the moment matrix safe (1 or 0), smallest pivot, amplification of
  // values and of gradients, then for each component the value and, if asked for, the gradient.
  Scalar* out;
  static constexpr int head = 4;
};

constexpr int slots_per_batch = 16;

template <class Scalar>
struct RowKernel {
  int lanes;
  int moments, terms;  // C(2 R + D, D) and C(R + D, D)
  void (*add)(const CellRow<Scalar>&);
  void (*solve)(const NodeRow<Scalar>&);

  int quantities(int components) const { return 1 + moments + components * terms; }
  std::size_t work_size(int components, const std::array<int, max_dimension>& stencil) const {
    return static_cast<std::size_t>(slots_per_batch * lanes) *
           static_cast<std::size_t>(quantities(components) + stencil[0] + stencil[1] + stencil[2] +
                                    3);
  }
};

RECON_FOR_EACH_SET(template <class Scalar> RowKernel<Scalar> row_kernel(int dimension, int degree))

}  // namespace recon
