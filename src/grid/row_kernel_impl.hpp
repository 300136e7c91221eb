// The kernels of row_kernel.hpp. Included by one file per scalar, which is compiled per set.
//
// Of the particles of a cell first the moments about its centre are summed for each node: a product
// of the matrices w (nodes x particles) and q (particles x quantities), in which all that is done
// for a pair of particle and node is one multiply-add per quantity. Then they are moved to the
// node,
//     sum w (t - d)^a  from  sum w t^b, b <= a,
// by the binomial formula, which costs little more than one multiply-add for each quantity of a
// node and cell; no more than |t| <= 1, |d| < 1 is involved, so that no digits are lost.
#pragma once

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"  // g++ 12 means its own _mm512_sqrt_pd
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

#include "grid/row_kernel.hpp"
#include "recon/core/pack.hpp"
#include "recon/local_solve/moment_matrix.hpp"

namespace recon::RECON_SET {
namespace {

// Sums stay in registers only if all of this is one function.
#define RECON_INLINE [[gnu::always_inline]] inline
#define RECON_INLINE_LAMBDA __attribute__((always_inline))

template <class Body, int... i>
RECON_INLINE void unrolled(Body&& body, std::integer_sequence<int, i...>) {
  (body(std::integral_constant<int, i>{}), ...);
}
template <int N, class Body>
RECON_INLINE void unrolled(Body&& body) {
  unrolled(body, std::make_integer_sequence<int, N>{});
}

// What moves monomials of degree up to R to another centre: s[to] -= offset[axis] * s[from] in this
// order.
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
struct Kernel {
  using T = Pack<Scalar>;
  using Powers = Monomials<D, 2 * R>;
  static constexpr int L = static_cast<int>(T::size());
  static constexpr int M = Powers::size;
  static constexpr int m = monomial_count(D, R);
  // Sums that are kept in registers at a time: of 32 registers in AVX-512, else 16.
  static constexpr int registers = sizeof(T) == 64 ? 24 : 12;
  // Components whose sums go together with the moments, and without them.
  static constexpr int with_moments =
      M < registers ? (registers - M) / m < 4 ? (registers - M) / m : 4 : 0;
  static constexpr int alone = m > registers ? 1 : registers / m < 4 ? registers / m : 4;

  RECON_INLINE static T load(const Scalar* from) {
    return T(from, std::experimental::vector_aligned);
  }
  RECON_INLINE static void store(const T& value, Scalar* to) {
    value.copy_to(to, std::experimental::vector_aligned);
  }

  // sum[k] = sum_s w[s] q[s][k], k < Q.
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
      unrolled<Q>([&](auto k) RECON_INLINE_LAMBDA { s[k] = first * load(q + k * L); });
      for (int i = 1; i < slots; ++i) {
        q += stride;
        const T next = load(w + i * L);
        unrolled<Q>([&](auto k) RECON_INLINE_LAMBDA { s[k] += next * load(q + k * L); });
      }
      unrolled<Q>([&](auto k) RECON_INLINE_LAMBDA { sum[k] = s[k]; });
    }
  }

  // From moments up to `Degree` about the cell's centre to those about a node at `offset` from it:
  // pass i along an axis turns t^(e - i + 1) (t - d)^(i - 1) into t^(e - i) (t - d)^i for e >= i.
  template <int Degree>
  RECON_INLINE static void move(T* s, const T* offset) {
    using Steps = MoveSteps<D, Degree>;
    unrolled<Steps::count>([&](auto i) RECON_INLINE_LAMBDA {
      constexpr auto step = Steps::all[i];
      s[step.to] -= offset[step.axis] * s[step.from];
    });
  }

