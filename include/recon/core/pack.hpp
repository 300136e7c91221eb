// A pack: as many floats or doubles as fit a vector register, one target in each.
//
// std::experimental::simd of the standard library (Parallelism TS 2), with the native width of the
// instruction set that the including file is compiled for.
#pragma once

#include <experimental/simd>

#include "recon/core/lanes.hpp"

#if defined(__clang__) && defined(__AVX512F__)
#error \
    "clang with libstdc++'s simd assigns to the wrong AVX-512 lanes: use g++, or no -march flags (recon chooses instruction sets itself)"
#endif

namespace recon {

template <class Scalar>
using Pack = std::experimental::native_simd<Scalar>;

template <class S, class Abi>
struct LaneTraits<std::experimental::simd<S, Abi>> {
  using Scalar = S;
  using Mask = std::experimental::simd_mask<S, Abi>;
  static constexpr int lanes = static_cast<int>(std::experimental::simd<S, Abi>::size());

  using T = std::experimental::simd<S, Abi>;
  static T select(const Mask& mask, const T& a, T b) {
    std::experimental::where(mask, b) = a;
    return b;
  }
};

template <class S, class Abi>
struct MaskTraits<std::experimental::simd_mask<S, Abi>> {
  using Mask = std::experimental::simd_mask<S, Abi>;
  static bool any(const Mask& mask) { return std::experimental::any_of(mask); }
  static bool all(const Mask& mask) { return std::experimental::all_of(mask); }
};

}  // namespace recon
