// The kernels of row_kernel.hpp. Included by one file per scalar, which is compiled per set.
//
// Of the particles of a cell first the moments about its centre are summed for each node, from the
// weights of cell_batch.hpp; then they are moved to the node (moment_sums.hpp). Nodes are solved
// one pack at a time.
#pragma once

#include "grid/cell_batch.hpp"
#include "grid/moment_sums.hpp"
#include "grid/row_pack.hpp"
#include "recon/local_solve/moment_matrix.hpp"

namespace recon::RECON_SET {
namespace {

template <class Scalar, int D, int R>
struct Kernel : NodeSizes<Scalar, D, R> {
  using T = Pack<Scalar>;
  using Batch = CellBatch<Scalar, D, R>;
  using Sums = MomentSums<Scalar, D, R>;
  using Sizes = NodeSizes<Scalar, D, R>;
  using Sizes::L, Sizes::M, Sizes::m;

  // Adds a batch of group g to all nodes of the stencil.
  static void add_batch(const Batch& batch, int g) {
    const CellRow<Scalar>& row = batch.row;
    const std::size_t node_size = static_cast<std::size_t>((1 + M + row.components * m) * L);
    for (int c = 0; c < row.stencil[2]; ++c)
      for (int b = 0; b < row.stencil[1]; ++b) {
        Scalar* to_row = row.rows[c * row.stencil[1] + b];
        if (!to_row) continue;
        batch.start_line(b, c);
        for (int a = 0; a < row.stencil[0]; ++a) {
          const std::array<int, 3> node{a, b, c};
          T offset[D];
          unroll<D>([&](auto d) RECON_INLINE_LAMBDA { offset[d] = T(row.offset[d][node[d]]); });
          batch.weights(a, offset);
          Scalar* to = to_row + static_cast<std::size_t>(g + a) * node_size;
          store(load(to) + batch.count(), to);
          Sums::add(row.components, batch.q, batch.stride, batch.w, batch.slots, offset, to + L);
        }
      }
  }

  static void add(const CellRow<Scalar>& row) {
    for (int g = 0; g < row.groups; ++g)
      for (std::uint32_t first = row.begin[g]; first < row.begin[g + 1]; first += slots_per_batch) {
        const std::uint32_t left = row.begin[g + 1] - first;
        const int slots = left < slots_per_batch ? static_cast<int>(left) : slots_per_batch;
        add_batch(Batch(row, first, slots), g);
      }
  }

  static void solve(const NodeRow<Scalar>& nodes) {
    using Matrix = MomentMatrix<T, Monomials<D, R>>;
    const int per_component = nodes.gradients ? 1 + D : 1;
    const int node_size = (1 + M + nodes.components * m) * L;
    const int out_size = (NodeRow<Scalar>::head + nodes.components * per_component) * L;
    Matrix matrix(nodes.tolerances);
    for (int j = 0; j < nodes.groups; ++j) {
      const Scalar* from = nodes.row + static_cast<std::size_t>(j) * node_size;
      Scalar* out = nodes.out + static_cast<std::size_t>(j) * out_size;
      typename Matrix::Moments moments;
      for (int k = 0; k < M; ++k) moments[k] = load(from + (1 + k) * L);
      auto safe = matrix.factor(moments, load(nodes.noise + j * L));
      if (any_lane(safe)) safe = safe && matrix.gradient_resolved();
      store(select(safe && load(from) >= T(Scalar(m)), T(1), T(0)), out);
      store(matrix.smallest_pivot(), out + L);
      store(matrix.amplification(), out + 2 * L);
      store(matrix.gradient_amplification(), out + 3 * L);
      out += NodeRow<Scalar>::head * L;
      if (!any_lane(safe)) continue;
      for (int c = 0; c < nodes.components; ++c, out += per_component * L) {
        typename Matrix::Vector b;
        for (int k = 0; k < m; ++k) b[k] = load(from + (1 + M + c * m + k) * L);
        T value = matrix.coefficients()[0] * b[0];
        for (int k = 1; k < m; ++k) value += matrix.coefficients()[k] * b[k];
        store(value, out);
        if (!nodes.gradients) continue;
        const typename Matrix::Vector fit = matrix.solve(b);
        for (int d = 0; d < D; ++d)
          store(R == 0 ? T(0) : fit[R == 0 ? 0 : 1 + d] * T(nodes.inverse_rho[d]),
                out + (1 + d) * L);
      }
    }
  }

  static RowKernel<Scalar> functions() { return {L, M, m, &add, &solve}; }
};

template <class Scalar, int D>
RowKernel<Scalar> of_degree(int degree) {
  return degree == 0   ? Kernel<Scalar, D, 0>::functions()
         : degree == 1 ? Kernel<Scalar, D, 1>::functions()
                       : Kernel<Scalar, D, 2>::functions();
}

}  // namespace

template <class Scalar>
RowKernel<Scalar> row_kernel(int dimension, int degree) {
  return dimension == 1   ? of_degree<Scalar, 1>(degree)
         : dimension == 2 ? of_degree<Scalar, 2>(degree)
                          : of_degree<Scalar, 3>(degree);
}

}  // namespace recon::RECON_SET
