// A batch of particles, those of one cell in each lane: their quantities about the centre of the
// cell, and their weights at one node of the stencil after another.
#pragma once

#include "grid/row_pack.hpp"
#include "recon/core/lanes.hpp"

namespace recon::RECON_SET {
namespace {

template <class Scalar, int D, int R>
class CellBatch {
 public:
  using T = Pack<Scalar>;

  // Takes the slots first .. first + count - 1 of the row, at most slots_per_batch.
  CellBatch(const CellRow<Scalar>& cells, std::uint32_t first, int count)
      : row(cells),
        slots(count),
        stride((M + row.components * m) * L),
        q(row.work),
        w(q + slots_per_batch * stride),
        numbers_(static_cast<std::size_t>((D + 1 + row.components) * L)),
        particles_(row.particles + first * numbers_),
        counted_(w + slots_per_batch * L),
        across_(counted_ + slots_per_batch * L),
        axis_(across_ + slots_per_batch * L) {
    const Scalar* p = particles_;
    for (int s = 0; s < slots; ++s, p += numbers_) {
      std::array<T, D> t;
      for (int d = 0; d < D; ++d) t[d] = load(p + d * L);
      const T weight = load(p + D * L);
      std::array<T, M> power;
      Sizes::Powers::evaluate(t, power.data(), weight);
      Scalar* to = q + s * stride;
      for (int k = 0; k < M; ++k) store(power[k], to + k * L);
      for (int c = 0; c < row.components; ++c) {
        const T u = load(p + (D + 1 + c) * L);
        for (int k = 0; k < m; ++k) store(u * power[k], to + (M + c * m + k) * L);
      }
      const T one = select(weight > T(0), T(1), T(0));
      store(one, counted_ + s * L);
      all_ += one;
    }
    if (row.form == WeightForm::tensor_product) axis_weights();
  }

  const CellRow<Scalar>& row;
  const int slots, stride;  // stride: numbers from slot to slot in q
  Scalar* const q;          // moments | right-hand sides
  Scalar* const w;          // weights at the node of the latest call of weights()

  // Prepares what the nodes (a, b, c) of the stencil, for all a, have in common.
  RECON_INLINE void start_line(int b, int c) const {
    if (row.form == WeightForm::tensor_product) across_weights(b, c);
  }
  // Evaluates the weights at node a of the line; `offset` is that of the node from the
  // centre of the cell.
  RECON_INLINE void weights(int a, const T* offset) const {
    if (row.form == WeightForm::tensor_product)
      tensor_weights(a);
    else
      radial_weights(offset);
  }
  // The number of particles that count as neighbours of the node with these weights.
  T count() const {
    if (clear_) return all_;
    T count(0);
    for (int s = 0; s < slots; ++s)
      count += select(load(w + s * L) > T(row.least_weight), load(counted_ + s * L), T(0));
    return count;
  }

 private:
  using Sizes = NodeSizes<Scalar, D, R>;
  static constexpr int L = Sizes::L, M = Sizes::M, m = Sizes::m;

  // Evaluates the factors of tensor-product weights along each axis.
  void axis_weights() {
    Scalar* to = axis_;
    for (int d = 0; d < D; ++d)
      for (int a = 0; a < row.stencil[d]; ++a) {
        const T node(row.offset[d][a]);
        for (int s = 0; s < slots; ++s, to += L) {
          const T t = load(particles_ + static_cast<std::size_t>(s) * numbers_ + d * L);
          store(larger(t - node, node - t), to);
        }
      }
    row.weight(row.weight_state, axis_, axis_, nullptr, static_cast<std::size_t>(to - axis_));
    T least(1);
    const Scalar* from = axis_;
    for (int d = 0; d < D; ++d) {
      T smallest = load(from);
      for (int i = 0; i < row.stencil[d] * slots; ++i, from += L)
        smallest = smaller(load(from), smallest);
      least = least * smallest;
    }
    clear_ = all_lanes(least > T(row.least_weight));
  }

  // across_weights(): for node (b, c) of the stencil, the product of the factors along all axes but
  // the first. tensor_weights(): the whole product.
  RECON_INLINE void across_weights(int b, int c) const {
    if constexpr (D >= 2) {
      const Scalar* second = axis_ + (row.stencil[0] + b) * slots * L;
      const Scalar* third = axis_ + (row.stencil[0] + row.stencil[1] + c) * slots * L;
      for (int s = 0; s < slots; ++s)
        store(D == 2 ? load(second + s * L) : load(second + s * L) * load(third + s * L),
              across_ + s * L);
    }
  }
  RECON_INLINE void tensor_weights(int a) const {
    const Scalar* first = axis_ + a * slots * L;
    for (int s = 0; s < slots; ++s)
      store(D == 1 ? load(first + s * L) : load(first + s * L) * load(across_ + s * L), w + s * L);
  }
  void radial_weights(const T* offset) const {
    const Scalar* p = particles_;
    for (int s = 0; s < slots; ++s, p += numbers_) {
      T square(0);
      for (int d = 0; d < D; ++d) {
        const T x = load(p + d * L) - offset[d];
        square += x * x;
      }
      store(sqrt(square), w + s * L);
    }
    row.weight(row.weight_state, w, w, nullptr, static_cast<std::size_t>(slots * L));
  }

  const std::size_t numbers_;  // numbers of a slot
  const Scalar* const particles_;
  Scalar *const counted_, *const across_, *const axis_;
  bool clear_ = false;  // every particle exceeds least_weight at every node of its cell
  T all_ = T(0);        // number of particles
};

}  // namespace
}  // namespace recon::RECON_SET