  // One stencil offset: `Moments` moments (M or none) and C components, to the node at `to`.
  template <int Moments, int C>
  RECON_INLINE static void add_block(const Scalar* q, int stride, const Scalar* w, int slots,
                                     const T* offset, Scalar* to) {
    constexpr int Q = Moments + C * m;
    if constexpr (Q > 0) {
      T sum[Q];
      product<Q>(q, stride, w, slots, sum);
      if constexpr (Moments > 0) move<2 * R>(sum, offset);
      unrolled<C>([&](auto c) RECON_INLINE_LAMBDA { move<R>(sum + Moments + c * m, offset); });
      unrolled<Q>([&](auto k)
                      RECON_INLINE_LAMBDA { store(load(to + k * L) + sum[k], to + k * L); });
    }
  }
  template <int Moments, int C, class... Arguments>
  static void add_components(int components, const Arguments&... arguments) {
    if constexpr (C > 0)
      if (components < C) return add_components<Moments, C - 1>(components, arguments...);
    add_block<Moments, C>(arguments...);
  }

  struct Batch {
    const CellRow<Scalar>& row;
    int slots, stride;  // stride: numbers from slot to slot in q
    Scalar *q, *counted, *axis, *across, *w;
    bool clear;  // every particle exceeds least_weight at every node of its cell
    T count;     // particles
  };

  // Quantities about the centre of the cell, and the tensor weights along each axis.
  static Batch prepare(const CellRow<Scalar>& row, std::uint32_t first, int slots) {
    const int numbers = D + 1 + row.components;
    Batch b{
        row,   slots, (M + row.components * m) * L, row.work, nullptr, nullptr, nullptr, nullptr,
        false, T(0)};
    b.counted = b.q + slots_per_batch * b.stride;
    b.w = b.counted + slots_per_batch * L;
    b.across = b.w + slots_per_batch * L;
    b.axis = b.across + slots_per_batch * L;
    for (int s = 0; s < slots; ++s) {
      const Scalar* p = row.particles + (first + static_cast<std::uint32_t>(s)) *
                                            static_cast<std::size_t>(numbers * L);
      std::array<T, D> t;
      for (int d = 0; d < D; ++d) t[d] = load(p + d * L);
      const T weight = load(p + D * L);
      std::array<T, M> power;
      Powers::evaluate(t, power.data(), weight);
      Scalar* q = b.q + s * b.stride;
      for (int k = 0; k < M; ++k) store(power[k], q + k * L);
      for (int c = 0; c < row.components; ++c) {
        const T u = load(p + (D + 1 + c) * L);
        for (int k = 0; k < m; ++k) store(u * power[k], q + (M + c * m + k) * L);
      }
      const T one = select(weight > T(0), T(1), T(0));
      store(one, b.counted + s * L);
      b.count += one;
    }
    if (row.form == WeightForm::tensor_product) axis_weights(b, first);
    return b;
  }

  static void axis_weights(Batch& b, std::uint32_t first) {
    const int numbers = D + 1 + b.row.components;
    Scalar* q = b.axis;
    for (int d = 0; d < D; ++d)
      for (int a = 0; a < b.row.stencil[d]; ++a) {
        const T node(b.row.offset[d][a]);
        for (int s = 0; s < b.slots; ++s, q += L) {
          const T t = load(b.row.particles + ((first + static_cast<std::uint32_t>(s)) *
                                                  static_cast<std::size_t>(numbers) +
                                              static_cast<std::size_t>(d)) *
                                                 L);
          store(larger(t - node, node - t), q);
        }
      }
    b.row.weight(b.row.weight_state, b.axis, b.axis, nullptr, static_cast<std::size_t>(q - b.axis));
    T least(1);
    const Scalar* w = b.axis;
    for (int d = 0; d < D; ++d) {
      T smallest = load(w);
      for (int i = 0; i < b.row.stencil[d] * b.slots; ++i, w += L)
        smallest = smaller(load(w), smallest);
      least = least * smallest;
    }
    b.clear = all_lanes(least > T(b.row.least_weight));
  }

