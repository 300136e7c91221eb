// One function for several instruction sets.
//
// Files named *.simd.cpp are compiled once per set (cmake/ReconTargets.cmake), with RECON_SET being
// the name of the set. What they define stands in the namespace recon::RECON_SET:
//
//   sum.hpp        RECON_FOR_EACH_SET(float sum(const float*, int))
//   sum.simd.cpp   namespace recon::RECON_SET { float sum(const float* x, int n) { ... } }
//   a caller       RECON_DISPATCH(set, sum)(x, n)    with set = resolved(InstructionSet)
//
// A template or inline function of ordinary types that such a file instantiates is a danger: the
// linker keeps one copy for the whole program, perhaps the one with instructions that the processor
// lacks. Kernels are therefore templates over Pack types (core/pack.hpp), which differ by set, or
// stand in that namespace; the test structure.no_shared_symbols looks for others.
#pragma once

#include "recon/core/instruction_set.hpp"

#ifdef RECON_AVX2_SET
#define RECON_IN_AVX2(...) \
  namespace avx2 {         \
  __VA_ARGS__;             \
  }
#define RECON_IF_AVX2(set, ...) (set) == ::recon::InstructionSet::avx2 ? &avx2::__VA_ARGS__:
#else
#define RECON_IN_AVX2(...)
#define RECON_IF_AVX2(set, ...)
#endif

#ifdef RECON_AVX512_SET
#define RECON_IN_AVX512(...) \
  namespace avx512 {         \
  __VA_ARGS__;               \
  }
#define RECON_IF_AVX512(set, ...) (set) == ::recon::InstructionSet::avx512 ? &avx512::__VA_ARGS__:
#else
#define RECON_IN_AVX512(...)
#define RECON_IF_AVX512(set, ...)
#endif

#define RECON_FOR_EACH_SET(...) \
  namespace generic {           \
  __VA_ARGS__;                  \
  }                             \
  RECON_IN_AVX2(__VA_ARGS__)    \
  RECON_IN_AVX512(__VA_ARGS__)
#define RECON_DISPATCH(set, ...) \
  (RECON_IF_AVX512(set, __VA_ARGS__) RECON_IF_AVX2(set, __VA_ARGS__) & generic::__VA_ARGS__)
