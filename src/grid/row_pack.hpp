// What the parts of the row kernel share: packs and their loops, and how many numbers a node has.
#pragma once

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"  // g++ 12 means its own _mm512_sqrt_pd
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

#include <type_traits>
#include <utility>

#include "grid/row_kernel.hpp"
#include "recon/basis/monomials.hpp"
#include "recon/core/pack.hpp"

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

template <class Scalar>
RECON_INLINE Pack<Scalar> load(const Scalar* from) {
  return Pack<Scalar>(from, std::experimental::vector_aligned);
}
template <class Scalar>
RECON_INLINE void store(const std::type_identity_t<Pack<Scalar>>& value, Scalar* to) {
  value.copy_to(to, std::experimental::vector_aligned);
}

// Of a fit of degree R.
template <class Scalar, int D, int R>
struct NodeSizes {
  using Powers = Monomials<D, 2 * R>;
  static constexpr int L = static_cast<int>(Pack<Scalar>::size());  // lanes
  static constexpr int M = Powers::size;                            // moments
  static constexpr int m = monomial_count(D, R);                    // terms
};

}  // namespace
}  // namespace recon::RECON_SET
