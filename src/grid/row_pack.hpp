// What the parts of the row kernel share: packs and their loops, and how many numbers a node has.
#pragma once

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"  // g++ 12 means its own _mm512_sqrt_pd
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

#include <type_traits>

#include "grid/row_kernel.hpp"
#include "recon/basis/monomials.hpp"
#include "recon/core/pack.hpp"
#include "recon/core/unroll.hpp"

namespace recon::RECON_SET {
namespace {

// unroll() rather than loops: sums stay in registers only if everything is inlined
// into one function.
using recon::detail::all_lanes, recon::detail::any_lane, recon::detail::larger,
    recon::detail::select, recon::detail::smaller;
using recon::detail::unroll;

template <class Scalar>
RECON_INLINE Pack<Scalar> load(const Scalar* from) {
  return Pack<Scalar>(from, std::experimental::vector_aligned);
}
template <class Scalar>
RECON_INLINE void store(const std::type_identity_t<Pack<Scalar>>& value, Scalar* to) {
  value.copy_to(to, std::experimental::vector_aligned);
}

// The sizes of a fit of degree R.
template <class Scalar, int D, int R>
struct NodeSizes {
  using Powers = Monomials<D, 2 * R>;
  static constexpr int L = static_cast<int>(Pack<Scalar>::size());  // lanes
  static constexpr int M = Powers::size;                            // moments
  static constexpr int m = monomial_count(D, R);                    // terms
};

}  // namespace
}  // namespace recon::RECON_SET
