// The moments of one stencil offset: summed about the centre of a cell, then moved to the node.
//
// The sums are a product of the matrices w (nodes x particles) and q (particles x quantities),
// which costs one multiply-add per quantity for a pair of particle and node. Then
//     sum w (t - d)^a  from  sum w t^b, b <= a,
// is found by the binomial formula, which costs little more than one multiply-add for each quantity
// of a node and cell. It involves only |t| <= 1 and |d| < 1, so that no digits are lost.
#pragma once

#include "grid/row_pack.hpp"

namespace recon::RECON_SET {
namespace {

// The steps that move moments of degree up to R to another centre: s[to] -= offset[axis] *
// s[from], in this order.
template <int D, int R>
struct MoveSteps {
  struct Step {
    int to, from, axis;
  };
  using Terms = Monomials<D, R>;
  template <class Visit>
  static constexpr void visit(Visit&& add) {
    for (int d = 0; d < D; ++d)
      for (int pass = 1; pass <= R; ++pass)
        for (int j = Terms::size - 1; j > 0; --j) {
          auto lower = Terms::exponents[j];
          if (lower[d] < pass) continue;
          --lower[d];
          add(Step{j, Terms::find(lower), d});
        }
  }
  static constexpr int count = [] {
    int steps = 0;
    visit([&](const Step&) { ++steps; });
    return steps;
  }();
  static constexpr auto all = [] {
    std::array<Step, count> steps{};
    int i = 0;
    visit([&](const Step& step) { steps[i++] = step; });
    return steps;
  }();
};

template <class Scalar, int D, int R>
struct MomentSums : NodeSizes<Scalar, D, R> {
  using T = Pack<Scalar>;
  using Sizes = NodeSizes<Scalar, D, R>;
  using Sizes::L, Sizes::M, Sizes::m;
  // The number of sums that are kept in registers at a time: there are 32 registers in
  // AVX-512, else 16.
  static constexpr int registers = sizeof(T) == 64 ? 24 : 12;
  // How many components are summed together with the moments, and how many without them.
  static constexpr int with_moments =
      M < registers ? (registers - M) / m < 4 ? (registers - M) / m : 4 : 0;
  static constexpr int alone = m > registers ? 1 : registers / m < 4 ? registers / m : 4;

  // Adds moments and all components to the node at `to`. The arguments are those of add_block().
  RECON_INLINE static void add(int components, const Scalar* q, int stride, const Scalar* w,
                               int slots, const T* offset, Scalar* to) {
    add_components<M, with_moments>(components, q, stride, w, slots, offset, to);
    for (int i = with_moments; i < components; i += alone) {
      const std::ptrdiff_t skip = (M + i * m) * L;
      add_components<0, alone>(components - i, q + skip, stride, w, slots, offset, to + skip);
    }
  }

 private:
  // Sets sum[k] = sum_s w[s] q[s][k] for k < Q.
  template <int Q>
  RECON_INLINE static void product(const Scalar* q, int stride, const Scalar* w, int slots,
                                   T* sum) {
    if constexpr (Q > registers) {
      constexpr int half = Q > 2 * registers ? registers : (Q + 1) / 2;
      product<half>(q, stride, w, slots, sum);
      product<Q - half>(q + half * L, stride, w, slots, sum + half);
    } else {
      T s[Q];
      const T first = load(w);
      unroll<Q>([&](auto k) RECON_INLINE_LAMBDA { s[k] = first * load(q + k * L); });
      for (int i = 1; i < slots; ++i) {
        q += stride;
        const T next = load(w + i * L);
        unroll<Q>([&](auto k) RECON_INLINE_LAMBDA { s[k] += next * load(q + k * L); });
      }
      unroll<Q>([&](auto k) RECON_INLINE_LAMBDA { sum[k] = s[k]; });
    }
  }

  // Moves moments up to `Degree` from the centre of the cell to a node at `offset` from it: pass i
  // along an axis turns t^(e - i + 1) (t - d)^(i - 1) into t^(e - i) (t - d)^i for e >= i.
  template <int Degree>
  RECON_INLINE static void move(T* s, const T* offset) {
    using Steps = MoveSteps<D, Degree>;
    unroll<Steps::count>([&](auto i) RECON_INLINE_LAMBDA {
      constexpr auto step = Steps::all[i];
      s[step.to] -= offset[step.axis] * s[step.from];
    });
  }

  // Adds for one stencil offset `Moments` moments (M or none) and C components to the node at `to`.
  template <int Moments, int C>
  RECON_INLINE static void add_block(const Scalar* q, int stride, const Scalar* w, int slots,
                                     const T* offset, Scalar* to) {
    constexpr int Q = Moments + C * m;
    if constexpr (Q > 0) {
      T sum[Q];
      product<Q>(q, stride, w, slots, sum);
      if constexpr (Moments > 0) move<2 * R>(sum, offset);
      unroll<C>([&](auto c) RECON_INLINE_LAMBDA { move<R>(sum + Moments + c * m, offset); });
      unroll<Q>([&](auto k) RECON_INLINE_LAMBDA { store(load(to + k * L) + sum[k], to + k * L); });
    }
  }
  template <int Moments, int C, class... Arguments>
  static void add_components(int components, const Arguments&... arguments) {
    if constexpr (C > 0)
      if (components < C) return add_components<Moments, C - 1>(components, arguments...);
    add_block<Moments, C>(arguments...);
  }
};

}  // namespace
}  // namespace recon::RECON_SET