  // The product of all but the first axis' weights, for node (b, c) of the stencil; then all of
  // them.
  RECON_INLINE static void across_weights(const Batch& batch, int b, int c) {
    if constexpr (D >= 2) {
      const int n = batch.slots;
      const Scalar* second = batch.axis + (batch.row.stencil[0] + b) * n * L;
      const Scalar* third = batch.axis + (batch.row.stencil[0] + batch.row.stencil[1] + c) * n * L;
      for (int s = 0; s < n; ++s)
        store(D == 2 ? load(second + s * L) : load(second + s * L) * load(third + s * L),
              batch.across + s * L);
    }
  }
  RECON_INLINE static void tensor_weights(const Batch& batch, int a) {
    const Scalar* first = batch.axis + a * batch.slots * L;
    for (int s = 0; s < batch.slots; ++s)
      store(D == 1 ? load(first + s * L) : load(first + s * L) * load(batch.across + s * L),
            batch.w + s * L);
  }
  static void radial_weights(const Batch& batch, std::uint32_t first, const T* offset) {
    const int numbers = D + 1 + batch.row.components;
    for (int s = 0; s < batch.slots; ++s) {
      const Scalar* p = batch.row.particles + (first + static_cast<std::uint32_t>(s)) *
                                                  static_cast<std::size_t>(numbers * L);
      T square(0);
      for (int d = 0; d < D; ++d) {
        const T x = load(p + d * L) - offset[d];
        square += x * x;
      }
      store(sqrt(square), batch.w + s * L);
    }
    batch.row.weight(batch.row.weight_state, batch.w, batch.w, nullptr,
                     static_cast<std::size_t>(batch.slots * L));
  }

  static T count(const Batch& batch) {
    if (batch.clear) return batch.count;
    T count(0);
    for (int s = 0; s < batch.slots; ++s)
      count += select(load(batch.w + s * L) > T(batch.row.least_weight),
                      load(batch.counted + s * L), T(0));
    return count;
  }

  // All nodes of the stencil of group g.
  static void add_batch(const Batch& batch, std::uint32_t first, int g) {
    const CellRow<Scalar>& row = batch.row;
    const std::size_t node_size = static_cast<std::size_t>((1 + M + row.components * m) * L);
    for (int c = 0; c < row.stencil[2]; ++c)
      for (int b = 0; b < row.stencil[1]; ++b) {
        Scalar* to_row = row.rows[c * row.stencil[1] + b];
        if (!to_row) continue;
        if (row.form == WeightForm::tensor_product) across_weights(batch, b, c);
        for (int a = 0; a < row.stencil[0]; ++a) {
          const std::array<int, 3> node{a, b, c};
          T offset[D];
          unrolled<D>([&](auto d) RECON_INLINE_LAMBDA { offset[d] = T(row.offset[d][node[d]]); });
          if (row.form == WeightForm::tensor_product)
            tensor_weights(batch, a);
          else
            radial_weights(batch, first, offset);
          Scalar* to = to_row + static_cast<std::size_t>(g + a) * node_size;
          store(load(to) + count(batch), to);
          to += L;
          add_components<M, with_moments>(row.components, batch.q, batch.stride, batch.w,
                                          batch.slots, offset, to);
          for (int i = with_moments; i < row.components; i += alone) {
            const std::ptrdiff_t skip = (M + i * m) * L;
            add_components<0, alone>(row.components - i, batch.q + skip, batch.stride, batch.w,
                                     batch.slots, offset, to + skip);
          }
        }
      }
  }

  static void add(const CellRow<Scalar>& row) {
    for (int g = 0; g < row.groups; ++g)
      for (std::uint32_t first = row.begin[g]; first < row.begin[g + 1]; first += slots_per_batch) {
        const std::uint32_t left = row.begin[g + 1] - first;
        const int slots = left < slots_per_batch ? static_cast<int>(left) : slots_per_batch;
        add_batch(prepare(row, first, slots), first, g);
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
      const auto safe = matrix.factor(moments, load(nodes.noise + j * L));
      store(select(safe && load(from) >= T(Scalar(m)), T(1), T(0)), out);
      store(matrix.rcond(), out + L);
      store(matrix.amplification(), out + 2 * L);
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
